// SPDX-License-Identifier: Apache-2.0
#include "host/filter/singular.h"

#include <algorithm>
#include <string>
#include <vector>

#include "host/base/median.h"
#include "host/model/stencils.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {

namespace {

/// The stiffest constraint: its largest stiffness at a corner (N/m), and the ratio to the median.
struct Stiffest {
  double stiffness = 0, times = 0;
  std::string type;
  std::vector<int> particles;
};

Stiffest stiffest_of(const Model& model) {
  Stiffest found;
  std::vector<double> all;
  const auto take = [&](double stiffness, const std::string& type, const int* particles, int n) {
    all.push_back(stiffness);
    if (stiffness > found.stiffness) found = {stiffness, 0, type, {particles, particles + n}};
  };
  for (const SpringSet& set : model.springs)
    for (std::size_t s = 0; s < set.ends.size(); ++s) take(set.stiffness[s], set.type, set.ends[s].data(), 2);
  for (const ConstraintSet& set : model.stencils)
    with_stencil(set, [&]<class Kind, class Stencil>(Kind, Stencil) {
      for (int c = 0; c < set.count(); ++c) {
        const StencilOf<Kind> one = stencil_of<Kind>(set, c, model.x);
        double most = 0;
        for (const auto& weights : one.weights)
          for (const double weight : weights) most = std::max(most, weight * weight / one.alpha);
        take(most, set.type, one.particles, Kind::particles);
      }
    });
  found.times = all.empty() ? 0 : found.stiffness / median(std::move(all));
  return found;
}

/// Ratio to the median from which a stiffness is named: double has 16 digits, and 10 are left to the other constraints.
constexpr double kStandsOut = 1e6;

}  // namespace

void refuse_singular(const Model& model, int particle) {
  const Stiffest one = stiffest_of(model);
  std::string found = "a system that is singular to working precision at " +
                      particle_name(model, model.user_index[particle]),
              allowed = "a stiffness times dt^2 that is less than 1e14 times the particles' masses";
  if (one.times > kStandsOut) {
    const std::string body = model.scene.bodies[body_of(model, model.user_index[one.particles[0]])].name;
    std::string vertices;
    for (const int i : one.particles)
      vertices += (vertices.empty() ? "" : "-") + std::to_string(number_in_body(model, model.user_index[i]));
    found += ", where '" + one.type + "' at vertices " + vertices + " of body '" + body + "' is " +
             shown(one.times, 2) + " times as stiff as most constraints";
    allowed += ", and triangles there that are less flat, or a \"stiffness\" or \"rigidity\" in place of a compliance";
  }
  refuse(model.scene.file, "/solver/dt", found, allowed);
}

}  // namespace malha
