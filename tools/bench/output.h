// Where the results of a benchmark go: the screen, and files in a folder.
#pragma once
#include <cstdio>
#include <filesystem>
#include <string>

namespace malha::bench {

/// Prints, and keeps what was printed.
class Printer {
 public:
  void operator()(const std::string& lines);
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

/// NAME.json (the rows), NAME_machine.json and NAME.txt in the folder, and the rows once more in `json`, if that is
/// not empty.
class Files {
 public:
  Files(const std::filesystem::path& folder, const std::string& name, const std::filesystem::path& json);

  /// Whether they can be written is known now, not after minutes. Throws std::runtime_error.
  void prepare() const;
  void write(const std::string& rows, const std::string& machine, const std::string& table) const;
  /// Says where everything is.
  void list() const;
  /// And the chart. `no_chart`: why there is none, or nothing.
  void list(const std::string& no_chart) const;

 private:
  std::filesystem::path folder_;
  std::string name_;
  std::filesystem::path rows_, machine_, table_, json_;
};

/// A few words and numbers as printf formats them.
template <class... Values>
std::string formatted(const char* format, Values... values) {
  char text[512];
  std::snprintf(text, sizeof text, format, values..., 0);  // never the format alone, of which clang warns
  return text;
}

}  // namespace malha::bench
