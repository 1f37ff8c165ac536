// SPDX-License-Identifier: Apache-2.0
// The command's view of the studies, which are scripts in Python: NAME.py beside the program, or in the share folder of
// its prefix.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace malha {

struct Study {
  std::string name;
  std::string what;  // one sentence about its subject, as in NAME.py
};

/// All studies, in the order in which `malha study all` runs them, and last the page of their results.
const std::vector<Study>& studies();

constexpr int kMostShares = 100'000;

struct StudyOptions {
  std::string name;  // of a study, or "all"
  bool quick = false, keep = false;
  std::filesystem::path out;  // empty: out/study or out/study_quick
  std::string share;          // "2/3"; empty: none
  std::vector<std::filesystem::path> merge;
  std::string backend = "openmp", machine;  // machine: empty: the default
};

/// Replaces this program by Python, which runs the script. Returns only if that fails: an exit status, after a message
/// that says what is missing. Throws InputError for all studies on a backend that not all have.
int exec_study(const StudyOptions& options);

}  // namespace malha
