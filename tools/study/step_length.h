// SPDX-License-Identifier: Apache-2.0
// Default time step of the studies.
#pragma once

namespace malha::study {

inline constexpr double kFrame = 1.0 / 60;  // s; methods divide it into substeps

}  // namespace malha::study
