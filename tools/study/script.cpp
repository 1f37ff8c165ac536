// SPDX-License-Identifier: Apache-2.0
#include "tools/study/script.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <iostream>

#include "malha/error.h"
#include "tools/exit_status.h"

namespace malha {

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

/// The words that name the backend; none for the host.
std::vector<std::string> backend_words(const StudyOptions& options) {
  std::vector<std::string> words;
  if (options.backend != "openmp") words.insert(words.end(), {"--backend", options.backend});
  if (!options.machine.empty()) words.insert(words.end(), {"--for", options.machine});
  return words;
}

/// The options as words of the script.
std::vector<std::string> script_words(const StudyOptions& options) {
  std::vector<std::string> words;
  if (options.quick) words.push_back("--quick");
  if (options.keep) words.push_back("--keep");
  if (!options.out.empty()) words.insert(words.end(), {"--out", options.out.string()});
  if (!options.share.empty()) words.insert(words.end(), {"--share", options.share});
  if (!options.merge.empty()) words.push_back("--merge");
  for (const fs::path& folder : options.merge) words.push_back(folder.string());
  const std::vector<std::string> backend = backend_words(options);
  words.insert(words.end(), backend.begin(), backend.end());
  if (options.name == "all") words.push_back("--all");  // after this study the script runs those that follow it
  return words;
}

}  // namespace

const std::vector<Study>& studies() {
  static const std::vector<Study> all{
      {"accuracy", "Error over cost of every method, with explicit and implicit integrators for comparison"},
      {"published", "Published results, repeated with the papers' parameters, beside malha's"},
      {"stability", "Settings with which each method fails, how it fails, and remedies"},
      {"scaling", "Speed-up by more threads, pass by pass, on the same body and on one that grows"},
      {"parsimony", "Time, memory and kernel launches that each feature adds to a scene"},
      {"size", "Time, memory and set-up per particle, and errors, from 289 particles to 4 million"},
      {"validation", "malha against experiments, closed forms and boundary value problems of the literature"},
      {"results", "Page that shows what other studies have found in one look, results.html; all ends with it"},
  };
  return all;
}

int exec_study(const StudyOptions& options) {
  const std::vector<std::string> backend = backend_words(options);
  if (options.name == "all" && !backend.empty())
    refuse("malha study all", "", "\"" + backend[0] + " " + backend[1] + "\"",
           "accuracy and scaling, which run on any backend; the others run on the host");
  const std::string name = options.name == "all" ? studies()[0].name : options.name;
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
  std::vector<std::string> words = script_words(options);
  words.insert(words.begin(), {python(), (folder / (name + ".py")).string()});
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  std::cout.flush();
  execvp(arguments[0], arguments.data());
  std::cerr << "malha study " << options.name << ": found no Python that starts as " << words[0] << " ("
            << std::strerror(errno)
            << "); to install one: sudo apt-get install python3 python3-numpy python3-scipy python3-matplotlib\n";
  return kFailed;
}

}  // namespace malha
