// SPDX-License-Identifier: Apache-2.0
#include "host/report/resolution.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "host/mesh/edge_sides.h"
#include "host/mesh/vectors.h"
#include "malha/text.h"

namespace malha {

namespace {

double shortest_edge(const RenderMesh& render_mesh) {
  double shortest = std::numeric_limits<double>::infinity();
  const auto side = [&](int a, int b) {
    const double length = distance(render_mesh.points[a], render_mesh.points[b]);
    if (length > 0) shortest = std::min(shortest, length);
  };
  for_each_face_side(render_mesh.faces, side);
  for (const auto& [a, b] : render_mesh.lines) side(a, b);
  return shortest;
}

template <class R>
double spacing_at(double a) {
  return double(std::nextafter(R(a), std::numeric_limits<R>::max()) - R(a));
}

double farthest_of(const std::vector<Vec3>& x) {
  double farthest = 0;
  for (const Vec3& p : x)
    for (const double a : p) farthest = std::max(farthest, std::abs(a));
  return farthest;
}

std::string metres(double a) {
  char text[32];
  std::snprintf(text, sizeof text,
                a >= 1000 ? "%.3g km"
                : a >= 1  ? "%.3g m"
                          : "%.2g mm",
                a >= 1000 ? a / 1000
                : a >= 1  ? a
                          : a * 1000);
  return text;
}

/// Returns whether the solver uses positions as the precision rounds them: in contacts with the environment, and in
/// Desbrun's method. PBD computes displacements and keeps the rounding remainders of positions, so that a hanging cloth
/// at 10 km differs by 3e-6 m from double precision; self-collision measures positions from an origin near the bodies.
bool uses_rounded_positions(const Scene& scene) { return scene.solver.type != "pbd" || !scene.environment.empty(); }

}  // namespace

Resolution resolution(const Model& model, const std::vector<Vec3>& x) {
  const double farthest = farthest_of(x);
  const bool twice = model.scene.solver.precision == Precision::Double;
  return {farthest, twice ? spacing_at<double>(farthest) : spacing_at<float>(farthest),
          shortest_edge(model.render_mesh)};
}

std::string resolution_warning(const Model& model, const std::vector<Vec3>& x) {
  const Resolution found = resolution(model, x);
  const Scene& scene = model.scene;
  if (!(found.strain() > 1e-3) || !uses_rounded_positions(scene)) return "";
  const bool twice = scene.solver.precision == Precision::Double;
  return std::string(twice ? "double" : "float") + " resolves " + metres(found.spacing) + " at " +
         metres(found.farthest) + " from the origin, where the shortest edge is " + metres(found.edge) + " long: " +
         (scene.solver.type == "pbd" ? "contacts with the environment are no more accurate"
                                     : "every rounding may strain it by " + shown(found.strain(), 2)) +
         (twice ? "; move the scene to the origin"
                : "; take \"precision\": \"double\" or move the scene to the origin");
}

}  // namespace malha
