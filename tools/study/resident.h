// SPDX-License-Identifier: Apache-2.0
// Resident memory of this process, as Linux reports it.
#pragma once
#include <optional>

namespace malha::study {

/// Resident bytes now, after freed memory was returned to the system; empty if unknown.
std::optional<double> resident_bytes();

/// The peak of resident bytes since reset_peak(); empty if the system does not report or cannot reset it (getrusage
/// cannot).
std::optional<double> peak_bytes();
void reset_peak();

}  // namespace malha::study
