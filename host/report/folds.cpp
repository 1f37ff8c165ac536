// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <vector>

#include "host/mesh/edge_sides.h"
#include "host/mesh/topology.h"
#include "host/mesh/vectors.h"
#include "host/model/material.h"
#include "host/model/ordering/index_map.h"
#include "host/model/tear.h"
#include "host/report/failure_boundaries.h"

namespace malha {

namespace {

constexpr double kMinFoldSine = 0.5;  // sine of the smallest angle that counts as a fold

/// Bending stiffness of a body: the sum of rigidities (N m), and of 1 / compliance of constraints that have one
/// instead.
struct BendingStiffness {
  double rigidity = 0, per_hinge = 0;
};

BendingStiffness bending_of(const BodySpec& body) {
  BendingStiffness sum;
  for (const ConstraintSpec& spec : body.constraints) {
    if (spec.type != "bending" && spec.type != "isometric_bending" && spec.type != "plate") continue;
    if (spec.rigidity)
      sum.rigidity += spec.orthotropy ? std::min(*spec.rigidity, spec.orthotropy->across) : *spec.rigidity;
    else if (spec.compliance.value_or(0) > 0)
      sum.per_hinge += 1 / *spec.compliance;
    else
      return {};  // the steps limit the stiffness, and no material is given
  }
  return sum;
}

/// A pinned edge of a face that is not pinned, with another face beyond it.
struct ClampedEdge {
  int from, to;
  int free;                                  // a movable corner of the face
  double length, height, area, area_beyond;  // height: of the face over this edge
  Vec3 away;                                 // unit vector from the edge into the face
};

std::vector<ClampedEdge> clamped_edges(const Mesh& mesh, const std::vector<bool>& held) {
  std::vector<int> face_of;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    face_of.insert(face_of.end(), is_triangle(mesh.faces[f]) ? 3 : 4, static_cast<int>(f));
  std::vector<ClampedEdge> lines;
  const auto sides = sorted_sides(mesh.points.size(), [&](auto add) { for_each_face_side(mesh.faces, add); });
  for_each_edge(sides, [&](auto first, auto last) {
    if (last - first != 2 || !held[first->low] || !held[first->high]) return;
    for (int k = 0; k < 2; ++k) {
      const Quad &face = mesh.faces[face_of[first[k].number]], &beyond = mesh.faces[face_of[first[1 - k].number]];
      ClampedEdge line{first->low, first->high, -1, 0, 0, face_area(mesh, face), face_area(mesh, beyond), {}};
      const Vec3 from = mesh.points[line.from], edge = minus(mesh.points[line.to], from);
      line.length = norm(edge);
      for (int c = 0; c < (is_triangle(face) ? 3 : 4); ++c) {
        if (held[face[c]]) continue;
        const Vec3 r = minus(mesh.points[face[c]], from);
        const double along = dot(r, edge) / dot(edge, edge);
        const Vec3 across{r[0] - along * edge[0], r[1] - along * edge[1], r[2] - along * edge[2]};
        if (const double height = norm(across); height > line.height)
          line.height = height, line.free = face[c],
          line.away = {across[0] / height, across[1] / height, across[2] / height};
      }
      if (line.free >= 0 && line.length > 0) lines.push_back(line);
    }
  });
  return lines;
}

}  // namespace

HangingFold sharpest_fold(const Model& model) {
  HangingFold sharpest;
  const Vec3& gravity = model.scene.gravity;
  const double g = norm(gravity);
  if (!(g > 0)) return sharpest;
  std::vector<int> number;  // the solver's index of each particle
  std::vector<bool> held_there;
  for (std::size_t b = 0; b < model.scene.bodies.size(); ++b) {
    const BendingStiffness bends = bending_of(model.scene.bodies[b]);
    if (!(bends.rigidity + bends.per_hinge > 0)) continue;
    if (number.empty()) number = solver_of(model.user_index), held_there = fixed_at_start(model, true);
    const Mesh mesh = body_mesh(model.render_mesh, b);
    const int first = model.render_mesh.body_begin[b], count = static_cast<int>(mesh.points.size());
    std::vector<bool> held(count);
    for (int i = 0; i < count; ++i) held[i] = held_there[number[first + i]];
    const std::vector<ClampedEdge> lines = clamped_edges(mesh, held);
    if (lines.empty()) continue;

    // Connected parts of movable particles, their weights, and the length of the edges that clamp each.
    std::vector<Edge> links;
    for_each_face_side(mesh.faces, [&](int from, int to) {
      if (!held[from] && !held[to]) links.push_back({from, to});
    });
    int parts = 0;
    const std::vector<int> part = components(count, links, parts);
    std::vector<double> weight(parts), width(parts);
    for (int i = 0; i < count; ++i)
      if (const double w = model.w[number[first + i]]; !held[i] && w > 0) weight[part[i]] += g / w;
    for (const ClampedEdge& line : lines) width[part[line.free]] += line.length;
    for (const ClampedEdge& line : lines) {
      const double down = dot(line.away, gravity) / g;
      if (down > 0 && 1 - down * down < kMinFoldSine * kMinFoldSine) continue;
      const double D = bends.rigidity + bends.per_hinge * (line.area + line.area_beyond) / (line.length * line.length);
      const double tension = weight[part[line.free]] / width[part[line.free]];
      const HangingFold fold{std::sqrt(D / tension), line.height, static_cast<int>(b)};
      if (fold.spacing > 0 && (!(sharpest.spacing > 0) || fold.edges() < sharpest.edges())) sharpest = fold;
    }
  }
  return sharpest;
}

}  // namespace malha
