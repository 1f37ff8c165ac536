// SPDX-License-Identifier: Apache-2.0
// The step of studies whose cases do not say otherwise.
#pragma once

namespace malha::study {

inline constexpr double kFrame = 1.0 / 60;  // s; methods divide it into substeps

}  // namespace malha::study
