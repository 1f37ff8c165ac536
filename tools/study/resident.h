// SPDX-License-Identifier: Apache-2.0
// How much of the machine's memory this process holds, where Linux says so.
#pragma once
#include <optional>

namespace malha::study {

/// Bytes held now, after what was given up went back to the system; none: not known.
std::optional<double> resident_bytes();

/// The most that was held since reset_peak(); none: the system does not say or does not forget (getrusage never does).
std::optional<double> peak_bytes();
void reset_peak();

}  // namespace malha::study
