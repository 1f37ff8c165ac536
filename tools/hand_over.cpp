// SPDX-License-Identifier: Apache-2.0
// The command's part of tools/measures.h: it becomes the program beside it that does what is asked.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "malha/text.h"
#include "tools/arguments.h"
#include "tools/measures.h"

namespace malha {

namespace fs = std::filesystem;

namespace {

/// A program beside the command, and which commands it does.
struct Other {
  const char* program;
  std::vector<std::string> commands;
  const char* missing;  // what is said where it is not there: before the words on how to build it
};
const std::array kOthers{
    Other{"malha_measures", {"tune", "bench", "study"}, "tune, bench and study are not built yet"},
    Other{"malha_view", {"view"}, "the window is not built yet; it needs libglfw3-dev, libimgui-dev and libepoxy-dev"}};

}  // namespace

std::optional<int> hand_over_or_refuse(int argc, char** argv) {
  const std::string first = argv[1];
  const auto does = [&](const Other& other) { return std::ranges::count(other.commands, first) > 0; };
  const auto other = std::find_if(kOthers.begin(), kOthers.end(), does);
  if (other == kOthers.end()) return std::nullopt;
  const fs::path folder = fs::read_symlink("/proc/self/exe").parent_path(), program = folder / other->program;
  if (!fs::exists(program)) {
    const bool built_here = fs::exists(folder / "CMakeCache.txt");
    const bool asks_for_help = argc > 2 && (std::string(argv[2]) == "--help" || std::string(argv[2]) == "-h");
    (asks_for_help ? std::cout : std::cerr)
        << "malha " << first << ": " << other->missing << "; to build: "
        << (built_here ? "cmake --build '" + folder.string() + "' --target " + other->program
                       : "tools/build, and install again")
        << "\n";
    return asks_for_help ? kDone : kFailed;
  }
  execv(program.c_str(), argv);
  std::cerr << "malha " << first << ": cannot start " << program.string() << ": " << std::strerror(errno) << "\n";
  return kFailed;
}

void add_measures(CLI::App& app, Arguments&) {
  app.add_subcommand("tune", kTuneHelp);
  app.add_subcommand("bench", kBenchHelp);
  app.add_subcommand("study", kStudyHelp);
}

/// Never called: hand_over_or_refuse() has ended this program.
int measure(const Arguments&, const std::atomic<bool>&) { return kFailed; }

}  // namespace malha
