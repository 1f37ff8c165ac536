// SPDX-License-Identifier: Apache-2.0
// Exception that ends a study when the user stops it.
#pragma once

namespace malha::study {

struct Interrupted {};

}  // namespace malha::study
