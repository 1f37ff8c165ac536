// SPDX-License-Identifier: Apache-2.0
// How a study ends that the user stopped.
#pragma once

namespace malha::study {

struct Interrupted {};

}  // namespace malha::study
