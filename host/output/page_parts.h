// SPDX-License-Identifier: Apache-2.0
// Markup, style and scripts that every page has before and after its runs, compiled into the library from
// host/output/page/.
#pragma once

namespace malha {

extern const char* const kPageBeforeRuns;
extern const char* const kPageAfterRuns;

}  // namespace malha
