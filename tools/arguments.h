// SPDX-License-Identifier: Apache-2.0
// The command line: what may be asked, what it means, and one-line answers to what cannot be meant.
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

/// Absent: as the scene says.
struct Arguments {
  std::string command;  // "run"
  std::string scene;    // -: on standard input
  std::string backend = "openmp";
  std::string machine;            // what patches are cut for; empty: the CPU, and nothing is said about it
  int threads = 0;                // 0: as many as OpenMP offers
  std::string out;                // empty: out/SCENE; of picture: the folder of results; of page: the file
  std::vector<std::string> runs;  // of page: two folders of results
  std::optional<std::int64_t> steps;
  std::optional<double> seconds;
  std::optional<int> every, picture_every, checkpoint_every;
  bool picture = false, no_picture = false, page = false, no_page = false;
  std::vector<std::string> formats;
  bool resume = false, quiet = false;
  bool json = false;  // likewise
  std::string typed;  // what the user typed, without --resume

  /// For messages, and for names of results.
  std::string scene_label() const { return scene == "-" ? "standard input" : scene; }
  /// Of the folder of its results in out/: the file's without ".json", where that is no folder above.
  std::string scene_name() const {
    if (scene == "-") return "standard_input";
    const std::filesystem::path file = std::filesystem::path(scene).filename(), name = file.stem();
    return (name == "." || name == ".." ? file : name).string();
  }

  BenchArguments bench;
  study::Options study;
  TuneArguments tune;
};

/// Fills `arguments`. Where there is nothing to run (--help, --version, or an error, which goes to standard error as
/// one line) it gives the exit status instead.
std::optional<int> parse_arguments(int argc, char** argv, Arguments& arguments);

/// As a shell takes it back, in quotes where it needs them.
std::string shell_word(const std::string& word);

/// The word SCENE, of commands that take one.
void add_scene(CLI::App& command, Arguments& arguments);

}  // namespace malha
