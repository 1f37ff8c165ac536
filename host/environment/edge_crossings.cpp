// SPDX-License-Identifier: Apache-2.0
#include "host/environment/edge_crossings.h"

#include <algorithm>
#include <cmath>

#include "host/attachments/object_motion.h"
#include "host/mesh/topology.h"
#include "host/model/box_tree.h"
#include "host/model/edge_triangle_intersection.h"
#include "host/model/ordering/index_map.h"
#include "host/model/self_surface.h"
#include "host/model/tear.h"
#include "malha/error.h"

namespace malha {

namespace {

struct Surfaces {
  std::vector<Vec3> x;
  std::vector<Edge> edges;
  std::vector<Triangle> faces;
};

Surfaces surfaces_of(const Mesh& mesh, const std::vector<Vec3>& x) {
  Mesh triangular;
  triangular.points = mesh.points, triangular.lines = mesh.lines;
  for (const Triangle& t : triangles(mesh)) triangular.faces.push_back({t[0], t[1], t[2], -1});
  return {x, edges(triangular), triangles(mesh)};
}

/// Counts edges of one surface that go through faces of the other. Sets `first` to the first of them, unless it is set.
std::int64_t count_through(const Surfaces& one, const Surfaces& other, Edge& first) {
  std::vector<BoundingBox> boxes;
  for (const Triangle& face : other.faces) boxes.push_back(bounds_of(other.x, face));
  const BoundingBox all = bounds_of(other.x);
  const BoxTree tree(std::move(boxes));
  std::int64_t count = 0;
  for (const Edge& edge : one.edges) {
    const BoundingBox box = bounds_of(one.x, edge);
    if (!overlap(box, all)) continue;
    const Vec3 &p = one.x[edge[0]], &q = one.x[edge[1]];
    tree.for_each_overlap(box, [&](int f) {
      const auto& [a, b, c] = other.faces[f];
      if (!crosses(p, q, other.x[a], other.x[b], other.x[c])) return;
      if (count++ == 0 && first[0] < 0) first = edge;
    });
  }
  return count;
}

/// Calls found(object, body, count, an edge of the body or {-1, -1}) for every object and body that cross.
template <class Found>
void for_each_crossing(const Model& model, const std::vector<Vec3>& user, double time, const Found& found) {
  const RenderMesh& render_mesh = model.render_mesh;
  for (std::size_t e = 0; e < model.environment.size(); ++e) {
    const EnvironmentMesh& object = model.environment[e];
    if (!object.spec.edges) continue;
    const std::vector<Vec3> places = points_at(object, time);
    const Surfaces surface = surfaces_of(object.mesh, places);
    const BoundingBox around = bounds_of(places);
    for (std::size_t b = 0; b + 1 < render_mesh.body_begin.size(); ++b) {
      const Mesh mesh = body_mesh(render_mesh, b);
      const std::vector<Vec3> x(user.begin() + render_mesh.body_begin[b], user.begin() + render_mesh.body_begin[b + 1]);
      if (!overlap(bounds_of(x), around)) continue;
      const Surfaces soft = surfaces_of(mesh, x);
      Edge edge{-1, -1}, unused{-1, -1};
      const std::int64_t count = count_through(soft, surface, edge) + count_through(surface, soft, unused);
      if (count > 0) found(e, b, count, edge);
    }
  }
}

}  // namespace

std::int64_t count_edge_crossings(const Model& model, const std::vector<Vec3>& x, double time) {
  if (!std::all_of(x.begin(), x.end(), [](const Vec3& at) { return std::isfinite(at[0] + at[1] + at[2]); })) return 0;
  std::int64_t sum = 0;
  for_each_crossing(model, in_user_order(x, model.user_index), time,
                    [&](std::size_t, std::size_t, std::int64_t count, const Edge&) { sum += count; });
  return sum;
}

void refuse_edge_crossings(const Model& model) {
  if (!names_edges(model.scene)) return;
  for_each_crossing(
      model, in_user_order(model.x, model.user_index), 0,
      [&](std::size_t e, std::size_t b, std::int64_t count, const Edge& edge) {
        const auto name = [&](int i) { return particle_name(model, model.render_mesh.body_begin[b] + i); };
        const std::string where = edge[0] < 0
                                      ? "its edges go through body '" + model.scene.bodies[b].name + "'"
                                      : "the edge from " + name(edge[0]) + " to " + name(edge[1]) + " goes through it";
        refuse(model.scene.file, "/environment/" + std::to_string(e) + "/edges",
               "an object that a body crosses at the start: " + where + " (" + std::to_string(count) + " crossings)",
               "bodies that start apart from an object whose edges they touch");
      });
}

}  // namespace malha
