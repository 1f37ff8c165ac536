// SPDX-License-Identifier: Apache-2.0
// Sentences and tables of the study "accuracy", computed from its points.
#pragma once
#include <string>

#include "tools/study/accuracy/cell.h"
#include "tools/study/accuracy/points.h"
#include "tools/study/study.h"

namespace malha::study {

/// Uncertainty (m) above which a motion counts as chaotic or its reference as not converged.
constexpr double kChaotic = 1e-3;

std::string truth_sentence(const AccuracyCase& test_case, const Truth& truth);

/// "1e-2 m: A (2x1, 0.3 ms); ...": the cheapest points, each with the smallest power of ten of the error for which it
/// is the cheapest. `uncertainty`: of the true motion, m; smaller errors are left out.
std::string cheapest_list(const Points& points, double uncertainty, double Point::*cost, const char* unit,
                          bool malha_only);

/// The cheapest methods for each power of ten of the error that any method reaches.
Table cheapest_table(const Points& points, double uncertainty);

/// The orders at which the errors of the series fall with their sweeps; empty if none falls regularly.
std::string orders_sentence(const Points& points);

/// The smallest error of each series, and its energy drift.
std::string best_sentence(const Points& points);

/// The number of substeps beyond which float gets worse; empty if it does not.
std::string float_sentence(const Points& points);

/// The errors of momentum and angular momentum of each series at its highest cost.
std::string momenta_sentence(const Points& points, double time);

/// The energy drift of explicit Euler beside that of symplectic Euler; empty if it was not run or always diverged.
std::string growth_sentence(const Points& points, double time);

std::string diverged_sentence(const AccuracyCase& test_case, const Json& rows);

/// All runs of a case: errors at each time, energy and momenta, and costs.
Table runs_table(const AccuracyCase& test_case, const Json& rows);

}  // namespace malha::study
