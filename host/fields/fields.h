// SPDX-License-Identifier: Apache-2.0
// Looks: what a window or a page may colour particles by. All in the user's order, as Simulation::positions(). They are
// made from Simulation::model() and keep nothing of it; what tears has to be looked at anew, with new ones.
#pragma once
#include <string>
#include <vector>

#include "host/fields/of_model.h"
#include "host/model/model.h"

namespace malha {

/// How the solver lays a scene out: its finest level, where it has several. The same as long as nothing tears.
struct Structure {
  std::vector<int> patch, phase;  // of each particle; -1: no patch, as with the filter alone
  std::vector<Edge> lines;        // constraints of two particles that are projected in batches
  std::vector<int> owner, batch;  // of each line: the patch that projects it, in which of the patch's batches
  int patches = 0, phases = 0;    // patches are numbered phase by phase, in the order of a sweep
  int batches = 0;                // of the patch that has the most
};

/// Takes as long as the solver's own plan.
Structure structure(const Model& model, int threads = 1);

/// Of each particle the largest |l - l0| / l0 of its distance constraints and springs; 0 where it has none. The largest
/// of all is Measures::strain_max.
class Strains {
 public:
  explicit Strains(const Model& model);
  /// Whether the model has any.
  bool any() const { return !lengths_.empty(); }
  /// Throws std::invalid_argument for another number of particles.
  std::vector<float> operator()(const std::vector<Vec3>& x) const;

 private:
  struct Length {
    int a, b;
    double rest, per_rest;  // m, 1/m; 1/m is 0 where it has no length
  };
  std::size_t particles_;
  std::vector<Length> lengths_;
};

/// Of each particle the largest residual of its constraints and springs, in m whatever their kind: |C| / |grad C|, to
/// first order the way of all their particles together to where C = 0. Of a distance that is |l - l0| / sqrt(2). Of a
/// material with an energy U, which has no C of its own, 2 U / |grad U|. Pressure is one constraint of its whole body.
///
/// 0: an inequality that holds, and what has no gradient, which a projection skips. Masses and pins do not count. What
/// a compliance gives way under a load is residual too. Contacts, attachments and long range are left out.
class Residuals {
 public:
  explicit Residuals(const Model& model, int threads = 1);
  /// Whether the model has any.
  bool any() const { return !sets_.empty() || !shells_.empty(); }
  /// Throws std::invalid_argument for another number of particles.
  std::vector<float> operator()(const std::vector<Vec3>& x) const;

 private:
  struct Set {
    std::string type;
    int arity;
    std::vector<int> particles;
    std::vector<double> rest;    // as many of each constraint as its kind has numbers
    std::vector<double> ground;  // of materials: C^2 at rest
  };
  void add(const Model& model, const ConstraintSet& set);

  std::size_t particles_;
  int threads_;
  std::vector<Set> sets_;
  std::vector<Shell> shells_;
};

}  // namespace malha
