// SPDX-License-Identifier: Apache-2.0
#include "tools/study/reference/steps.h"

#include <Eigen/SparseCholesky>
#include <cmath>

namespace malha::study {

void explicit_euler(const System& system, double h, State& state) {
  const Vector a = system.accelerations(state.x);
  state.x += h * state.v;
  state.v += h * a;
}

void symplectic_euler(const System& system, double h, State& state) {
  state.v += h * system.accelerations(state.x);
  state.x += h * state.v;
}

void rk4(const System& system, double h, State& state) {
  const auto& [x, v] = state;
  const Vector a1 = system.accelerations(x);
  const Vector v2 = v + h / 2 * a1, a2 = system.accelerations(x + h / 2 * v);
  const Vector v3 = v + h / 2 * a2, a3 = system.accelerations(x + h / 2 * v2);
  const Vector v4 = v + h * a3, a4 = system.accelerations(x + h * v3);
  state.x += h / 6 * (v + 2 * v2 + 2 * v3 + v4);
  state.v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
}

struct BackwardEuler::Parts {
  explicit Parts(const SpringSystem& of) : system(of) {}

  /// (x - y)^2 M / 2 + h^2 U(x), where y is the position by inertia and gravity alone.
  double objective(const Vector& y, const Vector& x, double h) const {
    double sum = h * h * system.elastic_energy(x);
    for (int i = 0; i < system.count(); ++i)
      if (!system.pinned[i]) sum += system.mass[i] * (x - y).segment<3>(3 * i).squaredNorm() / 2;
    return sum;
  }

  Vector gradient(const Vector& y, const Vector& x, double h) const {
    Vector f = Vector::Zero(x.size());
    system.add_forces(x, f);
    f *= -h * h;
    for (int k = 0; k < f.size(); ++k) f[k] = system.pinned[k / 3] ? 0 : f[k] + system.mass[k / 3] * (x[k] - y[k]);
    return f;
  }

  void fill_hessian(const Vector& x, double h, bool definite) {
    entries.clear();
    for (int k = 0; k < x.size(); ++k) entries.emplace_back(k, k, system.pinned[k / 3] ? 1 : system.mass[k / 3]);
    const auto add = [this](int i, int j, const Eigen::Matrix3d& block) {
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) entries.emplace_back(3 * i + a, 3 * j + b, block(a, b));
    };
    for (const Spring& s : system.springs) {
      const Eigen::Vector3d d = x.segment<3>(3 * s.i) - x.segment<3>(3 * s.j), u = d.normalized();
      const double across = 1 - s.rest / d.norm();
      const Eigen::Matrix3d along = u * u.transpose();
      const Eigen::Matrix3d K =
          h * h * s.stiffness *
          (along + (definite ? std::max(0.0, across) : across) * (Eigen::Matrix3d::Identity() - along));
      const bool i = !system.pinned[s.i], j = !system.pinned[s.j];
      if (i) add(s.i, s.i, K);
      if (j) add(s.j, s.j, K);
      if (i && j) add(std::max(s.i, s.j), std::min(s.i, s.j), -K);  // Eigen reads the lower triangle
    }
    for (const BendingElement& b : system.bending)
      for (const auto& [i, at_i] : {std::pair(b.i, 1), std::pair(b.j, -2), std::pair(b.k, 1)})
        for (const auto& [j, at_j] : {std::pair(b.i, 1), std::pair(b.j, -2), std::pair(b.k, 1)})
          if (j <= i && !system.pinned[i] && !system.pinned[j])
            add(i, j, h * h * b.stiffness * at_i * at_j * Eigen::Matrix3d::Identity());
    hessian.resize(x.size(), x.size());
    hessian.setFromTriplets(entries.begin(), entries.end());
  }

  void factor(const Vector& x, double h) {
    for (const bool definite : {false, true}) {
      fill_hessian(x, h, definite);
      if (!analysed) cholesky.analyzePattern(hessian), analysed = true;
      cholesky.factorize(hessian);
      ++solves;
      if (cholesky.info() == Eigen::Success) return;
    }
  }

  const SpringSystem& system;
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::SparseMatrix<double> hessian;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> cholesky;
  bool analysed = false;
  long solves = 0;
};

BackwardEuler::BackwardEuler(const SpringSystem& system) : parts_(std::make_unique<Parts>(system)) {}
BackwardEuler::~BackwardEuler() = default;
long BackwardEuler::solves() const { return parts_->solves; }

void BackwardEuler::step(double h, State& state) {
  const SpringSystem& system = parts_->system;
  Vector y = state.x + h * state.v;
  for (int i = 0; i < system.count(); ++i)
    if (!system.pinned[i]) y.segment<3>(3 * i) += h * h * system.gravity;
  Vector x = state.x + h * state.v;
  double tolerance = 0;
  for (int k = 0; k < y.size(); ++k)
    tolerance += std::pow(system.mass[k / 3] * (std::abs(y[k] - state.x[k]) + 1e-9), 2);
  tolerance = 1e-10 * std::sqrt(tolerance);
  constexpr int max_iterations = 50;
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    const Vector r = parts_->gradient(y, x, h);
    if (r.norm() < tolerance) break;
    parts_->factor(x, h);
    const Vector move = parts_->cholesky.solve(r);
    const double before = parts_->objective(y, x, h), slope = move.dot(r);
    double length = 1;
    // The last term is for rounding of the sum over all springs, which must not shorten the step.
    while (length > 1e-6 &&
           parts_->objective(y, x - length * move, h) > before - 1e-4 * length * slope + 1e-12 * before)
      length /= 2;
    x -= length * move;
  }
  state.v = (x - state.x) / h;
  state.x = x;
}

}  // namespace malha::study
