// SPDX-License-Identifier: Apache-2.0
// Sentences and tables of the study "accuracy", computed from its points.
#pragma once
#include <string>

#include "tools/study/accuracy/cell.h"
#include "tools/study/accuracy/points.h"
#include "tools/study/study.h"

namespace malha::study {

/// m, by which halving a step that is converged before changes a motion that is chaotic.
constexpr double kChaotic = 1e-3;

std::string truth_sentence(const AccuracyCase& test_case, const Truth& truth);

/// "1e-2 m: A (2x1, 0.3 ms); ...": who is the cheapest, each with the least power of ten of an error for which it is.
/// `known`: how well the true motion is known, m; below there is nothing to say.
std::string cheapest_list(const Points& points, double uncertainty, double Point::*cost, const char* unit,
                          bool malha_only);

/// A row for each power of ten that any method reaches.
Table cheapest_table(const Points& points, double uncertainty);

/// How the error of each series falls with its sweeps; empty where none does so regularly.
std::string orders_sentence(const Points& points);

/// The least error of each series, and what it does to the energy.
std::string best_sentence(const Points& points);

/// Where more substeps make float worse; empty where they do not.
std::string float_sentence(const Points& points);

/// The errors of momentum and angular momentum of each series at its dearest.
std::string momenta_sentence(const Points& points, double time);

/// What explicit Euler makes of the energy, beside symplectic Euler; empty where it was not run or always diverged.
std::string growth_sentence(const Points& points, double time);

std::string diverged_sentence(const AccuracyCase& test_case, const Json& rows);

/// Every run: errors at each time, what was kept, what it cost.
Table runs_table(const AccuracyCase& test_case, const Json& rows);

}  // namespace malha::study
