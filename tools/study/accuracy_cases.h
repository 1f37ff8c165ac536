// The cases of the study "accuracy".
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/scene.h"
#include "tools/study/reference_system.h"

namespace malha::study {

inline constexpr double kFrame = 1.0 / 60;  // s: the step dt of all; methods divide it into substeps

struct AccuracyCase {
  std::string name, title;
  Scene scene;                                // its distance constraints have a compliance
  std::vector<double> times{1, 5};            // s, at which errors are measured, whole seconds
  std::function<State(double t)> exact = {};  // in closed form; empty: a reference run
  int reference = 0;                          // its substeps a frame
  bool free = false;                          // no pins: correctors matter
  int most_substeps = 1024;                   // of malha's own methods
  bool dense = true;                          // Desbrun's dense filter is affordable
};

/// The small ones alone where `quick`.
std::vector<AccuracyCase> accuracy_cases(bool quick);

/// The same springs by another solver: `scene` of the case with it.
Scene with_solver(const AccuracyCase& of, const SolverSpec& solver, bool compliant);

}  // namespace malha::study
