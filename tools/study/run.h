// SPDX-License-Identifier: Apache-2.0
// malha study: runs studies and leaves their results in a folder.
#pragma once
#include <atomic>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tools/bench/runs_on.h"
#include "tools/study/interrupted.h"
#include "tools/study/shares.h"

namespace malha::study {

struct Options {
  std::vector<std::string> names;  // of the registry
  bool quick = false;
  bench::RunsOn on;                          // where malha's cells run
  bool keep = false;                         // take cells of another build of malha too
  std::filesystem::path out;                 // empty: out/study, out/study_quick
  std::optional<Share> share;                // that is measured, and nothing else is done
  std::vector<std::filesystem::path> merge;  // folders with journals of shares; empty: what is not kept is measured
};

/// Leaves NAME.csv, NAME.json, NAME_*.svg and .png for each, replays of some, and index.html with all studies that the
/// folder holds; of a share the journals alone. False, with words on standard error and nothing written, where the
/// shares that are merged lack cells.
/// Throws Interrupted where `stop` is set; InputError of merged_shares() and for a study that does not run there;
/// std::runtime_error where something cannot be written.
bool run(const Options& options, const std::atomic<bool>& stop);

}  // namespace malha::study
