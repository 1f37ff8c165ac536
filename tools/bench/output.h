// SPDX-License-Identifier: Apache-2.0
// Where the results of a benchmark go: the screen, and files in a folder.
#pragma once
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "tools/bench/counts.h"
#include "tools/bench/status.h"

namespace malha::bench {

/// NAME.json (the rows), NAME_machine.json and NAME.txt (what was printed) in the folder, and the rows once more in
/// `options.json`.
class Output {
 public:
  /// Whether all can be written is known now, not after minutes. Throws std::runtime_error.
  Output(const std::string& name, const MeasuringOptions& options);

  nlohmann::ordered_json facts;  // about the machine

  /// What is being done now, and which part of everything is done: 0 to 1.
  void doing(const std::string& what, double part) { status_.show(what, part); }
  void print(const std::string& lines);
  void write(const nlohmann::ordered_json& rows) const;
  /// Says where everything is.
  void list() const;
  /// And the chart. `no_chart`: why there is none, or nothing.
  void list_chart(const std::string& no_chart) const;

  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_;
  std::string name_, printed_;
  std::filesystem::path rows_, machine_, table_, json_;
  Status status_;
};

/// Makes the file's folder. Throws where the file cannot be written.
void prepare(const std::filesystem::path& file);

/// A few words and numbers as printf formats them.
template <class... Values>
std::string formatted(const char* format, Values... values) {
  char text[512];
  std::snprintf(text, sizeof text, format, values..., 0);  // never the format alone, of which clang warns
  return text;
}

}  // namespace malha::bench
