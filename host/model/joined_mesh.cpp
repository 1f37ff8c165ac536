// SPDX-License-Identifier: Apache-2.0
#include "host/model/joined_mesh.h"

#include <algorithm>

#include "host/mesh/bounding_box.h"
#include "host/mesh/edge_sides.h"
#include "host/mesh/topology.h"
#include "host/mesh/vectors.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {

namespace {

/// Appends a face, each point once, unless no area is left.
void add_face(const Quad& face, const Quad& rest, JoinedMesh& joined) {
  std::vector<int> corners, places;
  for (int k = 0; k < (is_triangle(face) ? 3 : 4); ++k)
    if (std::ranges::find(corners, face[k]) == corners.end()) corners.push_back(face[k]), places.push_back(rest[k]);
  if (corners.size() < 3) return;
  corners.resize(4, -1), places.resize(4, -1);
  joined.mesh.faces.push_back({corners[0], corners[1], corners[2], corners[3]});
  joined.rest.faces.push_back({places[0], places[1], places[2], places[3]});
}

}  // namespace

JoinedMesh join(const std::vector<Body>& bodies, const std::vector<std::size_t>& which, const std::vector<int>& place,
                const std::vector<int>& body_begin) {
  JoinedMesh joined;
  std::vector<int> point(place.size(), -1);  // of each place
  for (const std::size_t b : which) {
    const Body& body = bodies[b];
    for (std::size_t i = 0; i < body.mesh.points.size(); ++i) {
      const int particle = body_begin[b] + static_cast<int>(i);
      int& own = point[place[particle]];
      if (own < 0) {
        own = static_cast<int>(joined.particles.size());
        joined.mesh.points.push_back(body.mesh.points[i]), joined.particles.emplace_back();
      }
      joined.particles[own].push_back(particle);
    }
    const RestShape shape = body.shape();
    const Mesh& rest = shape.places();
    const int first = static_cast<int>(joined.rest.points.size());
    joined.rest.points.insert(joined.rest.points.end(), rest.points.begin(), rest.points.end());
    for (std::size_t f = 0; f < body.mesh.faces.size(); ++f) {
      Quad face = body.mesh.faces[f], at_rest = rest.faces[f];
      for (int& corner : face)
        if (corner >= 0) corner = point[place[body_begin[b] + corner]];
      for (int& corner : at_rest)
        if (corner >= 0) corner += first;
      add_face(face, at_rest, joined);
    }
  }
  for (auto& all : joined.particles) std::ranges::sort(all);
  return joined;
}

void require_closed(const JoinedMesh& joined, const std::string& file, const std::string& here,
                    const std::function<std::string(int)>& name) {
  const std::string allowed =
      "pressure of bodies whose meshes, joined at seams, have exactly two faces at every edge, consistently oriented "
      "outwards: list all of them in \"with\", and turn those that face inwards";
  const Mesh& mesh = joined.mesh;
  const auto refuse_edge = [&](const Side& side, const std::string& what) {
    refuse(file, here,
           what + " from " + name(joined.particles[side.low][0]) + " to " + name(joined.particles[side.high][0]),
           allowed);
  };
  const auto visit = [&](const auto& add) { for_each_face_side(mesh.faces, add); };
  for_each_edge(sorted_sides(mesh.points.size(), visit), [&](auto first, auto last) {
    if (last - first == 1) refuse_edge(*first, "an open edge");
    if (last - first > 2) refuse_edge(*first, "an edge with more than two faces");
    if (first[0].forward == first[1].forward) refuse_edge(*first, "faces of opposite orientations at the edge");
  });
  const auto [low, high] = bounds_of(mesh.points);
  const double size = distance(low, high), V = signed_volume(mesh.points, triangles(mesh));
  if (!(V > 1e-9 * size * size * size))
    refuse(file, here, "a joined mesh that encloses only " + shown(V, 2) + " m^3 at the start",
           "bodies with some space between them, whose faces are counter-clockwise seen from outside");
}

}  // namespace malha
