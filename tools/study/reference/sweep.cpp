// SPDX-License-Identifier: Apache-2.0
#include "tools/study/reference/sweep.h"

#include <algorithm>
#include <complex>
#include <numeric>

namespace malha::study {

namespace {

/// Indices in ascending order of the numbers; equal numbers keep their order.
std::vector<int> ascending(const std::vector<int>& numbers) {
  std::vector<int> order(numbers.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return numbers[a] < numbers[b]; });
  return order;
}

}  // namespace

std::vector<int> order_from_pins(const SpringSystem& system) {
  std::vector<std::vector<int>> next(system.count());
  for (const Spring& s : system.springs) next[s.i].push_back(s.j), next[s.j].push_back(s.i);
  std::vector<int> away(system.count(), system.count()), front;
  for (int i = 0; i < system.count(); ++i)
    if (system.pinned[i]) away[i] = 0, front.push_back(i);
  for (std::size_t k = 0; k < front.size(); ++k)
    for (const int j : next[front[k]])
      if (away[j] > away[front[k]] + 1) away[j] = away[front[k]] + 1, front.push_back(j);
  std::vector<int> nearer;
  for (const Spring& s : system.springs) nearer.push_back(std::min(away[s.i], away[s.j]));
  return ascending(nearer);
}

std::vector<int> order_by_colour(const SpringSystem& system) {
  std::vector<std::vector<bool>> used(system.count());
  std::vector<int> colour;
  for (const Spring& s : system.springs) {
    int lowest = 0;
    const auto taken = [&](int i) { return !system.pinned[i] && lowest < int(used[i].size()) && used[i][lowest]; };
    while (taken(s.i) || taken(s.j)) ++lowest;
    for (const int i : {s.i, s.j}) {
      if (lowest >= int(used[i].size())) used[i].resize(lowest + 1);
      used[i][lowest] = true;
    }
    colour.push_back(lowest);
  }
  return ascending(colour);
}

Eigen::MatrixXd linearised_sweep(const SpringSystem& system, const std::vector<int>& order) {
  const int n = 3 * system.count();
  Eigen::MatrixXd T = Eigen::MatrixXd::Identity(n, n);
  for (const int s : order) {
    const auto& [a, b, stiffness, rest] = system.springs[s];
    const double wa = system.pinned[a] ? 0 : 1 / system.mass[a], wb = system.pinned[b] ? 0 : 1 / system.mass[b];
    if (wa + wb == 0) continue;
    const Eigen::Vector3d d = (system.start.x.segment<3>(3 * a) - system.start.x.segment<3>(3 * b)).normalized();
    const Eigen::RowVectorXd stretch = d.transpose() * (T.middleRows<3>(3 * a) - T.middleRows<3>(3 * b)) / (wa + wb);
    T.middleRows<3>(3 * a) -= wa * d * stretch, T.middleRows<3>(3 * b) += wb * d * stretch;
  }
  return T;
}

double amplification_of_sweep(const Eigen::MatrixXd& T) {
  const Eigen::VectorXcd mu = T.eigenvalues();
  double most = 0;
  for (Eigen::Index k = 0; k < mu.size(); ++k) {
    const std::complex<double> root = std::sqrt(mu[k] * mu[k] - mu[k]);
    most = std::max({most, std::abs(mu[k] + root), std::abs(mu[k] - root)});
  }
  return most;
}

template <class R>
PlainSweep<R>::PlainSweep(const SpringSystem& system, std::vector<int> order, double compliance)
    : system_(system), order_(std::move(order)), p_(system.count()), compliance_(compliance) {
  for (int i = 0; i < system.count(); ++i) {
    x_.push_back(system.start.x.segment<3>(3 * i).cast<R>());
    v_.push_back(system.start.v.segment<3>(3 * i).cast<R>());
    w_.push_back(system.pinned[i] ? R(0) : R(1 / system.mass[i]));
  }
}

template <class R>
void PlainSweep<R>::substep(double h) {
  const R step = R(h), softness = R(compliance_ / (h * h));
  const Column g = system_.gravity.cast<R>();
  for (std::size_t i = 0; i < x_.size(); ++i) {
    if (w_[i] > 0) v_[i] += step * g;
    p_[i] = x_[i] + step * v_[i];
  }
  for (const int s : order_) {
    const auto& [a, b, stiffness, rest] = system_.springs[s];
    const Column d = p_[a] - p_[b];
    const R length = d.norm();
    if (!(length > 0)) continue;
    const Column move = d * ((length - R(rest)) / (length * (w_[a] + w_[b] + softness)));
    p_[a] -= w_[a] * move, p_[b] += w_[b] * move;
  }
  for (std::size_t i = 0; i < x_.size(); ++i) v_[i] = (p_[i] - x_[i]) / step, x_[i] = p_[i];
}

template <class R>
State PlainSweep<R>::state() const {
  State state{Vector(3 * system_.count()), Vector(3 * system_.count())};
  for (int i = 0; i < system_.count(); ++i)
    state.x.segment<3>(3 * i) = x_[i].template cast<double>(),
                           state.v.segment<3>(3 * i) = v_[i].template cast<double>();
  return state;
}

template class PlainSweep<float>;
template class PlainSweep<double>;

}  // namespace malha::study
