// SPDX-License-Identifier: Apache-2.0
#include "host/filter/filter_errors.h"

#include <cmath>
#include <cstdint>
#include <memory>

#include "host/filter/factor.h"

namespace malha {

namespace {

double norm(const std::vector<double>& a) {
  double sum = 0;
  for (const double number : a) sum += number * number;
  return std::sqrt(sum);
}

std::vector<double> random_numbers(int unknowns) {
  std::vector<double> numbers(3 * std::size_t(unknowns));
  std::uint64_t state = 1;
  for (double& number : numbers) {
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    number = static_cast<double>(state >> 11) * 0x1p-52 - 1;
  }
  return numbers;
}

/// Removes the mean, weighted by weigh(i), from the values of free bodies, in proportion to share(i).
template <class Weigh, class Share>
void level(const SpringSystem& system, std::vector<double>& numbers, const Weigh& weigh, const Share& share) {
  for (const SystemBlock& body : system.blocks) {
    if (!body.free) continue;
    for (int k = 0; k < 3; ++k) {
      double sum = 0;
      for (int i = body.first; i < body.first + body.count; ++i) sum += weigh(i) * numbers[3 * i + k];
      for (int i = body.first; i < body.first + body.count; ++i) numbers[3 * i + k] -= share(i) * sum / body.mass;
    }
  }
}

}  // namespace

ApplyFilter exact_filter(const SpringSystem& system) {
  const auto exact = std::make_shared<const ExactFactor>(system, OpenMP{1});
  return [exact](const std::vector<double>& forces) {
    PointArray<Serial, double> force(forces.size() / 3), acceleration(forces.size() / 3);
    const auto product = [&] { exact->filter.apply(FilterIo<double>{force.points(), acceleration.points(), false}); };
    return through_points(force, acceleration, exact->system.particle, product, forces);
  };
}

std::vector<double> noise_forces(const SpringSystem& system) {
  std::vector<double> forces = random_numbers(system.count());
  level(
      system, forces, [](int) { return 1.0; }, [&](int i) { return system.mass[i]; });
  return forces;
}

std::vector<double> elastic_forces(const SpringSystem& system) {
  const std::vector<double> d = random_numbers(system.count());
  std::vector<double> forces = multiply(system, d);
  for (std::size_t k = 0; k < forces.size(); ++k) forces[k] -= system.mass[k / 3] * d[k];
  return forces;
}

void remove_mean(const SpringSystem& system, std::vector<double>& accelerations) {
  level(
      system, accelerations, [&](int i) { return system.mass[i]; }, [](int) { return 1.0; });
}

double relative_difference(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> difference(a);
  for (std::size_t k = 0; k < a.size(); ++k) difference[k] -= b[k];
  return norm(difference) / norm(b);
}

Refined refined(const SpringSystem& system, const ApplyFilter& apply, const std::vector<double>& forces) {
  std::vector<double> x(forces.size(), 0), residual = forces;
  double before = INFINITY;  // the length of the previous step
  for (int turn = 0; turn < 40; ++turn) {
    // The residual is scaled to unit length, so that small values keep their digits in any precision.
    const double size = norm(residual);
    if (size == 0) break;
    for (double& number : residual) number /= size;
    std::vector<double> step = apply(residual);
    remove_mean(system, step);
    const double length = size * norm(step);
    if (!(length < before)) break;  // only rounding errors remain
    before = length;
    for (std::size_t k = 0; k < x.size(); ++k) x[k] += size * step[k];
    const std::vector<double> y = multiply(system, x);
    for (std::size_t k = 0; k < x.size(); ++k) residual[k] = forces[k] - y[k];
  }
  const double whole = norm(x);
  return {std::move(x), whole > 0 ? before / whole : 0};
}

}  // namespace malha
