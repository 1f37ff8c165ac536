// SPDX-License-Identifier: Apache-2.0
// Replays that the page of the studies links to: two of a section's scenes side by side, played in a browser.
#pragma once
#include <atomic>
#include <filesystem>
#include <functional>
#include <string>

#include "tools/study/study.h"

namespace malha::study {

/// The file name of a replay: STUDY_NAME.html.
std::string replay_file(const Study& study, const Replay& replay);

/// Writes the replays of all sections into the folder. A run that diverges ends early. Throws Interrupted if `stop` is
/// set, and std::runtime_error if a file cannot be written.
void write_replays(const std::filesystem::path& folder, const Study& study, const Findings& findings,
                   const std::function<void(const std::string&)>& show, const std::atomic<bool>& stop);

}  // namespace malha::study
