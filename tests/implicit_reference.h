// Backward Euler of a scene's springs by Newton's method on all coordinates at once, and what Desbrun's method solves
// of it, in double and by Eigen alone: nothing of the solver's but the list of springs.
#pragma once
#include <Eigen/Dense>
#include <vector>

#include "host/model/model.h"
#include "host/simulation.h"

namespace malha {

class ImplicitReference {
 public:
  /// In the user's order. `dt`: of a substep.
  explicit ImplicitReference(const Scene& scene)
      : dt_(scene.solver.dt / scene.solver.substeps), g_(scene.gravity[0], scene.gravity[1], scene.gravity[2]) {
    const Model model = build_model(scene);
    for (const SpringSet& set : model.springs)
      for (std::size_t s = 0; s < set.ends.size(); ++s)
        springs_.push_back(
            {model.user_of[set.ends[s][0]], model.user_of[set.ends[s][1]], set.stiffness[s], set.rest[s]});
    mass_.resize(model.count());
    for (int i = 0; i < model.count(); ++i) mass_[model.user_of[i]] = model.w[i] > 0 ? 1 / model.w[i] : 0;
  }

  using Vector = Eigen::VectorXd;  // three numbers a particle
  static Vector flat(const std::vector<Vec3>& points) {
    Vector a(3 * static_cast<int>(points.size()));
    for (int k = 0; k < a.size(); ++k) a[k] = points[k / 3][k % 3];
    return a;
  }
  double mass(int i) const { return mass_[i]; }
  bool pinned(int i) const { return mass_[i] == 0; }

  /// Where they go without springs.
  Vector inertial(const Vector& x, const Vector& v) const {
    Vector y = x + dt_ * v;
    for (int i = 0; i < count(); ++i)
      if (!pinned(i)) y.segment<3>(3 * i) += dt_ * dt_ * g_;
    return y;
  }

  /// x' of (M + dt^2 L) x' = M y + dt^2 J d(at); pinned particles stay.
  Vector local_global(const Vector& y, const Vector& at) const {
    const int n = count();
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
    Eigen::Matrix<double, Eigen::Dynamic, 3> b(n, 3);
    for (int i = 0; i < n; ++i) A(i, i) = mass_[i], b.row(i) = mass_[i] * y.segment<3>(3 * i).transpose();
    for (const Spring& s : springs_) {
      const double k = dt_ * dt_ * s.k;
      A(s.i, s.i) += k, A(s.j, s.j) += k, A(s.i, s.j) -= k, A(s.j, s.i) -= k;
      const Eigen::Vector3d d = at.segment<3>(3 * s.i) - at.segment<3>(3 * s.j);
      const Eigen::Vector3d pull = k * s.l * d.normalized();
      b.row(s.i) += pull.transpose(), b.row(s.j) -= pull.transpose();
    }
    for (int i = 0; i < n; ++i) {
      if (!pinned(i) && A(i, i) > 0) continue;
      A.row(i).setZero();
      A(i, i) = 1, b.row(i) = y.segment<3>(3 * i).transpose();
    }
    const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> x = A.partialPivLu().solve(b);
    return Eigen::Map<const Vector>(x.data(), 3 * n);
  }

  /// M (p - y) - dt^2 f(p): zero at backward Euler's p.
  Vector residual(const Vector& y, const Vector& p) const {
    Vector r(3 * count());
    for (int k = 0; k < r.size(); ++k) r[k] = mass_[k / 3] * (p[k] - y[k]);
    for (const Spring& s : springs_) {
      const Eigen::Vector3d d = p.segment<3>(3 * s.i) - p.segment<3>(3 * s.j);
      const Eigen::Vector3d f = dt_ * dt_ * s.k * (1 - s.l / d.norm()) * d;
      r.segment<3>(3 * s.i) += f, r.segment<3>(3 * s.j) -= f;
    }
    for (int k = 0; k < r.size(); ++k)
      if (pinned(k / 3)) r[k] = 0;
    return r;
  }

  /// Backward Euler's p, the nearest downhill of `p`.
  Vector newton(const Vector& y, Vector p) const {
    for (int turn = 0; turn < 100; ++turn) {
      const Vector r = residual(y, p);
      if (r.norm() < 1e-14 * (1 + y.norm())) break;
      Eigen::LLT<Eigen::MatrixXd> factor(hessian(p, false));
      if (factor.info() != Eigen::Success) factor.compute(hessian(p, true));
      const Vector step = factor.solve(r);
      double length = 1;
      while (length > 1e-10 && objective(y, p - length * step) > objective(y, p) + 1e-15) length /= 2;
      p -= length * step;
    }
    return p;
  }

 private:
  struct Spring {
    int i, j;
    double k, l;
  };
  int count() const { return static_cast<int>(mass_.size()); }

  double objective(const Vector& y, const Vector& p) const {
    double sum = 0;
    for (int k = 0; k < p.size(); ++k) sum += mass_[k / 3] * (p[k] - y[k]) * (p[k] - y[k]) / 2;
    for (const Spring& s : springs_) {
      const double stretch = (p.segment<3>(3 * s.i) - p.segment<3>(3 * s.j)).norm() - s.l;
      sum += dt_ * dt_ * s.k * stretch * stretch / 2;
    }
    return sum;
  }

  /// M + dt^2 k (I - (l/|d|)(I - d d^T/|d|^2)) a spring; `definite`: without the part by which shortened springs
  /// buckle.
  Eigen::MatrixXd hessian(const Vector& p, bool definite) const {
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(p.size(), p.size());
    for (int k = 0; k < p.size(); ++k) H(k, k) = pinned(k / 3) ? 1 : mass_[k / 3];
    for (const Spring& s : springs_) {
      const Eigen::Vector3d d = p.segment<3>(3 * s.i) - p.segment<3>(3 * s.j), u = d.normalized();
      const double across = definite ? std::max(0.0, 1 - s.l / d.norm()) : 1 - s.l / d.norm();
      const Eigen::Matrix3d along = u * u.transpose();
      const Eigen::Matrix3d K = dt_ * dt_ * s.k * (along + across * (Eigen::Matrix3d::Identity() - along));
      const bool a = !pinned(s.i), b = !pinned(s.j);
      if (a) H.block<3, 3>(3 * s.i, 3 * s.i) += K;
      if (b) H.block<3, 3>(3 * s.j, 3 * s.j) += K;
      if (a && b) H.block<3, 3>(3 * s.i, 3 * s.j) -= K, H.block<3, 3>(3 * s.j, 3 * s.i) -= K;
    }
    return H;
  }

  double dt_;
  Eigen::Vector3d g_;
  std::vector<Spring> springs_;
  std::vector<double> mass_;  // kg, 0 where pinned
};

}  // namespace malha
