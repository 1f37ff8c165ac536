// SPDX-License-Identifier: Apache-2.0
// Command line of malha: commands, options, and one-line error messages.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tools/exit_status.h"
#include "tools/measures/arguments_bench.h"
#include "tools/measures/arguments_study.h"
#include "tools/measures/arguments_tune.h"

namespace CLI {
class App;
}

namespace malha {

/// The parsed command line. Absent options leave the scene's values.
struct Arguments {
  std::string command;  // "run"
  std::string scene;    // path, or - for standard input
  std::string backend = "openmp";
  std::string machine;            // machine that patches are cut for; empty: the CPU, without an estimate
  int threads = 0;                // 0: OpenMP's default
  std::string out;                // empty: out/SCENE; of picture: the folder of results; of page: the file
  std::vector<std::string> runs;  // of page: two folders of results
  std::optional<std::int64_t> steps;
  std::optional<double> seconds;
  std::optional<int> every, picture_every, checkpoint_every;
  bool picture = false, no_picture = false, page = false, no_page = false;
  std::vector<std::string> formats;
  bool resume = false, quiet = false;
  bool json = false;  // of plan: print JSON
  std::string typed;  // what the user typed, without --resume

  /// Returns the name of the scene for messages.
  std::string scene_label() const { return scene == "-" ? "standard input" : scene; }
  /// Returns the name of the folder of its results in out/: the file's name without ".json", unless that is "." or
  /// "..".
  std::string scene_name() const {
    if (scene == "-") return "standard_input";
    const std::filesystem::path file = std::filesystem::path(scene).filename(), name = file.stem();
    return (name == "." || name == ".." ? file : name).string();
  }

  BenchArguments bench;
  StudyOptions study;
  TuneArguments tune;
};

/// Fills `arguments`. Returns an exit status if there is nothing to run: after --help, --version, or an error, which is
/// printed to standard error as one line.
std::optional<int> parse_arguments(int argc, char** argv, Arguments& arguments);

/// Quotes a word for a shell if necessary.
std::string shell_word(const std::string& word);

/// Adds the argument SCENE to a command.
void add_scene(CLI::App& command, Arguments& arguments);

}  // namespace malha
