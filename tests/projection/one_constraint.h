// SPDX-License-Identifier: Apache-2.0
// One constraint of any kind with particles of its own, for the tests that iterate over the registry.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "kernels/constraints/constraint_registry.h"
#include "tests/constraints/some_material.h"
#include "tests/numbers.h"

namespace malha {

template <class Kind>
using Corners = std::array<Vector3<double>, Kind::particles>;

/// A constraint's rest values; a single number fills all of them.
template <class Kind>
struct Rest : std::array<double, Kind::rest_values> {
  Rest(double all = 0) { this->fill(all); }
};

/// The particles are in rows (AoS) and gathered, laid out as a batch of one constraint that may have pins: padding has
/// no rest value and is not written. The substep begins where the particles are put.
template <class Kind, class R>
struct OneConstraint {
  static constexpr int n = Kind::particles;
  alignas(64) Vec4<R> memory[2 * n];  // positions at the start with inverse masses, then displacements
  alignas(64) LocalIndex index[n][kLanes<R>];
  alignas(64) R rest[Kind::rest_values * kSlotPack], lambda[multipliers<Kind>() * kSlotPack];
  R common[Kind::rest_values];
  R max_start_step = R(1e6);  // the correction goes along the gradient where the substep began, unless that turns

  OneConstraint(const Corners<Kind>& at, const std::array<double, n>& w, const Rest<Kind>& rest_values) {
    for (int j = 0; j < n; ++j) {
      memory[j] = {R(at[j].x), R(at[j].y), R(at[j].z), R(w[j])};
      memory[n + j] = {R(0), R(0), R(0), R(0)};
    }
    std::fill(std::begin(lambda), std::end(lambda), R(0));
    for (int lane = 0; lane < kLanes<R>; ++lane) {
      for (int j = 0; j < n; ++j) index[j][lane] = static_cast<LocalIndex>(j * kIndexScale<R>);
    }
    std::fill(std::begin(rest), std::end(rest), std::numeric_limits<R>::quiet_NaN());
    for (int k = 0; k < Kind::rest_values; ++k) rest[k * kSlotPack] = common[k] = R(rest_values[k]);
  }

  Vector3<R> start(int j) const { return memory[j].xyz(); }
  Vector3<R> way(int j) const { return memory[n + j].xyz(); }
  Vector3<R> p(int j) const { return start(j) + way(j); }
  /// Displaces a particle, as other constraints would since the substep began.
  void move(int j, const Vector3<double>& by) { memory[n + j].set(way(j) + Vector3<R>{R(by.x), R(by.y), R(by.z)}); }
  /// Starts a new substep at the current positions.
  void arrive() {
    for (int j = 0; j < n; ++j) memory[j].set(p(j)), memory[n + j].set({R(0), R(0), R(0)});
  }

  /// One projection. Lambda accumulates from call to call.
  template <Update update>
  void project(double stiffness, double compliance) {
    SetView<R> set{};
    set.update = update, set.rest_values = Kind::rest_values, set.rest = rest, set.lambda = lambda;
    set.stiffness = R(stiffness), set.compliance = R(compliance), set.from_start = true,
    set.max_start_step = set.max_compressed_start_step = max_start_step;
    for (int j = 0; j < n; ++j) set.index[j] = index[j];
    Batch batch{};
    batch.count = 1, batch.pins = true;
    malha::project<Kind, update>(Group<NativeIsa>{0, -1, nullptr}, AosView<R>::over(&memory[0].x, n), set, batch,
                                 false);
  }

