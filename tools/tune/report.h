// SPDX-License-Identifier: Apache-2.0
// Output of malha tune as text and JSON.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "tools/tune/tune.h"

namespace malha::tuning {

/// Returns a table of the reference and the trials, with the best one marked, and the methods that were left out.
std::string tune_table(const TuneResult& tuned, const TuneOptions& options);

/// Returns one line that says why there is no tuned scene.
std::string why_not_tuned(const TuneResult& tuned, const TuneOptions& options);

/// Returns the same with all numbers: {error_m, seconds, threads, reference: {...}, trials: [...], best, left_out}.
nlohmann::ordered_json tune_json(const TuneResult& tuned, const TuneOptions& options);

}  // namespace malha::tuning
