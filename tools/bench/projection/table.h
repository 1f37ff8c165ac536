// SPDX-License-Identifier: Apache-2.0
// The results as a person reads them.
#pragma once
#include <string>
#include <vector>

#include "tools/bench/projection/row.h"

namespace malha::bench {

/// A case's rows under its heading, and what they say beside each other. `rows` are all of one case.
/// `bullet_left_out`: why Bullet has none, or nothing.
std::string table(const std::vector<Row>& rows, const std::string& bullet_left_out);

}  // namespace malha::bench
