// SPDX-License-Identifier: Apache-2.0
// Studies that are scripts in Python: NAME.py beside the program, or in the share folder of its prefix.
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <iostream>

#include "malha/error.h"
#include "tools/exit_status.h"
#include "tools/study/run.h"
#include "tools/study/study.h"

namespace malha::study {

namespace {

namespace fs = std::filesystem;

/// The first of these folders that has the file; empty if none has.
fs::path folder_with(const std::string& file, const std::vector<fs::path>& folders) {
  const auto found = std::find_if(folders.begin(), folders.end(), [&](const fs::path& folder) {
    std::error_code ignored;
    return fs::exists(folder / file, ignored);
  });
  return found == folders.end() ? fs::path() : *found;
}

/// MALHA_PYTHON, which malha's module sets; the Python for which that module was built; or the one on the PATH.
std::string python() {
  if (const char* named = std::getenv("MALHA_PYTHON"); named && *named) return named;
#ifdef MALHA_PYTHON_PROGRAM
  if (std::error_code ignored; fs::exists(MALHA_PYTHON_PROGRAM, ignored)) return MALHA_PYTHON_PROGRAM;
#endif
  return "python3";
}

}  // namespace

std::vector<std::string> scripts(const Options& options) {
  std::vector<std::string> chosen;
  for (const Study& study : studies())
    if (!study.run && std::find(options.names.begin(), options.names.end(), study.name) != options.names.end())
      chosen.push_back(study.name);
  if (chosen.empty() || (!options.share && options.merge.empty())) return chosen;
  if (options.names.size() == 1)
    refuse("malha study " + chosen[0], "", options.share ? "\"--share\"" : "\"--merge\"",
           "the studies that are not scripts in Python");
  return {};  // the other studies are shared without them
}

int exec_script(const std::string& name, const Options& options) {
  const fs::path here = fs::read_symlink("/proc/self/exe").parent_path(), prefix = here.parent_path();
  const fs::path folder = folder_with(name + ".py", {here / "study", prefix / "share/malha/study"});
  if (folder.empty()) {
    std::cerr << "malha study " << name << ": found no " << name << ".py; allowed: in " << (here / "study").string()
              << " or " << (prefix / "share/malha/study").string() << ", where a build and an installation put it\n";
    return kFailed;
  }
  std::vector<fs::path> modules{here, prefix};  // of a build; of a wheel
#ifdef MALHA_PYTHON_DIR
  modules.push_back(prefix / MALHA_PYTHON_DIR);
#endif
  if (const fs::path module = folder_with("malha.py", modules); !module.empty()) {
    const char* before = std::getenv("PYTHONPATH");
    setenv("PYTHONPATH", (module.string() + (before && *before ? ":" + std::string(before) : "")).c_str(), 1);
  }
  std::vector<std::string> words{python(), (folder / (name + ".py")).string()};
  if (options.quick) words.push_back("--quick");
  if (options.keep) words.push_back("--keep");
  if (!options.out.empty()) words.insert(words.end(), {"--out", options.out.string()});
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  std::cout.flush();
  execvp(arguments[0], arguments.data());
  std::cerr << "malha study " << name << ": found no Python that starts as " << words[0] << " (" << std::strerror(errno)
            << "); tools/setup python installs it, with numpy, scipy and matplotlib\n";
  return kFailed;
}

}  // namespace malha::study
