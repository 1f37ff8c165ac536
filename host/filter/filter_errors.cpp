#include "host/filter/filter_errors.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

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

}  // namespace

std::vector<double> noise_forces(const SpringSystem& system) {
  std::vector<double> forces = random_numbers(system.count());
  for (const SystemBlock& body : system.blocks) {
    if (!body.free) continue;
    for (int k = 0; k < 3; ++k) {
      double sum = 0;
      for (int i = body.first; i < body.first + body.count; ++i) sum += forces[3 * i + k];
      for (int i = body.first; i < body.first + body.count; ++i) forces[3 * i + k] -= system.mass[i] * sum / body.mass;
    }
  }
  return forces;
}

std::vector<double> elastic_forces(const SpringSystem& system) {
  const std::vector<double> d = random_numbers(system.count());
  std::vector<double> forces = multiply(system, d, 3);
  for (std::size_t k = 0; k < forces.size(); ++k) forces[k] -= system.mass[k / 3] * d[k];
  return forces;
}

void remove_mean(const SpringSystem& system, std::vector<double>& a) {
  for (const SystemBlock& body : system.blocks) {
    if (!body.free) continue;
    for (int k = 0; k < 3; ++k) {
      double sum = 0;
      for (int i = body.first; i < body.first + body.count; ++i) sum += system.mass[i] * a[3 * i + k];
      for (int i = body.first; i < body.first + body.count; ++i) a[3 * i + k] -= sum / body.mass;
    }
  }
}

double relative_difference(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> difference(a);
  for (std::size_t k = 0; k < a.size(); ++k) difference[k] -= b[k];
  return norm(difference) / norm(b);
}

std::vector<double> refined(const SpringSystem& system, const ApplyFilter& apply, const std::vector<double>& forces) {
  std::vector<double> x(forces.size(), 0), residual = forces;
  double before = INFINITY;
  for (int turn = 0; turn < 40; ++turn) {
    // Of unit size, so that small ones keep their digits in any precision.
    const double size = norm(residual);
    if (size == 0) break;
    for (double& number : residual) number /= size;
    std::vector<double> step = apply(residual);
    remove_mean(system, step);
    const double length = size * norm(step);
    if (!(length < before)) break;  // nothing is left but rounding
    before = length;
    for (std::size_t k = 0; k < x.size(); ++k) x[k] += size * step[k];
    const std::vector<double> y = multiply(system, x, 3);
    for (std::size_t k = 0; k < x.size(); ++k) residual[k] = forces[k] - y[k];
  }
  return x;
}

}  // namespace malha
