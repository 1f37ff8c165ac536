// SPDX-License-Identifier: Apache-2.0
#include "host/model/self_surface.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "host/base/memory_size.h"
#include "host/mesh/edge_sides.h"
#include "host/mesh/topology.h"
#include "host/mesh/vectors.h"
#include "host/model/box_tree.h"
#include "host/model/edge_triangle_intersection.h"
#include "host/model/ordering/index_map.h"
#include "host/model/seams.h"
#include "host/model/tear.h"
#include "kernels/self_collision/contact_block.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {

namespace {

/// Adds the simplices of one body in its numbering. Each particle and each edge belongs to the first simplex with it.
void add_simplices(const Mesh& mesh, SelfSurface& surface) {
  const int particles = static_cast<int>(mesh.points.size());
  std::vector<Simplex> simplices;
  for (const Triangle& t : triangles(mesh)) simplices.push_back({{t[0], t[1], t[2]}, 1 << 6});
  surface.triangles += static_cast<int>(simplices.size());
  for (const Edge& line : mesh.lines) simplices.push_back({{line[0], line[1], line[1]}, 0});
  std::vector<bool> has_one(particles, false);
  for (const Simplex& e : simplices)
    for (const int corner : e.corner) has_one[corner] = true;
  for (int i = 0; i < particles; ++i)
    if (!has_one[i]) simplices.push_back({{i, i, i}, 0});

  std::vector<bool> owned(particles, false);
  for (Simplex& e : simplices)
    for (int k = 0; k < 3; ++k)
      if (const int i = e.corner[k]; !owned[i]) e.has |= 1 << k, owned[i] = true;
  const auto visit = [&](const auto& add) {
    for (const Simplex& e : simplices)
      for (int k = 0; k < 3; ++k) add(e.from(k), e.to(k));
  };
  for_each_edge(sorted_sides(mesh.points.size(), visit), [&](auto first, auto /*last*/) {
    simplices[first->number / 3].has |= 1 << (3 + first->number % 3);
    ++surface.edges;
  });
  surface.particles += particles;
  surface.simplices.insert(surface.simplices.end(), simplices.begin(), simplices.end());
}

/// The surface of the bodies with these names, or of all bodies if there are no names.
SelfSurface surface_of(const Model& model, const std::vector<std::string>& named) {
  const RenderMesh& render_mesh = model.render_mesh;
  SelfSurface surface;
  const std::vector<int> number = solver_of(model.user_index);
  surface.takes_part.resize(number.size(), 0), surface.body.resize(number.size(), 0);
  for (std::size_t b = 0; b + 1 < render_mesh.body_begin.size(); ++b) {
    const int first = render_mesh.body_begin[b], particles = render_mesh.body_begin[b + 1] - first;
    for (int i = 0; i < particles; ++i) surface.body[number[first + i]] = static_cast<int>(b);
    if (!named.empty() && std::ranges::find(named, model.scene.bodies[b].name) == named.end()) continue;
    const std::size_t before = surface.simplices.size();
    add_simplices(body_mesh(render_mesh, b), surface);
    for (std::size_t e = before; e < surface.simplices.size(); ++e)
      for (int& corner : surface.simplices[e].corner) corner = number[first + corner];
    for (int i = 0; i < particles; ++i) surface.takes_part[number[first + i]] = 1;
  }
  surface.sewn_body = surface.body;
  if (!model.scene.seams.empty()) {
    surface.sewn = sewn_particles(model);
    const std::vector<int> sewn = sewn_bodies(model);
    for (int& body : surface.sewn_body) body = sewn[body];
  }
  const auto lowest = [](const Simplex& e) { return std::min({e.corner[0], e.corner[1], e.corner[2]}); };
  std::ranges::stable_sort(surface.simplices,
                           [&](const Simplex& a, const Simplex& b) { return lowest(a) < lowest(b); });
  return surface;
}

}  // namespace

bool self_collides(const Scene& scene, const std::string& body) {
  const auto& self = scene.self_collision;
  return self && (self->bodies.empty() || std::ranges::find(self->bodies, body) != self->bodies.end());
}

SelfSurface self_surface(const Model& model) { return surface_of(model, model.scene.self_collision->bodies); }
SelfSurface bodies_surface(const Model& model) { return surface_of(model, {}); }

std::vector<Vec3> at_rest_in_bodies(const Model& model) {
  std::vector<Vec3> places = model.rest_x;
  if (places.empty()) return places;
  const std::vector<int> number = solver_of(model.user_index), body = bodies_of(model);
  for (std::size_t i = 0; i < places.size(); ++i)
    places[i] = minus(places[i], model.rest_x[number[model.render_mesh.body_begin[body[i]]]]);
  return places;
}

