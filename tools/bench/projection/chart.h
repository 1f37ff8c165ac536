// SPDX-License-Identifier: Apache-2.0
// Chart of the results of malha bench projection.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "tools/bench/projection/row.h"

namespace malha::bench {

/// Draws ns per projection over particles a side into FOLDER/projection.svg and .png: malha 10x1 on each number of
/// threads, Bullet, and the floors. Returns the reason of a failure, or an empty string.
std::string draw_chart(const std::vector<Row>& rows, const std::filesystem::path& folder);

}  // namespace malha::bench
