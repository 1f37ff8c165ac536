// SPDX-License-Identifier: Apache-2.0
// Helpers for tests of Desbrun's filter: systems of all kinds, and the same systems assembled and solved by Eigen.
#pragma once
#include <Eigen/Dense>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <memory>
#include <string>
#include <vector>

#include "host/base/point_array.h"
#include "host/filter/filter.h"
#include "host/filter/filter_errors.h"
#include "tests/constraints/fold_reference.h"
#include "tests/numbers.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {

/// A scene of Desbrun's method at 60 steps a second, with springs of `stiffness` N/m where a constraint has none of its
/// own.
inline Scene desbrun_scene(std::vector<BodySpec> bodies, double stiffness, Precision precision = Precision::Double) {
  Scene scene = scene_of(std::move(bodies), kEarth, 1.0 / 60, 1, precision);
  scene.solver.type = "desbrun";
  scene.solver.iterations = 10;
  scene.solver.desbrun.spring_constant = stiffness;
  return scene;
}

/// A sheet of cells x (cells - 1) cells of 5 cm with edges, shear and bend springs, of 0.3 kg/m^2, so that particles at
/// its boundary weigh less than others.
inline BodySpec sprung_sheet(int cells, std::vector<Pin> pins = {}) {
  BodySpec body;
  body.name = "sheet";
  body.shape = GridShape{{0.05 * cells, 0.05 * (cells - 1)}, {cells, cells - 1}};
  body.density = 0.3;
  body.pins = std::move(pins);
  body.constraints = {stiff("distance", {"edges", "shear"}), stiff("bending", {}, 0.1)};
  return body;
}

/// A chain with that many unknowns, hung by its first point or free.
inline BodySpec sprung_chain(int unknowns, bool free, double mass = 0.1) {
  BodySpec body = hung_chain({0, 0, 0}, {0, -1, 0}, unknowns - free, mass);
  if (free) body.pins.clear();
  body.constraints = {stiff("distance", {"edges"})};
  return body;
}

/// A hub with springs to `leaves` points around it; the hub has half of the mass. Its mesh file is in `folder`.
inline BodySpec star(const TemporaryFolder& folder, int leaves, std::vector<Pin> pins = {}) {
  std::string text = "v 0 0 0\n", lines;
  for (int i = 0; i < leaves; ++i) {
    const double phi = 2 * kPi * i / leaves;
    text += "v " + std::to_string(std::cos(phi)) + " " + std::to_string(0.1 * (i % 3)) + " " +
            std::to_string(std::sin(phi)) + "\n";
    lines += "l 1 " + std::to_string(i + 2) + "\n";
  }
  BodySpec body;
  body.name = "star";
  body.shape = MeshFile{folder.write("star" + std::to_string(leaves) + ".obj", text + lines)};
  body.mass = 1;
  body.pins = std::move(pins);
  body.constraints = {stiff("distance", {"edges"})};
  return body;
}

/// A = M - dt^2 H over the particles `of` (solver's numbers), assembled in T from the lists of springs and hinges.
template <class T>
Eigen::SparseMatrix<T> matrix_of(const Model& model, double dt, const std::vector<int>& of) {
  std::vector<int> at(model.x.size(), -1);
  std::vector<Eigen::Triplet<T>> entries;
  for (int i = 0; i < static_cast<int>(of.size()); ++i) {
    at[of[i]] = i;
    entries.emplace_back(i, i, T(1) / T(model.w[of[i]]));
  }
  for (const SpringSet& set : model.springs)
    for (std::size_t s = 0; s < set.ends.size(); ++s) {
      const int a = at[set.ends[s][0]], b = at[set.ends[s][1]];
      const T k = T(dt) * T(dt) * T(set.stiffness[s]);
      if (a >= 0) entries.emplace_back(a, a, k);
      if (b >= 0) entries.emplace_back(b, b, k);
      if (a >= 0 && b >= 0) entries.emplace_back(a, b, -k), entries.emplace_back(b, a, -k);
    }
  for (const FoldReference& fold : folds_of(model))
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j)
        if (const int a = at[fold.of[i]], b = at[fold.of[j]]; a >= 0 && b >= 0)
          entries.emplace_back(a, b, T(dt) * T(dt) * T(fold.stiffness) * T(fold.weight[i]) * T(fold.weight[j]));
  Eigen::SparseMatrix<T> A(static_cast<int>(of.size()), static_cast<int>(of.size()));
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