namespace {

/// The principal directions of the edges (as rows). Along these axes the boxes of long thin triangles are thin too.
Eigen::Matrix3d main_directions(const std::vector<Edge>& edges, const std::vector<Vec3>& x) {
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const auto& [a, b] : edges) {
    const Vec3 along = minus(x[b], x[a]);
    const Eigen::Vector3d e(along[0], along[1], along[2]);
    spread += e * e.transpose();
  }
  if (!spread.allFinite()) return Eigen::Matrix3d::Identity();
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().transpose();
}

/// The positions in a frame with these axes and its origin at x[0].
std::vector<Vec3> rotated_to(const Eigen::Matrix3d& axes, const std::vector<Vec3>& x) {
  std::vector<Vec3> rotated(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3 from = minus(x[i], x[0]);  // keeps precision far from the origin
    const Eigen::Vector3d at = axes * Eigen::Vector3d(from[0], from[1], from[2]);
    rotated[i] = {at[0], at[1], at[2]};
  }
  return rotated;
}

struct Parts {
  std::vector<Edge> edges;
  std::vector<Triangle> faces;
};

Parts parts_of(const SelfSurface& surface) {
  Parts parts;
  for (const Simplex& e : surface.simplices) {
    for (int k = 0; k < 3; ++k)
      if (e.owns_edge(k)) parts.edges.push_back({e.from(k), e.to(k)});
    if (e.is_face()) parts.faces.push_back({e.corner[0], e.corner[1], e.corner[2]});
  }
  return parts;
}

/// Tells whether a seam holds a particle at a corner of a triangle, or at the triangle.
bool is_sewn(const SelfSurface& surface, int particle, const Triangle& face) {
  return std::ranges::any_of(surface.sewn[particle],
                             [&](int i) { return i == face[0] || i == face[1] || i == face[2]; });
}

/// Finds the pairs by a tree of the triangles' boxes, independently of the solver's broad phase. With `touching`, pairs
/// of different bodies that touch count too.
std::vector<CrossingPair> find_crossings(const SelfSurface& surface, const std::vector<Vec3>& x, bool touching,
                                         std::int64_t* tests) {
  const Parts parts = parts_of(surface);
  const std::vector<Triangle>& faces = parts.faces;
  const std::vector<Edge>& edges = parts.edges;
  if (edges.empty() || faces.empty()) return {};
  if (!std::ranges::all_of(x, [](const Vec3& at) { return std::isfinite(at[0] + at[1] + at[2]); })) return {};
  const std::vector<Vec3> rotated = rotated_to(main_directions(edges, x), x);
  double size = 0;
  for (const Vec3& at : rotated) size = std::max({size, std::abs(at[0]), std::abs(at[1]), std::abs(at[2])});
  std::vector<BoundingBox> boxes;
  boxes.reserve(faces.size());
  for (const Triangle& face : faces)
    boxes.push_back(bounds_of(rotated, face, 1e-12 * size));  // tolerance for the rotation
  const BoxTree tree(std::move(boxes));

  std::vector<CrossingPair> found;
  std::vector<int> crossed;
  for (const auto& [p, q] : edges) {
    tree.for_each_overlap(bounds_of(rotated, Edge{p, q}), [&, p = p, q = q](int f) {
      const auto& [a, b, c] = faces[f];
      if (tests != nullptr) ++*tests;
      if (p == a || p == b || p == c || q == a || q == b || q == c) return;
      if (!surface.sewn.list.empty() && (is_sewn(surface, p, faces[f]) || is_sewn(surface, q, faces[f]))) return;
      const bool meet = touching && surface.body[p] != surface.body[a] ? touches(x[p], x[q], x[a], x[b], x[c])
                                                                       : crosses(x[p], x[q], x[a], x[b], x[c]);
      if (meet) crossed.push_back(f);
    });
    std::ranges::sort(crossed);  // the order of the tree is unspecified
    for (const int f : crossed) found.push_back({{p, q}, faces[f]});
    crossed.clear();
  }
  return found;
}

}  // namespace

std::int64_t count_crossings(const SelfSurface& surface, const std::vector<Vec3>& x, std::int64_t* tests) {
  return std::ssize(find_crossings(surface, x, false, tests));
}

std::vector<CrossingPair> crossings_and_touches(const SelfSurface& surface, const std::vector<Vec3>& x) {
  return find_crossings(surface, x, true, nullptr);
}

std::vector<CrossingPair> crossings_at_start(const Model& model, const SelfSurface& surface) {
  std::vector<Vec3> x = model.x;
  if (model.scene.solver.precision == Precision::Float)
    for (Vec3& at : x)
      for (double& coordinate : at) coordinate = static_cast<float>(coordinate);
  return crossings_and_touches(surface, x);
}

