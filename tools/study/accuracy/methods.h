// SPDX-License-Identifier: Apache-2.0
// Methods of the study "accuracy", each at several costs.
#pragma once
#include <string>
#include <vector>

#include "tools/study/accuracy/cases.h"

namespace malha::study {

enum class Integrator { Malha, ExplicitEuler, SymplecticEuler, Rk4, BackwardEuler };

struct Method {
  std::string series;  // name in legends, which says what varies within the series
  Integrator integrator = Integrator::Malha;
  SolverSpec solver;        // of malha; its substeps a frame hold for all integrators
  bool compliant = true;    // false: PBD of stiffness 1
  bool variant = false;     // appears only in the chart of filters
  double end_time = 1e9;    // s: how long the method is run
  std::string key() const;  // the whole method in words
};

/// All methods that run a case, series by series, each in order of increasing cost.
std::vector<Method> accuracy_methods(const AccuracyCase& test_case, bool quick);

}  // namespace malha::study
