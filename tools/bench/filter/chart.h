// SPDX-License-Identifier: Apache-2.0
// The results of malha bench filter as a chart, drawn by gnuplot.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "tools/bench/filter/row.h"

namespace malha::bench {

/// Draws ms per product over unknowns into FOLDER/filter.svg and .png: dense (float and int16), sparse, and OpenBLAS,
/// on each number of threads. Gives back why it could not, or nothing.
std::string draw_filter_chart(const std::vector<FilterRow>& rows, const std::filesystem::path& folder);

}  // namespace malha::bench
