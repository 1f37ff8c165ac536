// SPDX-License-Identifier: Apache-2.0
// The cases of the study "accuracy".
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "malha/scene.h"
#include "tools/study/reference/system.h"
#include "tools/study/step_length.h"

namespace malha::study {

struct AccuracyCase {
  std::string name, title, what;
  Scene scene;                                // its distance constraints have a compliance
  std::vector<double> times{1, 5};            // s, at which errors are measured, whole frames
  std::function<State(double t)> exact = {};  // in closed form; empty: a reference run
  int reference = 0;                          // its substeps a frame
  bool at_rest = false;                       // what is compared is where damped motion ends
  bool taut = false;                          // its springs' energy at the start holds it, and is none of the motion's
  bool tetrahedra = false;                    // not springs: the methods that know springs alone are left out
  // The dearest that is run (0: none): substeps or iterations a frame of malha's sweeps, filter and dense filter (0:
  // nor any other variant), refinements, and substeps of the integrators that are not malha's.
  int sweeps = 1024, solves = 256, dense = 64, refine = 16, euler = 1024, rk4 = 256, newton = 16;
  double newton_end_time = 1e9;     // s: what comes later is not run by Newton's method
  double discretisation_error = 0;  // m: how far the exact equilibrium is from that of the springs themselves
  std::string expected = {};        // a sentence about the true motion
};

/// Small ones alone where `quick`.
std::vector<AccuracyCase> accuracy_cases(bool quick);

/// The equations of motion of a case's scene.
std::unique_ptr<System> system_of(const AccuracyCase& test_case);

/// The scene with this solver. Not `compliant`: with constraints of stiffness 1.
Scene with_solver(const AccuracyCase& test_case, const SolverSpec& solver, bool compliant);

}  // namespace malha::study
