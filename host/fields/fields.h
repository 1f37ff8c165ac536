// SPDX-License-Identifier: Apache-2.0
// Visual fields: values by which a window or a page may colour particles, in the user's order, as
// Simulation::positions(). They are made from Simulation::model() and keep no reference to it; after a tear they must
// be made again.
#pragma once
#include <string>
#include <vector>

#include "host/fields/of_model.h"
#include "host/model/model.h"

namespace malha {

/// The solver's layout of a scene, of its finest level if it has several. It changes only by tears.
struct Structure {
  std::vector<int> patch, colour;  // by particle; -1: in no patch, as by the filter alone
  std::vector<Edge> lines;         // constraints of two particles in batches
  std::vector<int> owner, batch;   // by line: the patch that projects it, and the index of its batch in the patch
  int patches = 0, colours = 0;    // patches are numbered by colour, in the order of a sweep
  int batches = 0;                 // the largest number of batches of a patch
};

/// Computes the layout, which takes as long as the solver's own set-up of patches.
Structure structure(const Model& model, int threads = 1);

/// For each particle the largest |l - l0| / l0 of its distance constraints and springs; 0 without any. The largest of
/// all is Measures::strain_max.
class Strains {
 public:
  explicit Strains(const Model& model);
  /// Tells whether the model has any.
  bool any() const { return !lengths_.empty(); }
  /// Throws std::invalid_argument for another number of particles.
  std::vector<float> operator()(const std::vector<Vec3>& x) const;

 private:
  struct Length {
    int a, b;
    double rest, per_rest;  // m, 1/m; 1/m is 0 for a rest length of 0
  };
  std::size_t particles_;
  std::vector<Length> lengths_;
};

/// For each particle the largest residual of its constraints and springs, in m for every kind: |C| / |grad C|, to first
/// order the distance of all their particles together to C = 0. For a distance it is |l - l0| / sqrt(2). For a material
/// with an energy U, which has no C of its own, it is 2 U / |grad U|. Pressure is one constraint of its whole body.
///
/// Inequalities that hold, and constraints without a gradient, which projections skip, have residual 0. Masses and pins
/// do not count. The deformation of a compliant constraint under a load is a residual, too. Contacts, attachments and
/// long range are left out.
class Residuals {
 public:
  explicit Residuals(const Model& model, int threads = 1);
  /// Tells whether the model has any.
  bool any() const { return !sets_.empty() || !pressures_.empty(); }
  /// Throws std::invalid_argument for another number of particles.
  std::vector<float> operator()(const std::vector<Vec3>& x) const;

 private:
  struct Set {
    std::string type;
    int arity;
    std::vector<int> particles;
    std::vector<double> rest;     // rest values, Kind::rest_values a constraint
    std::vector<double> rest_C2;  // C^2 at rest, for materials
  };
  void add(const Model& model, const ConstraintSet& set);

  std::size_t particles_;
  int threads_;
  std::vector<Set> sets_;
  std::vector<ClosedSurface> pressures_;
};

}  // namespace malha
