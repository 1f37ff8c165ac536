// malha study: runs studies and leaves their results in a folder.
#pragma once
#include <atomic>
#include <filesystem>
#include <string>
#include <vector>

#include "tools/study/interrupted.h"

namespace malha::study {

struct Options {
  std::vector<std::string> names;  // of the registry
  bool quick = false;
  bool keep = false;          // take cells of another build of malha too
  std::filesystem::path out;  // empty: out/study, out/study_quick
};

/// Leaves NAME.csv, NAME.json, NAME_*.svg and .png for each, replays of some, and index.html with all studies that the
/// folder holds.
/// Throws Interrupted where `stop` is set; std::runtime_error where something cannot be written.
void run(const Options& options, const std::atomic<bool>& stop);

}  // namespace malha::study
