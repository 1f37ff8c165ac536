// SPDX-License-Identifier: Apache-2.0
// The command's implementation of tools/measures.h: it executes the sibling program that implements the subcommand.
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
#include "tools/completion.h"
#include "tools/measures.h"

namespace malha {

namespace fs = std::filesystem;

namespace {

/// A program in the command's folder with the subcommands that it implements.
struct SiblingProgram {
  const char* program;
  std::vector<std::string> commands;
  const char* missing;  // first part of the message if it is missing
};
const std::array kPrograms{
    SiblingProgram{"malha_measures", {"tune", "bench", "study"}, "tune, bench and study are not built yet"},
    SiblingProgram{
        "malha_view", {"view"}, "the window is not built yet; it needs libglfw3-dev, libimgui-dev and libepoxy-dev"}};

}  // namespace

std::optional<int> exec_or_refuse(int argc, char** argv) {
  // The words of a command are completed by the program that implements it.
  const bool completes = std::string(argv[1]) == kCompleteWord;
  if (completes && argc < 4) return std::nullopt;
  const std::string first = argv[completes ? 2 : 1];
  const auto does = [&](const SiblingProgram& sibling) { return std::ranges::count(sibling.commands, first) > 0; };
  const auto sibling = std::find_if(kPrograms.begin(), kPrograms.end(), does);
  if (sibling == kPrograms.end()) return std::nullopt;
  const fs::path folder = fs::read_symlink("/proc/self/exe").parent_path(), program = folder / sibling->program;
  if (!fs::exists(program)) {
    if (completes) return kDone;
    const bool built_here = fs::exists(folder / "CMakeCache.txt");
    const bool wants_help = argc > 2 && (std::string(argv[2]) == "--help" || std::string(argv[2]) == "-h");
    (wants_help ? std::cout : std::cerr) << "malha " << first << ": " << sibling->missing << "; to build: "
                                         << (built_here ? "cmake --build '" + folder.string() + "' --target " +
                                                              sibling->program
                                                        : "tools/build, and install again")
                                         << "\n";
    return wants_help ? kDone : kFailed;
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

/// Never called, because exec_or_refuse() has replaced this program.
int measure(const Arguments&, const std::atomic<bool>&) { return kFailed; }

}  // namespace malha
