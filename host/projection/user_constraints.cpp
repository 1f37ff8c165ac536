// SPDX-License-Identifier: Apache-2.0
#include "host/projection/user_constraints.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "host/mesh/compressed_lists.h"
#include "host/mesh/vectors.h"
#include "host/model/ordering/colour.h"
#include "kernels/projection/direction.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {

namespace {

std::string named(const UserConstraint& constraint) { return "constraint '" + constraint.name + "'"; }

/// Evaluates all constraints of a set at given positions, in one call.
struct EvaluateAll {
  const UserConstraint& constraint;
  std::vector<int> number;
  std::vector<Vec3> gradient;

  explicit EvaluateAll(const UserConstraint& of)
      : constraint(of), number(of.particles.size() / of.arity), gradient(of.particles.size()) {
    std::iota(number.begin(), number.end(), 0);
  }
  std::vector<double> operator()(const std::vector<Vec3>& x) {
    std::vector<double> C(number.size());
    evaluate(constraint, {static_cast<int>(number.size()), x.data(), number.data(), C.data(), gradient.data()});
    return C;
  }
};

}  // namespace

void require_sound(const UserConstraint& constraint, int particles) {
  const auto require = [&](bool good, const char* place, const std::string& found, const std::string& allowed) {
    if (!good) refuse(named(constraint), place, found, allowed);
  };
  const int k = constraint.arity;
  require(k >= 1 && k <= 1000, "arity", std::to_string(k), "1 to 1000 particles a constraint");
  const std::size_t listed = constraint.particles.size();
  require(listed > 0 && listed % k == 0, "particles", counted(listed, "number"),
          "some, " + std::to_string(k) + " a constraint");
  require(constraint.compliance >= 0 && constraint.compliance <= 1e18, "compliance", shown(constraint.compliance),
          "a number in [0, 1e18]");
  require(static_cast<bool>(constraint.evaluate), "function", "none", "one that gives C and its gradient");
  for (std::size_t i = 0; i < listed; ++i) {
    const int particle = constraint.particles[i];
    const std::string at = " in constraint " + std::to_string(i / k);
    require(particle >= 0 && particle < particles, "particles", "particle " + std::to_string(particle) + at,
            "0 to " + std::to_string(particles - 1));
    const auto first = constraint.particles.begin() + static_cast<std::ptrdiff_t>(i / k * k);
    require(std::count(first, first + k, particle) == 1, "particles",
            "particle " + std::to_string(particle) + " twice" + at, "different ones");
  }
}

UserBatches make_batches(const UserConstraint& constraint, const std::vector<int>& solver_of) {
  const int k = constraint.arity;
  std::vector<int> list;
  for (const int user : constraint.particles) list.push_back(solver_of[user]);
  const Colouring colours = colour(list, k, std::vector<bool>(solver_of.size(), false));
  CompressedLists<int> by_colour(colours.count, [&](const auto& add) {
    for (std::size_t c = 0; c < colours.colour.size(); ++c) add(colours.colour[c], static_cast<int>(c));
  });
  UserBatches batches{std::move(by_colour.begin), std::move(by_colour.list), {}};
  for (const int c : batches.index) batches.list.insert(batches.list.end(), &list[c * k], &list[c * k] + k);
  return batches;
}

void evaluate(const UserConstraint& constraint, const UserBatch& batch) {
  constraint.evaluate(batch);
  for (int c = 0; c < batch.count; ++c) {
    const std::string at = " in constraint " + std::to_string(batch.index[c]);
    if (!std::isfinite(batch.C[c])) refuse(named(constraint), "C", shown(batch.C[c]) + at, "finite numbers");
    for (int j = 0; j < constraint.arity; ++j)
      for (const double number : batch.gradient[c * constraint.arity + j])
        if (!std::isfinite(number)) refuse(named(constraint), "gradient", shown(number) + at, "finite numbers");
  }
}

