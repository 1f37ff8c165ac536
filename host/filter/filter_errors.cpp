#include "host/filter/filter_errors.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "host/base/point_array.h"
#include "host/filter/factor.h"
#include "host/filter/sparse_filter.h"

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

struct ExactFilter::Parts {
  explicit Parts(const SpringSystem& system)
      : of_unknowns(with_unknowns_for_particles(system)),
        all(supernodes(of_unknowns)),
        cut(subtrees(all)),
        filter(Serial{}, 1, of_unknowns, all, cut) {
    factor(of_unknowns, all, cut, OpenMP{1}, [this](int s, const double* panel) { filter.take(s, panel); }, {});
  }
  static SpringSystem with_unknowns_for_particles(SpringSystem system) {
    std::iota(system.particle.begin(), system.particle.end(), 0);
    return system;
  }
  SpringSystem of_unknowns;
  Supernodes all;
  Subtrees cut;
  SparseFilter<Serial, double> filter;
};

ExactFilter::ExactFilter(const SpringSystem& system) : parts_(std::make_unique<Parts>(system)) {}
ExactFilter::~ExactFilter() = default;

std::vector<double> ExactFilter::operator()(const std::vector<double>& forces) const {
  const std::size_t n = forces.size() / 3;
  PointArray<Serial, double> force(n), acceleration(n);
  std::vector<Vec3> points(n);
  for (std::size_t k = 0; k < forces.size(); ++k) points[k / 3][k % 3] = forces[k];
  force.upload(points);
  parts_->filter.apply(FilterEnds<double>{force.points(), acceleration.points(), false});
  points = acceleration.download();
  std::vector<double> a(forces.size());
  for (std::size_t k = 0; k < a.size(); ++k) a[k] = points[k / 3][k % 3];
  return a;
}

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

Refined refined(const SpringSystem& system, const ApplyFilter& apply, const std::vector<double>& forces) {
  std::vector<double> x(forces.size(), 0), residual = forces;
  double before = INFINITY;  // the last step's length
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
  const double whole = norm(x);
  return {std::move(x), whole > 0 ? before / whole : 0};
}

}  // namespace malha
