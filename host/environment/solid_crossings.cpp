// SPDX-License-Identifier: Apache-2.0
#include "host/environment/solid_crossings.h"

#include <algorithm>
#include <string>
#include <vector>

#include "host/mesh/bounding_box.h"
#include "host/mesh/topology.h"
#include "host/model/box_tree.h"
#include "host/model/edge_triangle_intersection.h"
#include "malha/text.h"

namespace malha {

namespace {

struct SelfCrossings {
  int count = 0;
  std::vector<Vec3> places;  // midpoints of the first edges that cross, m
};

/// Finds edges of a mesh that properly cross its own triangles.
SelfCrossings self_crossings(const Mesh& mesh) {
  constexpr std::size_t max_entries = 3;
  const std::vector<Vec3>& x = mesh.points;
  const std::vector<Triangle> faces = triangles(mesh);
  std::vector<Edge> sides;
  for (const Triangle& t : faces)
    for (int k = 0; k < 3; ++k) sides.push_back({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
  std::sort(sides.begin(), sides.end());
  sides.erase(std::unique(sides.begin(), sides.end()), sides.end());
  std::vector<BoundingBox> boxes;
  boxes.reserve(faces.size());
  for (const Triangle& face : faces) boxes.push_back(bounds_of(x, face));
  const BoxTree tree(std::move(boxes));
  SelfCrossings found;
  for (const auto& [p, q] : sides) {
    const int before = found.count;
    tree.for_each_overlap(bounds_of(x, Edge{p, q}), [&, p = p, q = q](int f) {
      const auto& [a, b, c] = faces[f];
      if (p == a || p == b || p == c || q == a || q == b || q == c) return;
      found.count += crosses(x[p], x[q], x[a], x[b], x[c]);
    });
    if (found.count == before || found.places.size() == max_entries) continue;
    found.places.push_back({(x[p][0] + x[q][0]) / 2, (x[p][1] + x[q][1]) / 2, (x[p][2] + x[q][2]) / 2});
  }
  return found;
}

}  // namespace

void note_solid_crossings(Model& model) {
  for (const EnvironmentMesh& object : model.environment) {
    if (object.spec.sides != Sides::Solid) continue;
    const SelfCrossings found = self_crossings(object.mesh);
    if (found.count == 0) continue;
    std::string places;
    for (const Vec3& at : found.places)
      places += (places.empty() ? "" : ", ") + ("(" + shown(at[0]) + ", " + shown(at[1]) + ", " + shown(at[2]) + ")");
    model.notes.push_back("object '" + object.spec.name + "': its surface crosses itself, " +
                          counted(found.count, "edge") + " through triangles of its own, near " + places +
                          " m; there bodies may be pushed in, and depths be wrong: repair the mesh, or take \"sides\": "
                          "\"two_sided\"");
  }
}

}  // namespace malha
