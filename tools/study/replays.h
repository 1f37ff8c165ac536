// SPDX-License-Identifier: Apache-2.0
// Runs that the page of the studies links to: two of a section's scenes beside each other, to be played in a browser.
#pragma once
#include <atomic>
#include <filesystem>
#include <functional>
#include <string>

#include "tools/study/study.h"

namespace malha::study {

/// STUDY_NAME.html
std::string replay_file(const Study& study, const Replay& replay);

/// Leaves the pages of all sections in the folder. A run that diverges ends there. Throws Interrupted where `stop` is
/// set; std::runtime_error where something cannot be written.
void write_replays(const std::filesystem::path& folder, const Study& study, const Findings& findings,
                   const std::function<void(const std::string&)>& show, const std::atomic<bool>& stop);

}  // namespace malha::study
