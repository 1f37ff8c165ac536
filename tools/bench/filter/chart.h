// SPDX-License-Identifier: Apache-2.0
// Chart of the results of malha bench filter.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "tools/bench/filter/row.h"

namespace malha::bench {

/// Draws ms per product over unknowns into FOLDER/filter.svg and .png: dense (float and int16), sparse, and OpenBLAS,
/// on each number of threads. Returns the reason of a failure, or an empty string.
std::string draw_filter_chart(const std::vector<FilterRow>& rows, const std::filesystem::path& folder);

}  // namespace malha::bench
