// The command's part of tools/measures.h: it becomes malha_measures, which lies beside it.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <iostream>

#include "host/base/shown.h"
#include "tools/arguments.h"
#include "tools/measures.h"

namespace malha {

namespace fs = std::filesystem;

std::optional<int> refuse_measure(int, char** argv) {
  const std::string first = argv[1];
  if (first != "tune" && first != "bench" && first != "study") return std::nullopt;
  const fs::path folder = fs::read_symlink("/proc/self/exe").parent_path(), program = folder / "malha_measures";
  if (!fs::exists(program)) {
    const bool built_here = fs::exists(folder / "CMakeCache.txt");
    std::cerr << "malha " << first << ": tune, bench and study are not built yet; build them with: "
              << (built_here ? "cmake --build '" + folder.string() + "' --target malha_measures"
                             : "tools/build, and install again")
              << "\n";
    return kFailed;
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

int measure(const Arguments&, const std::atomic<bool>&) { return kFailed; }  // refuse_measure() has ended this program

}  // namespace malha
