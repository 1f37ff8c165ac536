// SPDX-License-Identifier: Apache-2.0
#include "tools/study/accuracy/methods.h"

#include <algorithm>

#include "host/solver/solver.h"
#include "malha/simulation.h"

namespace malha::study {

namespace {

const char* name_of(Precision precision) { return precision == Precision::Float ? "float" : "double"; }
const char* name_of(Storage storage) {
  return storage == Storage::Float ? "float" : storage == Storage::Double ? "double" : "int16";
}
const char* name_of(Corrector corrector) {
  return corrector == Corrector::Inertia ? "inertia" : corrector == Corrector::Paper ? "paper" : "off";
}

class MethodList {
 public:
  MethodList(const AccuracyCase& test_case, bool quick) : test_case_(test_case), factor_(quick ? 4 : 2) {}

  void add_projections() {
    if (!test_case_.tetrahedra)
      for (const Precision precision : {Precision::Float, Precision::Double}) {
        Method method = xpbd(std::string("PBD, iterations, ") + name_of(precision), precision);
        method.compliant = false;
        by_iterations(method, test_case_.sweeps / 4);
      }
    by_substeps(xpbd("XPBD, substeps, float", Precision::Float), test_case_.sweeps);
    by_substeps(xpbd("XPBD, substeps, double", Precision::Double), test_case_.sweeps);
    by_iterations(xpbd("XPBD, iterations", Precision::Double), test_case_.sweeps);
    Method levels = xpbd("XPBD, substeps and levels, float", Precision::Float);
    levels.solver.levels = kAutoLevels;
    if (has_levels(levels)) by_substeps(levels, test_case_.sweeps);
    if (!test_case_.bends) return;
    Method filtered = xpbd("XPBD, substeps, filtered bending, float", Precision::Float);
    filtered.solver.bending = BendingMethod::Filtered;
    by_substeps(filtered, test_case_.sweeps);
    filtered.series = "XPBD, substeps and levels, filtered bending, float", filtered.solver.levels = kAutoLevels;
    if (has_levels(filtered)) by_substeps(filtered, test_case_.sweeps);
  }

  void add_filters() {
    if (test_case_.tetrahedra) return;
    by_substeps(desbrun("Desbrun, substeps"), test_case_.solves);
    Method refined = desbrun("Desbrun, refine, 1 substep");
    refined.solver.desbrun.corrector = Corrector::Off;
    by_refine(refined);
    refined.series = "Desbrun, refine, 16 substeps", refined.solver.substeps = 16;
    by_refine(refined);
    if (test_case_.scene.gravity != Vec3{} && !test_case_.at_rest) {
      Method method = desbrun("Desbrun, gravity round the filter");
      method.solver.desbrun.filter_external_forces = false;
      by_substeps(method, test_case_.solves);
    }
  }

  /// Adds variants of the filter's storage and of the corrector, which have a chart of their own.
  void add_variants() {
    if (test_case_.tetrahedra || test_case_.exact || test_case_.dense == 0) return;
    if (test_case_.scene.bodies[0].pins.empty())
      for (const Corrector corrector : {Corrector::Inertia, Corrector::Paper, Corrector::Off}) {
        Method method = desbrun(std::string("Desbrun, corrector ") + name_of(corrector));
        method.solver.desbrun.corrector = corrector, method.variant = true;
        by_substeps(method, test_case_.solves);
      }
    for (const Storage storage : {Storage::Float, Storage::Double, Storage::Int16}) {
      Method method = desbrun(std::string("Desbrun, dense, ") + name_of(storage));
      if (storage != Storage::Double) method.solver.precision = Precision::Float;
      method.solver.desbrun.filter = FilterKind::Dense, method.solver.desbrun.storage = storage, method.variant = true;
      by_substeps(method, test_case_.dense);
    }
    Method method = desbrun("Desbrun, sparse, float");
    method.solver.precision = Precision::Float, method.variant = true;
    by_substeps(method, test_case_.solves);
  }

  void add_other_integrators() {
    if (test_case_.at_rest) return;
    Method method;
    method.solver.precision = Precision::Double;
    method.series = "explicit Euler", method.integrator = Integrator::ExplicitEuler;
    by_substeps(method, test_case_.euler);
    method.series = "symplectic Euler", method.integrator = Integrator::SymplecticEuler;
    by_substeps(method, test_case_.euler);
    method.series = "RK4", method.integrator = Integrator::Rk4;
    by_substeps(method, test_case_.rk4);
    method.series = "backward Euler, Newton", method.integrator = Integrator::BackwardEuler;
    method.end_time = test_case_.newton_end_time;
    if (!test_case_.tetrahedra) by_substeps(method, test_case_.newton);
  }

  std::vector<Method> all() && { return std::move(all_); }

 private:
  static Method xpbd(const std::string& series, Precision precision) {
    Method method;
    method.series = series;
    method.solver.substeps = 1, method.solver.precision = precision, method.solver.levels = 0;
    method.solver.bending = BendingMethod::Projected;
    return method;
  }
  bool has_levels(const Method& method) const {
    const Scene scene = with_solver(test_case_, method.solver, method.compliant);
    return !Simulation(scene, {.threads = 1}).solver().facts().levels.empty();
  }
  static Method desbrun(const std::string& series) {
    Method method = xpbd(series, Precision::Double);
    method.solver.type = "desbrun", method.solver.desbrun.filter = FilterKind::Sparse;
    return method;
  }
  void by_substeps(Method method, int most) {
    for (int n = 1; n <= most; n *= factor_) method.solver.substeps = n, all_.push_back(method);
  }
  void by_iterations(Method method, int most) {
    for (int n = 1; n <= most; n *= factor_) method.solver.iterations = n, all_.push_back(method);
  }
  void by_refine(Method method) {
    for (int r = 0; test_case_.refine > 0 && r <= test_case_.refine; r = std::max(1, 2 * r))
      method.solver.desbrun.refinement_iterations = r, all_.push_back(method);
  }

  const AccuracyCase& test_case_;
  int factor_;
  std::vector<Method> all_;
};

}  // namespace

std::string Method::key() const {
  const DesbrunSpec& d = solver.desbrun;
  std::string key = series + ", " + std::to_string(solver.substeps) + "x" + std::to_string(solver.iterations) + " " +
                    name_of(solver.precision);
  if (solver.type == "desbrun")
    key += " r=" + std::to_string(d.refinement_iterations) +
           (d.filter == FilterKind::Dense    ? " dense"
            : d.filter == FilterKind::Sparse ? " sparse"
                                             : " auto") +
           (d.storage ? std::string(" ") + name_of(*d.storage) : "") +
           (d.corrector ? std::string(" ") + name_of(*d.corrector) : "") +
           (!d.filter_external_forces ? " internal only" : "");
  return key;
}

std::vector<Method> accuracy_methods(const AccuracyCase& test_case, bool quick) {
  MethodList list(test_case, quick);
  list.add_projections();
  list.add_filters();
  list.add_variants();
  list.add_other_integrators();
  return std::move(list).all();
}

}  // namespace malha::study
