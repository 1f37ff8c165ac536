// SPDX-License-Identifier: Apache-2.0
#include "host/model/cut.h"

#include <algorithm>
#include <map>
#include <set>

#include "malha/error.h"

namespace malha {

namespace {

/// The cut through one body, in the body's numbering. It runs on the side of the first ends of the edges.
class Cutter {
 public:
  Cutter(int body, const Mesh& mesh, const std::set<Edge>& crossed) : body_(body), mesh_(mesh), crossed_(crossed) {}

  std::vector<Split> find() {
    std::map<int, Split> splits;  // of each vertex on the cut; crossed faces and lines get its duplicate
    std::vector<int> incident(mesh_.points.size(), 0);
    const int faces = static_cast<int>(mesh_.faces.size()), lines = static_cast<int>(mesh_.lines.size());
    for (int e = 0; e < faces + lines; ++e) {
      const std::vector<int> corners = corners_of(e);
      for (const int corner : corners) ++incident[corner];
      for (const int corner : on_the_cut(corners)) {
        Split& split = splits.try_emplace(corner, Split{body_, corner, {}, {}}).first->second;
        e < faces ? split.faces.push_back(e) : split.lines.push_back(e - faces);
      }
    }
    std::vector<Split> found;
    for (auto& [vertex, split] : splits)
      if (static_cast<int>(split.faces.size() + split.lines.size()) < incident[vertex])
        found.push_back(std::move(split));
    return found;
  }

 private:
  std::vector<int> corners_of(int element) const {
    const int faces = static_cast<int>(mesh_.faces.size());
    if (element >= faces) {
      const Edge& line = mesh_.lines[element - faces];
      return {line[0], line[1]};
    }
    const Quad& face = mesh_.faces[element];
    return {face.begin(), face[3] < 0 ? face.end() - 1 : face.end()};
  }

  /// The corners at which a crossed face or line gets duplicates; none if it is not crossed.
  std::vector<int> on_the_cut(const std::vector<int>& corners) const {
    const std::size_t n = corners.size();
    std::vector<bool> cut(n, false), beyond(n, false);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j)
        if (crossed_.count({corners[i], corners[j]})) cut[i] = beyond[j] = true;
    // A face that the knife crosses completely is separated from all corners on one side of it. Otherwise the knife
    // ended inside of it.
    std::vector<bool> crossed_sides(n);
    for (std::size_t i = 0; i < n; ++i) crossed_sides[i] = is_crossed(corners[i], corners[(i + 1) % n]);
    if (std::count(crossed_sides.begin(), crossed_sides.end(), true) > 1)
      for (std::size_t round = 0; round < n; ++round)
        for (std::size_t i = 0; i < n; ++i) {
          const std::size_t next = (i + 1) % n;
          if (crossed_sides[i] || cut[i] == cut[next]) continue;
          const std::size_t other = cut[i] ? next : i;
          if (!beyond[other]) cut[other] = true;
        }
    std::vector<int> found;
    for (std::size_t i = 0; i < n; ++i)
      if (cut[i]) found.push_back(corners[i]);
    return found;
  }
  bool is_crossed(int a, int b) const { return crossed_.count({a, b}) || crossed_.count({b, a}); }

  int body_;
  const Mesh& mesh_;
  const std::set<Edge>& crossed_;
};

/// The body of an edge that is cut. Throws InputError for an edge that cannot be cut.
int body_to_cut(const Model& model, const Edge& edge) {
  for (const int end : edge)
    if (end < 0 || end >= model.count())
      throw InputError("cut: found particle " + std::to_string(end) + "; allowed: 0 to " +
                       std::to_string(model.count() - 1));
  const int body = body_of(model, edge[0]);
  if (body != body_of(model, edge[1]))
    throw InputError("cut: found " + particle_name(model, edge[0]) + " and " + particle_name(model, edge[1]) +
                     "; allowed: both of one body");
  if (!model.scene.bodies[body].tear)
    throw InputError("cut: found body '" + model.scene.bodies[body].name +
                     "', which does not tear; allowed: one with \"tear\"");
  return body;
}

}  // namespace

std::vector<Split> find_cuts(const Model& model, const std::vector<Edge>& crossed, const std::vector<bool>& pinned) {
  std::map<int, std::vector<Edge>> of_bodies;
  for (const Edge& edge : crossed) of_bodies[body_to_cut(model, edge)].push_back(edge);
  std::vector<Split> all;
  for (const auto& [body, edges] : of_bodies) {
    std::set<int> pinned_ends[2];  // on either side
    for (const Edge& edge : edges)
      for (const int side : {0, 1})
        if (pinned[edge[side]]) pinned_ends[side].insert(edge[side]);
    const int side = pinned_ends[1].size() < pinned_ends[0].size() ? 1 : 0, first = model.render_mesh.body_begin[body];
    std::set<Edge> directed;
    for (const Edge& edge : edges) directed.insert({edge[side] - first, edge[1 - side] - first});
    const Mesh mesh = body_mesh(model.render_mesh, body);
    const std::vector<Split> found = Cutter(body, mesh, directed).find();
    all.insert(all.end(), found.begin(), found.end());
  }
  return all;
}

}  // namespace malha
