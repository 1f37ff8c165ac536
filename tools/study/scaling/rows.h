// SPDX-License-Identifier: Apache-2.0
// Queries of the rows of the study "scaling", and the sections about passes, bandwidth and launches.
#pragma once
#include <string>
#include <vector>

#include "tools/study/rows.h"
#include "tools/study/study.h"

namespace malha::study {

/// Rows of a kind ("strong", "weak") that were run, in a group for each method and side, by increasing threads.
std::vector<std::vector<Json>> scaling_groups(const Json& rows, const std::string& kind);

std::string method_of(const Json& row);
std::string count_of(const Json& row);  // "10,000"

/// A sentence for each row that was left out: " PBD, N = 1000, is left out: reason."
std::string scaling_left_out(const Json& rows, const std::string& kind);
/// A sentence about the bytes that are counted.
inline constexpr const char* kRequiredBytes =
    "PBD must read x, w and v and write x and v of every particle in every substep, 52 bytes; Desbrun's pass through "
    "the filter reads a sparse factor twice, a dense one once.";
/// Table fields: GB/s of the bytes that must move, GB/s of the triad, and their ratio.
std::vector<std::string> bandwidth_cells(const Json& row);

Section scaling_passes(const Json& rows);
Section scaling_bandwidth(const Json& rows);
Section scaling_launches(const Json& rows);

}  // namespace malha::study
