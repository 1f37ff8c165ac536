// SPDX-License-Identifier: Apache-2.0
// A cantilever: a strip whose first two rows of particles are pinned, and which sags under its weight.
#pragma once
#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "tests/small_scenes.h"

namespace malha {

struct Cantilever {
  Shape shape;           // in the plane y = 0, rows along z
  double width, length;  // m
  int across, along;     // cells
  double density = 0.2;  // kg/m^2
};

/// The sag of its free end at rest, m, by `method`; `bends` is the constraint against bending, of a plate rigidity of
/// about D (N m).
inline double sag_of(const Cantilever& strip, const ConstraintSpec& bends, double D, const std::string& method) {
  BodySpec body;
  body.name = "strip", body.shape = strip.shape, body.density = strip.density;
  std::vector<int> held(2 * (strip.across + 1));
  std::iota(held.begin(), held.end(), 0);
  body.pins = {ListPin{held}};
  // Springs are soft enough for the filter, and stretch by no more than a thousandth under the weight.
  body.constraints = {compliant("distance", 5e-3, {"edges", "shear"}), bends};
  if (std::holds_alternative<MeshFile>(strip.shape)) body.constraints[0].elements = {"edges"};
  // One sweep a substep reaches a compliance up to (h / (l^2 sqrt(density / 4 D)))^2, where l is not the shortest
  // height.
  const double l = strip.length / strip.along, h = l * l * std::sqrt(strip.density / (4 * D)) / 10;
  Scene scene = scene_of({body}, kEarth, 1.0 / 60, method == "pbd" ? static_cast<int>(std::ceil(1 / (60 * h))) : 10);
  scene.solver.type = method;
  // The filter alone damps rotation, so that it would take minutes to rest.
  if (method == "desbrun") scene.solver.desbrun.refinement_iterations = 40;
  // Critical air drag on its slowest mode.
  const double swing = 3.516 / (strip.length * strip.length) * std::sqrt(D / strip.density);
  const double mass = strip.density * strip.width * strip.length;
  scene.wind = Wind{{0, 0, 0}, 2 * swing * mass / ((strip.across + 1) * (strip.along + 1))};
  Simulation simulation(scene, {.threads = 1});
  run_for(simulation, scene, 12 / swing);
  double lowest = 0;
  for (const Vec3& x : simulation.positions()) lowest = std::min(lowest, x[1]);
  return -lowest;
}

}  // namespace malha
