// SPDX-License-Identifier: Apache-2.0
// Sections of the study "scaling".
#pragma once
#include "tools/study/study.h"

namespace malha::study {

/// All sections for the host. `rows`: {kind: "strong" | "weak" | "launch", ...}, see scaling.cpp. `pinning`: the OpenMP
/// variables for thread affinity, in words.
std::vector<Section> scaling_sections(const Json& rows, const std::string& pinning);

/// The section for a device, where only the size varies.
Section scaling_on_device(const Json& rows);

}  // namespace malha::study
