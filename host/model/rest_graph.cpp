// SPDX-License-Identifier: Apache-2.0
#include "host/model/rest_graph.h"

#include <algorithm>

#include "host/mesh/edge_sides.h"
#include "host/mesh/topology.h"
#include "host/model/model.h"
#include "host/model/tear.h"

namespace malha {

namespace {

/// The triangles that must be flipped so that neighbours are oriented consistently.
std::vector<bool> flipped_triangles(const Mesh& mesh, const std::vector<Triangle>& all) {
  const std::vector<int> opposite = opposite_sides(mesh.points.size(), all);
  std::vector<bool> visited(all.size(), false), flipped(all.size(), false);
  std::vector<int> front;
  for (std::size_t start = 0; start < all.size(); ++start) {
    if (visited[start]) continue;
    visited[start] = true, front = {static_cast<int>(start)};
    while (!front.empty()) {
      const int t = front.back();
      front.pop_back();
      for (int k = 0; k < 3; ++k) {
        const int other = opposite[3 * t + k];
        if (other < 0 || visited[other / 3]) continue;
        const bool alike = all[t][k] == all[other / 3][other % 3];  // both traverse the edge in the same direction
        visited[other / 3] = true, flipped[other / 3] = flipped[t] != alike;
        front.push_back(other / 3);
      }
    }
  }
  return flipped;
}

/// Computes unit normals of the points as sums over their triangles, and marks folds. Returns true if there are any.
bool sum_normals(const Mesh& mesh, const std::vector<Triangle>& all, const std::vector<bool>& flipped, Vector* normal,
                 std::vector<bool>& folded, std::size_t first) {
  std::vector<double> area(mesh.points.size(), 0);
  std::fill_n(normal, mesh.points.size(), Vector{0, 0, 0});
  for (std::size_t t = 0; t < all.size(); ++t) {
    const Vector a = vector(mesh.points[all[t][0]]);
    const Vector n = cross(vector(mesh.points[all[t][1]]) - a, vector(mesh.points[all[t][2]]) - a);
    for (const int corner : all[t])
      normal[corner] = normal[corner] + (!flipped.empty() && flipped[t] ? -n : n), area[corner] += norm(n);
  }
  bool any = false;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    const double size = norm(normal[i]);
    folded[first + i] = size < kFolded * area[i];
    any = any || folded[first + i];
    if (size > 0) normal[i] = normal[i] * (1 / size);
  }
  return any;
}

/// Computes the normals and folds of a mesh, whose triangles may be oriented inconsistently.
void compute_normals(const Mesh& mesh, Vector* normal, std::vector<bool>& folded, std::size_t first) {
  if (!mesh.tetrahedra.empty()) return;
  const std::vector<Triangle> all = triangles(mesh);
  if (sum_normals(mesh, all, {}, normal, folded, first))
    sum_normals(mesh, all, flipped_triangles(mesh, all), normal, folded, first);
}

/// Calls visit(i, j) for every side of a face, line and edge of a tetrahedron.
template <class Visit>
void for_each_side(const Mesh& mesh, const Visit& visit) {
  for_each_face_side(mesh.faces, visit);
  for (const Edge& line : mesh.lines) visit(line[0], line[1]);
  for (const Tetrahedron& t : mesh.tetrahedra)
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < j; ++k) visit(t[k], t[j]);
}

}  // namespace

std::vector<Edge> edges_of(const std::vector<Link>& links, const std::vector<Edge>& more) {
  std::vector<Edge> all;
  all.reserve(more.size() + links.size());
  all = more;
  for (const Link& l : links) all.push_back({l.a, l.b});
  return all;
}

RestGraph rest_graph(const Model& model, const std::vector<double>& w) {
  const int n = model.count();
  RestGraph graph;
  graph.x.resize(n), graph.normal.assign(n, Vector{0, 0, 0}), graph.folded.assign(n, false);
  graph.mass.resize(n), graph.pinned.resize(n);
  for (int i = 0; i < n; ++i) {
    graph.x[model.user_index[i]] = vector(model.at_rest()[i]);
    graph.mass[model.user_index[i]] = model.mass[i], graph.pinned[model.user_index[i]] = w[i] == 0;
  }
  graph.mean = graph.x;
  for (std::size_t b = 0; b + 1 < model.render_mesh.body_begin.size(); ++b) {
    Mesh mesh = body_mesh(model.render_mesh, b);
    const int first = model.render_mesh.body_begin[b];
    for (std::size_t i = 0; i < mesh.points.size() && !model.rest_x.empty(); ++i) {
      const Vector& at = graph.x[first + i];
      mesh.points[i] = {at.x, at.y, at.z};
    }
    compute_normals(mesh, &graph.normal[first], graph.folded, first);
    for_each_side(mesh, [&](int i, int j) {
      if (graph.pinned[first + i] && graph.pinned[first + j]) graph.nearby.push_back({first + i, first + j});
    });
  }
  return graph;
}

}  // namespace malha
