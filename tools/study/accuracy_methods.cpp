#include "tools/study/accuracy_methods.h"

#include <algorithm>

namespace malha::study {

namespace {

const char* name_of(Storage storage) {
  return storage == Storage::Float ? "float" : storage == Storage::Double ? "double" : "int16";
}
const char* name_of(Corrector corrector) {
  return corrector == Corrector::Inertia ? "inertia" : corrector == Corrector::Paper ? "paper" : "off";
}

/// low, low * factor, ... up to high.
std::vector<int> powers(int low, int high, int factor) {
  std::vector<int> all;
  for (int n = low; n <= high; n *= factor) all.push_back(n);
  return all;
}

class List {
 public:
  List(const AccuracyCase& of, bool quick) : of_(of), factor_(quick ? 4 : 2) {}

  void by_substeps(Method method, int most) {
    for (const int n : powers(1, std::min(most, of_.most_substeps), factor_))
      method.solver.substeps = n, all_.push_back(method);
  }
  void by_iterations(Method method, int most) {
    for (const int n : powers(1, most, factor_)) method.solver.iterations = n, all_.push_back(method);
  }
  void by_refine(Method method) {
    for (const int r : {0, 1, 2, 4, 8, 16}) method.solver.desbrun.refine = r, all_.push_back(method);
  }

  void pbd() {
    Method method = xpbd("PBD, iterations", Precision::Float);
    method.compliant = false;
    by_iterations(method, 256);
  }
  void xpbds() {
    by_substeps(xpbd("XPBD, substeps, float", Precision::Float), 1024);
    by_substeps(xpbd("XPBD, substeps, double", Precision::Double), 1024);
    by_iterations(xpbd("XPBD, iterations", Precision::Double), 256);
  }
  void desbruns() {
    by_substeps(desbrun("Desbrun, substeps"), 256);
    Method refined = desbrun("Desbrun, refine, 1 substep");
    refined.solver.desbrun.corrector = Corrector::Off;
    by_refine(refined);
    refined.series = "Desbrun, refine, 16 substeps", refined.solver.substeps = 16;
    by_refine(refined);
  }
  void references(int lowest_explicit) {
    Method method;
    method.solver.precision = Precision::Double;
    method.series = "symplectic Euler", method.integrator = Integrator::SymplecticEuler;
    for (const int n : powers(lowest_explicit, 1024, factor_)) method.solver.substeps = n, all_.push_back(method);
    method.series = "RK4", method.integrator = Integrator::Rk4;
    for (const int n : powers(lowest_explicit, 256, factor_)) method.solver.substeps = n, all_.push_back(method);
    method.series = "backward Euler, Newton", method.integrator = Integrator::BackwardEuler;
    by_substeps(method, 64);
  }

  std::vector<Method> all() && { return std::move(all_); }

 private:
  static Method xpbd(const std::string& series, Precision precision) {
    Method method;
    method.series = series;
    method.solver.substeps = 1, method.solver.precision = precision;
    return method;
  }
  static Method desbrun(const std::string& series) {
    Method method = xpbd(series, Precision::Double);
    method.solver.type = "desbrun", method.solver.desbrun.filter = FilterKind::Sparse;
    return method;
  }

  const AccuracyCase& of_;
  int factor_;
  std::vector<Method> all_;
};

}  // namespace

std::string Method::key() const {
  const DesbrunSpec& d = solver.desbrun;
  std::string key = series + ", " + std::to_string(solver.substeps) + "x" + std::to_string(solver.iterations) +
                    (solver.precision == Precision::Float ? " float" : " double");
  if (solver.type == "desbrun")
    key += " r=" + std::to_string(d.refine) +
           (d.filter == FilterKind::Dense    ? " dense"
            : d.filter == FilterKind::Sparse ? " sparse"
                                             : " auto") +
           (d.storage ? std::string(" ") + name_of(*d.storage) : "") +
           (d.corrector ? std::string(" ") + name_of(*d.corrector) : "") + (d.internal_only ? " internal only" : "");
  return key;
}

std::vector<Method> accuracy_methods(const AccuracyCase& of, bool quick) {
  List list(of, quick);
  list.pbd();
  list.xpbds();
  list.desbruns();
  list.references(1);
  return std::move(list).all();
}

}  // namespace malha::study
