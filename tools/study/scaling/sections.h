// SPDX-License-Identifier: Apache-2.0
// What the study "scaling" says of its rows.
#pragma once
#include "tools/study/study.h"

namespace malha::study {

/// `rows`: of {kind: "strong" | "weak" | "launch"}; see scaling.cpp.
std::vector<Section> scaling_sections(const Json& rows, const std::string& pinning);

/// The same of rows that were measured on a device, of which more threads are none.
Section scaling_on_device(const Json& rows);

}  // namespace malha::study
