// SPDX-License-Identifier: Apache-2.0
// The methods of the study "accuracy", each at several costs.
#pragma once
#include <string>
#include <vector>

#include "tools/study/accuracy/cases.h"

namespace malha::study {

enum class Integrator { Malha, ExplicitEuler, SymplecticEuler, Rk4, BackwardEuler };

struct Method {
  std::string series;  // as legends name it; what a series varies is said in it
  Integrator integrator = Integrator::Malha;
  SolverSpec solver;        // of malha; its substeps a frame are those of all
  bool compliant = true;    // otherwise PBD of stiffness 1
  bool variant = false;     // in the chart of filters alone
  double end_time = 1e9;    // s: what comes later is not run
  std::string key() const;  // all of it in words
};

/// All that a case is run with, series by series, each from cheap to dear.
std::vector<Method> accuracy_methods(const AccuracyCase& test_case, bool quick);

}  // namespace malha::study
