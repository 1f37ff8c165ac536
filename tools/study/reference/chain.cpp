// SPDX-License-Identifier: Apache-2.0
#include "tools/study/reference/chain.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace malha::study {

namespace {

using Joint = ReferenceChain::Position;

constexpr int kMostNewton = 50;
constexpr double kChainExact = 1e-12;  // in squared link lengths

Joint joint_to_joint(const Joint& a, const Joint& b) { return {b[0] - a[0], b[1] - a[1]}; }
double dot(const Joint& a, const Joint& b) { return a[0] * b[0] + a[1] * b[1]; }

/// Solves a tridiagonal system in place: `b` becomes the solution. lower[k] and upper[k] are beside row k's diagonal.
void solve_tridiagonal(std::vector<double>& diagonal, const std::vector<double>& lower,
                       const std::vector<double>& upper, std::vector<double>& b) {
  const std::size_t n = b.size();
  for (std::size_t k = 1; k < n; ++k) {
    const double factor = lower[k] / diagonal[k - 1];
    diagonal[k] -= factor * upper[k - 1], b[k] -= factor * b[k - 1];
  }
  for (std::size_t k = n; k-- > 0;) b[k] = (b[k] - (k + 1 < n ? upper[k] * b[k + 1] : 0)) / diagonal[k];
}

}  // namespace

ReferenceChain::ReferenceChain(int links, double length, double gravity)
    : link_(length / links), gravity_(gravity), mass_(1.0 / links), w_(links + 1, 1 / mass_), v_(links + 1) {
  w_.front() = 0, w_.back() = 2 / mass_;
  for (int i = 0; i <= links; ++i) x_.push_back({0, i * link_});
}

void ReferenceChain::step(double h) {
  const std::size_t links = x_.size() - 1;
  std::vector<Joint> along(links), p = x_;  // links before the step; positions after it
  for (std::size_t e = 0; e < links; ++e) along[e] = joint_to_joint(x_[e], x_[e + 1]);
  for (std::size_t i = 1; i <= links; ++i) p[i] = {x_[i][0] + h * (v_[i][0] - h * gravity_), x_[i][1] + h * v_[i][1]};
  std::vector<double> diagonal(links), lower(links, 0), upper(links, 0), pull(links);
  for (int k = 0;; ++k) {
    double worst = 0;
    for (std::size_t e = 0; e < links; ++e) {
      const Joint now = joint_to_joint(p[e], p[e + 1]);
      const double c = (dot(now, now) - link_ * link_) / 2;
      worst = std::max(worst, std::abs(c)), pull[e] = -c;
      diagonal[e] = (w_[e] + w_[e + 1]) * dot(now, along[e]);
      if (e + 1 < links) upper[e] = -w_[e + 1] * dot(now, along[e + 1]);
      if (e > 0) lower[e] = -w_[e] * dot(now, along[e - 1]);
    }
    if (worst < kChainExact * link_ * link_) break;
    if (k == kMostNewton || !std::isfinite(worst)) throw std::runtime_error("a chain's step is too long");
    solve_tridiagonal(diagonal, lower, upper, pull);
    for (std::size_t e = 0; e < links; ++e)
      for (int d = 0; d < 2; ++d)
        p[e][d] -= w_[e] * pull[e] * along[e][d], p[e + 1][d] += w_[e + 1] * pull[e] * along[e][d];
  }
  for (std::size_t i = 0; i <= links; ++i) v_[i] = {(p[i][0] - x_[i][0]) / h, (p[i][1] - x_[i][1]) / h};
  x_ = std::move(p);
}

double ReferenceChain::kinetic() const {
  double sum = 0;
  for (std::size_t i = 1; i < x_.size(); ++i) sum += dot(v_[i], v_[i]) / w_[i] / 2;
  return sum;
}

double ReferenceChain::potential() const {
  double sum = 0;
  for (std::size_t i = 1; i < x_.size(); ++i) sum += gravity_ * x_[i][0] / w_[i];
  return sum;
}

}  // namespace malha::study
