// SPDX-License-Identifier: Apache-2.0
// Exception that ends malha tune when the user stops it.
#pragma once

namespace malha::tuning {

struct Interrupted {};

}  // namespace malha::tuning
