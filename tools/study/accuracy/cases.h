// SPDX-License-Identifier: Apache-2.0
// Cases of the study "accuracy": scenes whose true motion or equilibrium is known.
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
  Scene scene;                                // distance constraints have a compliance
  std::vector<double> times{1, 5};            // s, when errors are measured; whole frames
  std::function<State(double t)> exact = {};  // the solution in closed form; empty: a reference run
  int reference = 0;                          // substeps a frame of the reference run
  bool at_rest = false;                       // compares the equilibrium that damped motion reaches
  bool taut = false;                          // prestressed: the springs' initial energy does not count as motion's
  bool bends = false;                         // bending of a rigidity, which PBD can filter
  bool tetrahedra = false;                    // solid elements: methods for springs only are left out
  // Upper limits of the costs that are run (0: not run): substeps or iterations a frame of malha's sweeps, of the
  // filter, and of the dense filter (0: no variant at all), refinements, and substeps of the other integrators.
  int sweeps = 1024, solves = 256, dense = 64, refine = 16, euler = 1024, rk4 = 256, newton = 16;
  double newton_end_time = 1e9;     // s: how long Newton's method is run
  double discretisation_error = 0;  // m: distance of the continuous equilibrium from that of the springs
  std::string expected = {};        // a sentence about the true motion
};

/// All cases; only small ones if `quick`.
std::vector<AccuracyCase> accuracy_cases(bool quick);

/// A strip of 1 m with `cells` cells along, clamped by its first two rows of particles, that comes to rest under its
/// weight: a heavy elastica of Gamma 10.
AccuracyCase cantilever(int cells);

/// The equations of motion of a case's scene.
std::unique_ptr<System> system_of(const AccuracyCase& test_case);

/// The case's scene with this solver. If not `compliant`, its constraints have stiffness 1.
Scene with_solver(const AccuracyCase& test_case, const SolverSpec& solver, bool compliant);

}  // namespace malha::study
