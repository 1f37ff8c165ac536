// SPDX-License-Identifier: Apache-2.0
// Printed table of malha bench projection.
#pragma once
#include <string>
#include <vector>

#include "tools/bench/projection/row.h"

namespace malha::bench {

/// The table of a case, followed by lines that compare its rows. All `rows` are of that case. `bullet_left_out`: the
/// reason why Bullet has no row; empty if it has one.
std::string table(const std::vector<Row>& rows, const std::string& bullet_left_out);

}  // namespace malha::bench
