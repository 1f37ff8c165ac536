// SPDX-License-Identifier: Apache-2.0
#include "host/model/softening.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <type_traits>
#include <vector>

#include "host/base/median.h"
#include "kernels/constraints/constraint_registry.h"
#include "kernels/projection/rest.h"

namespace malha {

namespace {

/// Returns sum w |grad C|^2 / alpha of a constraint at rest, 1/s^2; 0 if none of its particles can move.
template <class Kind>
double squared_rate(const Model& model, const ConstraintSet& set, int c) {
  constexpr int n = Kind::particles;
  const int* of = &set.particles[std::size_t(c) * n];
  double rest[Kind::rest_values], scale = 0, sum = 0;
  const RestPositions<Vec3> at_rest = rest_positions(model, set);
  rest_values<Kind>(at_rest, c, material_of<Kind>(set, c), rest);
  Vector3<double> q[n], grad[n];
  at_rest.corners<Kind>(c, q);
  Kind::evaluate(q, rest, true, grad, scale);
  for (int j = 0; j < n; ++j) sum += model.w[of[j]] * dot(grad[j], grad[j]);
  return sum > 0 && scale > 0 ? sum / (set.alpha(c) * scale * scale) : 0;
}

/// Returns the share of s by which a sheet deforms too much.
template <class Kind>
constexpr double share_of_s() {
  return Kind::element == Element::WingedTriangles ? 0.7 : Kind::element == Element::Edges ? 0.6 : 0.5;
}

template <class Kind>
constexpr bool is_judged() {
  return bends<Kind>() || Kind::element == Element::Triangles || std::is_same_v<Kind, Distance>;
}

/// Number of rest angles of a constraint that bends, its first rest values.
template <class Kind>
constexpr int folds() {
  return Kind::element == Element::WingedTriangles ? 3 : 1;
}

/// Returns the bodies that a pressure of finite compliance inflates, so that pressure and skin balance as two
/// materials.
std::vector<bool> inflated_bodies(const Model& model) {
  std::vector<bool> of(model.scene.bodies.size(), false);
  for (const PressureSet& set : model.pressures)
    if (set.compliance.value_or(0) > 0 && set.volume_ratio > 1)
      for (const int i : set.particles) of[body_of(model, model.user_index[i])] = true;
  return of;
}

}  // namespace

Softening worst_softening(const Model& model) {
  Softening worst;
  const SolverSpec& solver = model.scene.solver;
  if (solver.type != "pbd") return worst;
  const double h = solver.dt / solver.substeps, n = solver.iterations;
  struct Sheet {
    std::vector<double> shares;
    std::string type;  // the most frequent type, because edges on the boundary of plates are hinges
    int most = 0;
  };
  std::map<std::pair<int, bool>, Sheet> sheets;  // two for each body: constraints that stretch, and those that bend
  const std::vector<bool> is_inflated = inflated_bodies(model);
  for (const ConstraintSet& set : model.sets)
    with_kind(set.type, [&]<class Kind>(Kind) {
      if constexpr (is_judged<Kind>()) {
        if (!(set.compliance.value_or(0) > 0)) return;
        std::map<int, int> count;
        for (int c = 0; c < set.count(); ++c) {
          const double rate = squared_rate<Kind>(model, set, c);
          if (!(rate > 0)) continue;
          const int body = body_of(model, model.user_index[set.particles[std::size_t(c) * Kind::particles]]);
          constexpr bool is_length = Kind::element == Element::Edges;
          if (is_length && !is_inflated[body]) continue;  // usually meant to be as stiff as the steps allow
          Sheet& sheet = sheets[{body, is_length || Kind::element == Element::Triangles}];
          sheet.shares.push_back(h * h * rate * share_of_s<Kind>() / (n * n));
          if (++count[body] > sheet.most) sheet.most = count[body], sheet.type = name_in_scenes<Kind>();
        }
      }
    });
  for (auto& [of, sheet] : sheets)
    if (const double share = median(sheet.shares); share > worst.share) worst = {share, of.first, sheet.type};
  return worst;
}

BendingStep bending_step(const Model& model, const ConstraintSet& set) {
  std::vector<double> all;
  double turning2 = 0, share = 0;
  const SolverSpec& solver = model.scene.solver;
  const double h = solver.dt / solver.substeps, n = solver.iterations;
  with_kind(set.type, [&]<class Kind>(Kind) {
    if constexpr (bends<Kind>())
      if (set.compliance.value_or(0) > 0)
        for (int c = 0; c < set.count(); ++c) {
          const double s = h * h * squared_rate<Kind>(model, set, c);
          if (!(s > 0)) continue;
          double rest[Kind::rest_values], fold = 0;
          rest_values<Kind>(rest_positions(model, set), c, material_of<Kind>(set, c), rest);
          for (int k = 0; k < folds<Kind>(); ++k) fold = std::max(fold, std::abs(rest[k]));
          all.push_back(s), turning2 += s * fold * fold, share = share_of_s<Kind>();
        }
  });
  if (all.empty()) return {};
  const double turning = std::sqrt(turning2 / static_cast<double>(all.size())), s = median(std::move(all));
  return {s, s * share / (n * n), turning};
}

}  // namespace malha
