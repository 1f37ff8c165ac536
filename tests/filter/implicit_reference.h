// SPDX-License-Identifier: Apache-2.0
// Reference of implicit integration: backward Euler of a scene's springs, and the linear solve of Desbrun's method with
// hinges, in double by Eigen; of the solver's code it uses only the lists of springs and hinges.
#pragma once
#include "host/model/model.h"
#include "malha/simulation.h"
#include "tests/constraints/fold_reference.h"
#include "tools/study/reference/steps.h"

namespace malha {

class ImplicitReference {
 public:
  /// All vectors are in the user's order. `dt`: duration of a substep.
  explicit ImplicitReference(const Scene& scene) : dt_(scene.solver.dt / scene.solver.substeps) {
    const Model model = build_model(scene);
    for (const SpringSet& set : model.springs)
      for (std::size_t s = 0; s < set.ends.size(); ++s)
        system_.springs.push_back(
            {model.user_index[set.ends[s][0]], model.user_index[set.ends[s][1]], set.stiffness[s], set.rest[s]});
    folds_ = folds_of(model);
    for (FoldReference& fold : folds_)
      for (int& i : fold.of) i = model.user_index[i];
    system_.mass.resize(model.count()), system_.pinned.resize(model.count());
    for (int i = 0; i < model.count(); ++i) {
      system_.mass[model.user_index[i]] = model.w[i] > 0 ? 1 / model.w[i] : 0;
      system_.pinned[model.user_index[i]] = model.w[i] == 0;
    }
    system_.gravity = Eigen::Vector3d::Map(scene.gravity.data());
  }

  using Vector = study::Vector;
  double mass(int i) const { return system_.mass[i]; }  // kg, 0 where pinned

  /// The positions y after a substep without springs.
  Vector inertial(const Vector& x, const Vector& v) const {
    Vector y = x + dt_ * v;
    for (int i = 0; i < system_.count(); ++i)
      if (!system_.pinned[i]) y.segment<3>(3 * i) += dt_ * dt_ * system_.gravity;
    return y;
  }

  /// x' of (M + dt^2 L) x' = M y + dt^2 J d(at); pinned particles stay.
  Vector local_global(const Vector& y, const Vector& at) const {
    const int n = system_.count();
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
    Eigen::Matrix<double, Eigen::Dynamic, 3> b(n, 3);
    for (int i = 0; i < n; ++i) A(i, i) = mass(i), b.row(i) = mass(i) * y.segment<3>(3 * i).transpose();
    for (const study::Spring& s : system_.springs) {
      const double k = dt_ * dt_ * s.stiffness;
      A(s.i, s.i) += k, A(s.j, s.j) += k, A(s.i, s.j) -= k, A(s.j, s.i) -= k;
      const Eigen::Vector3d d = at.segment<3>(3 * s.i) - at.segment<3>(3 * s.j);
      const Eigen::Vector3d pull = k * s.rest * d.normalized();
      b.row(s.i) += pull.transpose(), b.row(s.j) -= pull.transpose();
    }
    for (const FoldReference& fold : folds_) {
      const double k = dt_ * dt_ * fold.stiffness;
      const Eigen::Vector3d f = fold_at(fold, at);
      const Eigen::Vector3d pull = f.norm() > 0 ? Eigen::Vector3d(k * fold.rest * f.normalized()) : f;
      for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j) A(fold.of[i], fold.of[j]) += k * fold.weight[i] * fold.weight[j];
        b.row(fold.of[i]) += fold.weight[i] * pull.transpose();
      }
    }
    for (int i = 0; i < n; ++i) {
      if (!system_.pinned[i] && A(i, i) > 0) continue;
      A.row(i).setZero();
      A(i, i) = 1, b.row(i) = y.segment<3>(3 * i).transpose();
    }
    const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> x = A.partialPivLu().solve(b);
    return Eigen::Map<const Vector>(x.data(), 3 * n);
  }

  /// M (p - y) - dt^2 f(p): zero at backward Euler's p.
  Vector residual(const Vector& y, const Vector& p) const {
    Vector f = Vector::Zero(p.size());
    system_.add_forces(p, f);
    for (int k = 0; k < f.size(); ++k)
      f[k] = system_.pinned[k / 3] ? 0 : mass(k / 3) * (p[k] - y[k]) - dt_ * dt_ * f[k];
    return f;
  }

  /// Backward Euler's x', by Newton's method, of springs alone.
  Vector backward_euler(const Vector& x, const Vector& v) const {
    study::State state{x, v};
    study::BackwardEuler(system_).step(dt_, state);
    return state.x;
  }

 private:
  static Eigen::Vector3d fold_at(const FoldReference& fold, const Vector& x) {
    Eigen::Vector3d f = Eigen::Vector3d::Zero();
    for (int j = 0; j < 4; ++j) f += fold.weight[j] * x.segment<3>(3 * fold.of[j]);
    return f;
  }

  double dt_;
  study::SpringSystem system_;
  std::vector<FoldReference> folds_;
};

}  // namespace malha
