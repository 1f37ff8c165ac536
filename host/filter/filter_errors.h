// SPDX-License-Identifier: Apache-2.0
// Errors of a filter, compared with the same system solved in double.
#pragma once
#include <functional>
#include <vector>

#include "host/base/point_array.h"
#include "host/filter/system.h"

namespace malha {

/// Applies the filter under test, a = S~ F, with three numbers per unknown.
using ApplyFilter = std::function<std::vector<double>(const std::vector<double>& forces)>;

/// A sparse filter in double, on one thread.
ApplyFilter exact_filter(const SpringSystem& system);

/// Result of product() for forces by unknown, through arrays by particle.
template <class Executor, class R, class Product>
std::vector<double> through_points(PointArray<Executor, R>& force, const PointArray<Executor, R>& acceleration,
                                   const std::vector<int>& particle, const Product& product,
                                   const std::vector<double>& forces) {
  std::vector<Vec3> all(force.size(), Vec3{0, 0, 0});
  for (std::size_t k = 0; k < forces.size(); ++k) all[particle[k / 3]][k % 3] = forces[k];
  force.upload(all);
  product();
  all = acceleration.download();
  std::vector<double> a(forces.size());
  for (std::size_t k = 0; k < forces.size(); ++k) a[k] = all[particle[k / 3]][k % 3];
  return a;
}

struct Refined {
  std::vector<double> accelerations;
  double step = 1;  // last step over the solution, an estimate of its error; large if the filter is too far from S
};
/// S F to rounding: iterative refinement with a filter in place of S.
Refined refined(const SpringSystem& system, const ApplyFilter& apply, const std::vector<double>& forces);

/// Independent numbers in [-1, 1), the same every time, without the mean force of free bodies.
std::vector<double> noise_forces(const SpringSystem& system);
/// (A - M) d of independent displacements d: elastic forces of springs, times dt^2.
std::vector<double> elastic_forces(const SpringSystem& system);

/// Removes the mass-weighted mean from the accelerations of free bodies.
void remove_mean(const SpringSystem& system, std::vector<double>& accelerations);

/// |a - b| / |b|.
double relative_difference(const std::vector<double>& a, const std::vector<double>& b);

}  // namespace malha
