// SPDX-License-Identifier: Apache-2.0
// malha study: runs studies and writes their results into a folder.
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
  std::vector<std::string> names;  // of studies in the registry
  bool quick = false;
  bench::RunsOn on;                          // backend of malha's cells
  bool keep = false;                         // accept cells of other builds of malha
  std::filesystem::path out;                 // empty: out/study or out/study_quick
  std::optional<Share> share;                // measure only this share
  std::vector<std::filesystem::path> merge;  // folders with journals of shares; empty: measure missing cells
};

/// Runs the chosen studies that are not scripts. Writes NAME.csv, NAME.json, NAME_*.svg and .png of each study, replays
/// of some, and index.html with all studies of the folder; for a share only the journals. Returns false if merged
/// shares lack cells; a message then goes to standard error and nothing is written. Throws Interrupted if `stop` is
/// set, InputError from merged_shares() and for a study that does not run on the backend, and std::runtime_error if a
/// file cannot be written.
bool run(const Options& options, const std::atomic<bool>& stop);

}  // namespace malha::study