void project(const UserConstraint& constraint, int count, const int* number, double h, const double* w, double* lambda,
             const Vec3* start, const Vec3* along, Vec3* x) {
  const int k = constraint.arity;
  const double alpha = constraint.compliance / (h * h);
  std::vector<double> C(count, 0);
  std::vector<Vec3> gradient(static_cast<std::size_t>(count) * k, Vec3{0, 0, 0});
  evaluate(constraint, {count, x, number, C.data(), gradient.data()});
  for (int c = 0; c < count; ++c) {
    double across = 0, now = 0, way = 0, size = 0;
    for (int j = c * k; j < (c + 1) * k; ++j) {
      across += w[j] * dot(gradient[j], along[j]), now += w[j] * dot(gradient[j], gradient[j]);
      way = std::max(way, w[j] * norm(along[j])), size = std::max(size, norm(minus(start[j], start[c * k])));
    }
    // One particle alone has no size, so its direction is that where it is (kernels/projection/direction.h).
    const double wanted = -C[c] - alpha * lambda[c];
    double share = 0;
    if (across > 0) {
      const double change = wanted / (across + alpha);
      const double farthest = (std::abs(lambda[c]) + std::abs(change)) * way;
      double bound = kMaxStartStep;
      if (k == 2)
        bound = bound_of_length(kMaxStartStep, kMaxCompressedStartStep,
                                (lambda[c] + change) * dot(along[2 * c + 1], minus(start[2 * c + 1], start[2 * c])));
      share = std::min(1.0, share_of(bound * size, farthest));
    }
    const double sum = across * share + now * (1 - share);
    if (!(sum > 0)) continue;  // nothing can move, or C has no slope: as of a constraint that does not act now
    const double change = wanted / (sum + alpha);
    lambda[c] += change;
    for (int j = c * k; j < (c + 1) * k; ++j)
      for (int axis = 0; axis < 3; ++axis)
        x[j][axis] += w[j] * (along[j][axis] * share + gradient[j][axis] * (1 - share)) * change;
  }
}

void check_gradients(const UserConstraint& constraint, const std::vector<Vec3>& x, double tolerance) {
  require_sound(constraint, static_cast<int>(x.size()));
  const int k = constraint.arity;
  std::vector<Vec3> at;
  for (const int particle : constraint.particles) at.push_back(x[particle]);
  EvaluateAll all(constraint);
  all(at);
  const std::vector<Vec3> given = all.gradient;
  std::vector<double> step(all.number.size(), 0);
  for (std::size_t i = 0; i < at.size(); ++i) step[i / k] = std::max(step[i / k], norm(minus(at[i], at[i / k * k])));
  for (double& one : step) one = 1e-5 * (one > 0 ? one : 1);
  std::vector<Vec3> found(at.size());
  for (int j = 0; j < k; ++j)
    for (int axis = 0; axis < 3; ++axis) {
      const auto moved = [&](double by) {
        std::vector<Vec3> there = at;
        for (std::size_t c = 0; c < step.size(); ++c) there[c * k + j][axis] += by * step[c];
        return all(there);
      };
      const std::vector<double> ahead = moved(1), behind = moved(-1);
      for (std::size_t c = 0; c < step.size(); ++c) found[c * k + j][axis] = (ahead[c] - behind[c]) / (2 * step[c]);
    }
  for (std::size_t c = 0; c < step.size(); ++c) {
    double largest = 0;
    for (std::size_t i = c * k; i < (c + 1) * k; ++i) largest = std::max({largest, norm(given[i]), norm(found[i])});
    for (std::size_t i = c * k; i < (c + 1) * k; ++i)
      for (int axis = 0; axis < 3; ++axis)
        if (!(std::abs(given[i][axis] - found[i][axis]) <= tolerance * largest))
          refuse(named(constraint),
                 "gradient of constraint " + std::to_string(c) + " by " + "xyz"[axis] + " of its particle " +
                     std::to_string(i - c * k),
                 shown(given[i][axis]),
                 "what finite differences give, " + shown(found[i][axis]) + ", to " + shown(tolerance) +
                     " of the largest");
  }
}

}  // namespace malha
