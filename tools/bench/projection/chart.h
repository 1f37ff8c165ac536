// SPDX-License-Identifier: Apache-2.0
// The results as a chart, drawn by gnuplot.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "tools/bench/projection/row.h"

namespace malha::bench {

/// Draws ns per projection over particles a side into FOLDER/projection.svg and .png: malha 10x1 on each number of
/// threads, Bullet, and the floors. Gives back why it could not, or nothing.
std::string draw_chart(const std::vector<Row>& rows, const std::filesystem::path& folder);

}  // namespace malha::bench
