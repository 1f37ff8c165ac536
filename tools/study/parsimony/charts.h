// SPDX-License-Identifier: Apache-2.0
// Bar charts of the study "parsimony": a horizontal bar per row.
#pragma once
#include <string>

#include "tools/study/rows.h"
#include "tools/study/study.h"

namespace malha::study {

/// gnuplot settings that write the rows' features beside the bars, the first on top.
std::string feature_tics(const Json& rows);

/// Bars from `from` to a number of each row; smaller numbers have no bar. `title`: "" for none.
bench::Series feature_bars(const Json& rows, const std::string& key, double scale, double from,
                           const std::string& colour, const std::string& title);

/// The time of each rung by pass. The last rung, which would dwarf all others, is only named in the title.
Chart ladder_chart(const Json& ladder);

}  // namespace malha::study