/// The matrix A of the system itself (tests/filter/spring_system_test.cpp compares it with matrix_of).
template <class T>
Eigen::SparseMatrix<T> matrix_of(const SpringSystem& system) {
  std::vector<Eigen::Triplet<T>> entries;
  for (int i = 0; i < system.count(); ++i) {
    entries.emplace_back(i, i, T(system.diagonal[i]));
    for (int k = system.begin[i]; k < system.begin[i + 1]; ++k)
      entries.emplace_back(i, system.column[k], T(system.value[k]));
  }
  Eigen::SparseMatrix<T> A(system.count(), system.count());
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

/// A scene's model, its system, and S F by Eigen's Cholesky factor in long double.
class SolvedSystem {
 public:
  explicit SolvedSystem(const Scene& scene)
      : model(build_model(scene)),
        dt(scene.solver.dt / scene.solver.substeps),
        system(spring_system(model, dt)),
        factor_(matrix_of<long double>(system)) {}

  /// S F; without the mean over mass for free bodies.
  std::vector<double> filtered(const std::vector<double>& forces) const {
    using Columns = Eigen::Matrix<long double, Eigen::Dynamic, 3, Eigen::RowMajor>;
    Columns F(system.count(), 3);
    for (int k = 0; k < F.size(); ++k) F.data()[k] = forces[k];
    Columns a = factor_.solve(F);
    for (const SystemBlock& body : system.blocks) {
      if (!body.free) continue;
      Eigen::Matrix<long double, 1, 3> sum = Eigen::Matrix<long double, 1, 3>::Zero();
      long double mass = 0;
      for (int i = body.first; i < body.first + body.count; ++i) {
        const long double m = 1 / static_cast<long double>(model.w[system.particle[i]]);
        sum += m * a.row(i), mass += m;
      }
      for (int i = body.first; i < body.first + body.count; ++i) a.row(i) -= sum / mass;
    }
    return {a.data(), a.data() + a.size()};
  }

  const Model model;
  const double dt;
  const SpringSystem system;

 private:
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<long double>> factor_;
};

/// A filter of a system, whatever its storage type.
template <class R>
class FilterUnderTest {
 public:
  FilterUnderTest(const SolvedSystem& solved, FilterKind kind, std::optional<Storage> storage = {}, int threads = 1)
      : solved_(solved), model_(solved.model) {
    model_.scene.solver.desbrun.filter = kind;
    model_.scene.solver.desbrun.storage = storage;
    filter_ = make_filter<OpenMP, R>(OpenMP{threads, widest_instructions()}, threads, model_, solved.system, {});
  }

  /// S~ F, three numbers an unknown; without the mean over mass for free bodies.
  std::vector<double> operator()(const std::vector<double>& forces) const {
    PointArray<OpenMP, R> force(model_.x.size()), acceleration(model_.x.size());
    std::vector<double> a = through_points(
        force, acceleration, solved_.system.particle,
        [&] {
          filter_->apply({force.points(), acceleration.points(), false});
        },
        forces);
    remove_mean(solved_.system, a);
    return a;
  }
  double error(const std::vector<double>& forces) const {
    return relative_difference((*this)(forces), solved_.filtered(forces));
  }
  FilterErrors stated_errors() const { return filter_errors<OpenMP>(*filter_, model_, solved_.system); }
  const FilterStats& facts() const { return filter_->facts(); }

 private:
  const SolvedSystem& solved_;
  Model model_;
  std::unique_ptr<Filter<R>> filter_;
};

}  // namespace malha