  /// The constraint's value without the scale of evaluate(); 0 where there is no direction.
  R C() const {
    Vector3<R> grad[n];
    R scale;
    const R scaled = evaluate(grad, scale);
    return scale > R(0) ? scaled / scale : R(0);
  }
  /// Value and gradient as the kind returns them, scaled, from differences of positions as a projection takes them.
  R evaluate(Vector3<R> (&grad)[n], R& scale) const {
    Vector3<R> q[n];
    for (int j = 0; j < n; ++j) q[j] = (start(j) - start(0)) + (way(j) - way(0));
    return Kind::evaluate(q, common, true, grad, scale);
  }
};

/// C and its gradient in double, without the scale that a kind may return.
template <class Kind>
double evaluate(const Corners<Kind>& at, const Rest<Kind>& rest, Vector3<double> (&grad)[Kind::particles]) {
  Vector3<double> q[Kind::particles];
  for (int j = 0; j < Kind::particles; ++j) q[j] = at[j];
  double scale;
  const double scaled = Kind::evaluate(q, rest.data(), true, grad, scale);
  for (auto& g : grad) g = g * (1 / scale);
  return scaled / scale;
}

template <class Kind>
Rest<Kind> rest_of(const Corners<Kind>& at, double parameter) {
  Vector3<double> q[Kind::particles];
  for (int j = 0; j < Kind::particles; ++j) q[j] = at[j];
  double values[Kind::rest_values];
  Kind::rest(q, some_material<Kind>(parameter), values);
  Rest<Kind> rest;
  std::copy_n(values, Kind::rest_values, rest.begin());
  return rest;
}

template <class Kind>
std::array<double, Kind::particles> unequal_masses(Random& random) {
  std::array<double, Kind::particles> w;
  for (double& a : w) a = random(0.2, 5);
  return w;
}

/// A triangle with three neighbours, none a sliver, folded by up to a radian or so.
inline std::array<Vector3<double>, 6> winged_triangle(Random& random) {
  const double c = 0.5, s = 0.8660254037844386;  // corners of an equilateral triangle, and of the one twice as large
  std::array<Vector3<double>, 6> at{
      {{1, 0, 0}, {-c, s, 0}, {-c, -s, 0}, {-2, 0, 0}, {2 * c, -2 * s, 0}, {2 * c, 2 * s, 0}}};
  for (auto& a : at) a = (a + random.in_cube(0.25)) * 0.5;
  return at;
}

/// Points at random positions in a cube, none nearer than 0.3 to another or to the line through two others, so that
/// gradients are of the size of 1 to 10.
template <class Kind>
Corners<Kind> spread_out(Random& random) {
  if constexpr (Kind::element == Element::WingedTriangles) return winged_triangle(random);
  for (;;) {
    Corners<Kind> at;
    for (auto& a : at) a = random.in_cube();
    bool good = true;
    for (const auto& a : at)
      for (const auto& b : at)
        for (const auto& c : at) {
          if (&a == &b) continue;
          const Vector3<double> line = b - a;
          good = good && norm(line) > 0.3;
          if (&c != &a && &c != &b) good = good && norm(cross(line, c - a)) > 0.3 * norm(line);
        }
    if (good) return at;
  }
}

/// A hinge about the x axis, folded by `angle` (rad) about random triangles: 0 is flat, positive and negative are the
/// two sides.
inline std::array<Vector3<double>, 4> folded_hinge(Random& random, double angle) {
  const double far = random(0.5, 1), width = random(0.5, 1);
  return {{{0, 0, 0},
           {random(0.8, 1.2), 0, 0},
           {random(0.2, 0.8), far, 0},
           {random(0.2, 0.8), -width * std::cos(angle), width * std::sin(angle)}}};
}

/// The configurations that tests of every kind use: random positions, and for hinges folds close to a half turn on both
/// sides too.
template <class Kind>
std::vector<Corners<Kind>> configurations(int count, unsigned seed) {
  Random random(seed);
  std::vector<Corners<Kind>> all;
  for (int i = 0; i < count; ++i) all.push_back(spread_out<Kind>(random));
  if constexpr (Kind::element == Element::Hinges && Kind::particles == 4)
    for (const double angle : {-3.1, -3.0, -2.0, -1.0, -0.01, 0.0, 0.01, 1.0, 2.0, 3.0, 3.1})
      for (int i = 0; i < 5; ++i) all.push_back(folded_hinge(random, angle));
  return all;
}

/// Rest values that these positions violate, and for angles far from half a turn away: those of other random positions.
template <class Kind>
Rest<Kind> another_rest(const Corners<Kind>& at, Random& random) {
  for (;;) {
    const Rest<Kind> rest = rest_of<Kind>(spread_out<Kind>(random), Kind::parameter.default_value);
    Vector3<double> grad[Kind::particles];
    const double C = evaluate<Kind>(at, rest, grad);
    if (std::abs(C) > 0.05 && std::abs(C) < 3) return rest;
  }
}

}  // namespace malha
