// SPDX-License-Identifier: Apache-2.0
// The rows of the study "scaling", as its sections read them.
#pragma once
#include <string>
#include <vector>

#include "tools/study/rows.h"
#include "tools/study/study.h"

namespace malha::study {

/// Rows of a kind ("strong", "weak") that were run, a group a method and side, each from one thread on.
std::vector<std::vector<Json>> scaling_groups(const Json& rows, const std::string& kind);

std::string method_of(const Json& row);
std::string count_of(const Json& row);  // "10,000"

/// " PBD, N = 1000, is left out: why." of each that was; and what bytes are counted.
std::string scaling_left_out(const Json& rows, const std::string& kind);
inline constexpr const char* kRequiredBytes =
    "PBD must read x, w and v and write x and v of every particle in every substep, 52 bytes; Desbrun's pass through "
    "the filter reads a sparse factor twice, a dense one once.";
/// GB/s that must move, those that memory gives, and the share.
std::vector<std::string> bandwidth_cells(const Json& row);

Section scaling_passes(const Json& rows);
Section scaling_bandwidth(const Json& rows);
Section scaling_launches(const Json& rows);

}  // namespace malha::study
