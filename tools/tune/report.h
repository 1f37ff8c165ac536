// SPDX-License-Identifier: Apache-2.0
// What malha tune says and writes.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "tools/tune/tune.h"

namespace malha::study {

/// Reference, a line a trial, the best one marked, and what was left out.
std::string tune_table(const Tuned& tuned, const TuneOptions& options);

/// Why there is no tuned scene: one line.
std::string why_not_tuned(const Tuned& tuned, const TuneOptions& options);

/// The same with all numbers: {error_m, seconds, threads, reference: {...}, trials: [...], best, left_out}.
nlohmann::ordered_json tune_json(const Tuned& tuned, const TuneOptions& options);

}  // namespace malha::study