void check_crossings(Model& model, const SelfSurface& surface) {
  const std::vector<CrossingPair> found = crossings_at_start(model, surface);
  if (found.empty()) return;
  const auto name = [&](int i) { return particle_name(model, model.user_index[i]); };
  const std::string said = "the edge from " + name(found[0].edge[0]) + " to " + name(found[0].edge[1]) +
                           " goes through or touches the triangle at " + name(found[0].triangle[0]) + " (" +
                           std::to_string(found.size()) + " such pairs in all)";
  if (!model.scene.self_collision->ignores_crossings)
    refuse(model.scene.file, "/self_collision", "bodies that cross or touch at the start: " + said,
           "bodies that neither touch each other nor cross themselves, or \"crossing_at_start\": \"ignore\"");
  model.notes.push_back("\"self_collision\": at the start " + said +
                        "; these primitives collide once they have separated");
}

PairEstimate estimate_pairs(const SelfSurface& surface, const std::vector<Vec3>& x, double thickness) {
  constexpr std::size_t max_samples = 2000;
  PairEstimate estimate;
  const std::size_t n = surface.simplices.size();
  if (n == 0) return estimate;
  // The broad phase of the solver uses boxes along x, y and z. Near pairs overlap also along the principal directions,
  // in which long thin triangles have thin boxes.
  const std::vector<Vec3> rotated = rotated_to(main_directions(parts_of(surface).edges, x), x);
  const auto tree_of = [&](const std::vector<Vec3>& at) {
    std::vector<BoundingBox> boxes;
    boxes.reserve(n);
    for (const Simplex& e : surface.simplices) boxes.push_back(bounds_of(at, e.corner, thickness));
    return BoxTree(std::move(boxes));
  };
  const BoxTree in_world = tree_of(x), in_main = tree_of(rotated);
  const std::size_t step = (n + max_samples - 1) / max_samples;
  double candidates = 0, near = 0, samples = 0;
  for (std::size_t e = 0; e < n; e += step, ++samples) {
    const auto& corners = surface.simplices[e].corner;
    candidates += static_cast<double>(in_world.count_overlaps(bounds_of(x, corners, thickness)) - 1);
    const auto near_in = [&](const BoxTree& tree, const std::vector<Vec3>& at) {
      return tree.count_overlaps(bounds_of(at, corners, 0)) - 1;
    };
    near += static_cast<double>(std::min(near_in(in_world, x), near_in(in_main, rotated)));
  }
  // A triangle has about half a particle and one and a half edges of its own. Two triangles thus have one pair of a
  // particle with a triangle and 2.25 pairs of edges.
  const double per_two = (surface.triangles > 0 ? 3.25 : 1) / 2 * static_cast<double>(n) / samples;
  estimate.candidates = per_two * candidates, estimate.near = per_two * near;
  return estimate;
}

void check_pairs(Model& model, const SelfSurface& surface) {
  // Flat sheets with a thickness of one edge have some 230 pairs per particle, of two edges 650. Only the pairs that
  // may come too near are stored: all near ones of separate bodies, few of those that are near at rest.
  constexpr double most_per_particle = 500, most_numbered = 2147483647.0;
  const double thickness = model.scene.self_collision->thickness;
  const PairEstimate pairs = estimate_pairs(surface, model.x, thickness);
  const bool wide = model.scene.solver.precision == Precision::Double;
  constexpr double reserve = 1.4;  // capacity for a quarter more pairs, in blocks that are partly filled
  const double block = wide ? sizeof(ContactBlock<double>) : sizeof(ContactBlock<float>);
  const double need = reserve * pairs.near * (block + sizeof(PairBits)) / kPairBlock;
  const auto there = static_cast<double>(available_memory());
  const std::string found = "some " + shown(std::round(pairs.candidates)) +
                            " pairs whose boxes come nearer than twice the thickness of " + shown(thickness) +
                            " m at the start, for " + counted(surface.particles, "particle");
  if (need > there || pairs.candidates > most_numbered)
    refuse<OutOfMemory>(
        model.scene.file, "/self_collision/thickness", found + ", which take up to " + in_gib(need),
        "pairs that fit into the free memory, " + in_gib(there) +
            ", and no more than 2147483647 of them: a thickness below the length of the edges, and bodies apart from "
            "each other");
  if (pairs.candidates > most_per_particle * surface.particles)
    model.notes.push_back("\"self_collision\": " + found + ", which will take long and up to " + in_gib(need) +
                          "; take a thickness below the length of the edges, and bodies that lie apart");
}

}  // namespace malha
