// SPDX-License-Identifier: Apache-2.0
// Output of a benchmark's results: on the screen, and as files in a folder.
#pragma once
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "tools/bench/counts.h"
#include "tools/bench/status.h"

namespace malha::bench {

/// Writes NAME.json (the rows), NAME_machine.json and NAME.txt (the printed table) into the folder, and the rows also
/// into `options.json`.
class Output {
 public:
  /// Checks that all files can be written, before minutes of measurements. Throws std::runtime_error if not.
  Output(const std::string& name, const MeasuringOptions& options);

  nlohmann::ordered_json facts;  // of the machine, see facts.h

  /// Shows what is being measured, and the finished part of the whole benchmark, 0 to 1.
  void show_progress(const std::string& what, double part) { status_.show(what, part); }
  void print(const std::string& lines);
  void write(const nlohmann::ordered_json& rows) const;
  /// Prints the paths of the files.
  void list() const;
  /// Prints the chart's path; or `no_chart`, the reason why there is none, unless it is empty.
  void list_chart(const std::string& no_chart) const;

  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_;
  std::string name_, printed_;
  std::filesystem::path rows_, machine_, table_, json_;
  Status status_;
};

/// Makes the file's folder. Throws std::runtime_error if the file cannot be written.
void require_writable(const std::filesystem::path& file);

/// Formats like printf, at most 511 characters.
template <class... Values>
std::string formatted(const char* format, Values... values) {
  char text[512];
  std::snprintf(text, sizeof text, format, values..., 0);  // the extra argument: clang warns of a format without any
  return text;
}

}  // namespace malha::bench
