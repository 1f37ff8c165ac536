// SPDX-License-Identifier: Apache-2.0
// Lying bars, a row of the study "parsimony" each.
#pragma once
#include <string>

#include "tools/study/rows.h"
#include "tools/study/study.h"

namespace malha::study {

/// gnuplot's settings of the rows' features beside the bars, the first on top.
std::string feature_tics(const Json& rows);

/// A number of each row as bars that begin at `from`; where it is less there is no bar. `title`: "" for none.
bench::Series feature_bars(const Json& rows, const std::string& key, double scale, double from,
                           const std::string& colour, const std::string& title);

/// The time of each rung by pass; the last, next to which all others would be as nothing, is in words alone.
Chart ladder_chart(const Json& ladder);

}  // namespace malha::study
