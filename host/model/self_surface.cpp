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
#include "host/model/tear.h"
#include "kernels/self_collision/contact_block.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {

namespace {

/// Elements of one body in its own numbering: every particle and every edge belongs to the first that has it.
void add_simplices(const Mesh& mesh, SelfSurface& surface) {
  const int particles = static_cast<int>(mesh.points.size());
  std::vector<Simplex> own;
  for (const Triangle& t : triangles(mesh)) own.push_back({{t[0], t[1], t[2]}, 1 << 6});
  surface.triangles += static_cast<int>(own.size());
  for (const Edge& line : mesh.lines) own.push_back({{line[0], line[1], line[1]}, 0});
  std::vector<bool> has_one(particles, false);
  for (const Simplex& e : own)
    for (const int corner : e.corner) has_one[corner] = true;
  for (int i = 0; i < particles; ++i)
    if (!has_one[i]) own.push_back({{i, i, i}, 0});

  std::vector<bool> taken(particles, false);
  for (Simplex& e : own)
    for (int k = 0; k < 3; ++k)
      if (const int i = e.corner[k]; !taken[i]) e.has |= 1 << k, taken[i] = true;
  const auto visit = [&](const auto& add) {
    for (const Simplex& e : own)
      for (int k = 0; k < 3; ++k) add(e.from(k), e.to(k));
  };
  for_each_edge(sorted_sides(mesh.points.size(), visit), [&](auto first, auto /*last*/) {
    own[first->number / 3].has |= 1 << (3 + first->number % 3);
    ++surface.edges;
  });
  surface.particles += particles;
  surface.simplices.insert(surface.simplices.end(), own.begin(), own.end());
}

/// Of the bodies of these names, or, without any, of all.
SelfSurface surface_of(const Model& model, const std::vector<std::string>& named) {
  const RenderMesh& render_mesh = model.render_mesh;
  SelfSurface surface;
  const std::vector<int> number = solver_of(model.user_index);
  surface.takes_part.resize(number.size(), 0), surface.body.resize(number.size(), 0);
  for (std::size_t b = 0; b + 1 < render_mesh.body_begin.size(); ++b) {
    const int first = render_mesh.body_begin[b], particles = render_mesh.body_begin[b + 1] - first;
    for (int i = 0; i < particles; ++i) surface.body[number[first + i]] = static_cast<int>(b);
    if (!named.empty() && std::find(named.begin(), named.end(), model.scene.bodies[b].name) == named.end()) continue;
    const std::size_t before = surface.simplices.size();
    add_simplices(body_mesh(render_mesh, b), surface);
    for (std::size_t e = before; e < surface.simplices.size(); ++e)
      for (int& corner : surface.simplices[e].corner) corner = number[first + corner];
    for (int i = 0; i < particles; ++i) surface.takes_part[number[first + i]] = 1;
  }
  const auto lowest = [](const Simplex& e) { return std::min({e.corner[0], e.corner[1], e.corner[2]}); };
  std::stable_sort(surface.simplices.begin(), surface.simplices.end(),
                   [&](const Simplex& a, const Simplex& b) { return lowest(a) < lowest(b); });
  return surface;
}

}  // namespace

SelfSurface self_surface(const Model& model) { return surface_of(model, model.scene.self_collision->bodies); }
SelfSurface bodies_surface(const Model& model) { return surface_of(model, {}); }

namespace {

/// The directions in which the edges run most and least: along them the boxes of long thin triangles are thin too.
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

std::vector<Vec3> seen_along(const Eigen::Matrix3d& axes, const std::vector<Vec3>& x) {
  std::vector<Vec3> turned(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3 from = minus(x[i], x[0]);  // so that far from the origin turning costs no digits
    const Eigen::Vector3d at = axes * Eigen::Vector3d(from[0], from[1], from[2]);
    turned[i] = {at[0], at[1], at[2]};
  }
  return turned;
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

// A tree of the triangles' boxes, asked for what each edge touches: shares nothing with the solver's search.
std::vector<CrossingPair> find_crossings(const SelfSurface& surface, const std::vector<Vec3>& x, bool touching,
                                         std::int64_t* tried) {
  const Parts parts = parts_of(surface);
  const std::vector<Triangle>& faces = parts.faces;
  const std::vector<Edge>& edges = parts.edges;
  if (edges.empty() || faces.empty()) return {};
  if (!std::all_of(x.begin(), x.end(), [](const Vec3& at) { return std::isfinite(at[0] + at[1] + at[2]); })) return {};
  const std::vector<Vec3> turned = seen_along(main_directions(edges, x), x);
  double size = 0;
  for (const Vec3& at : turned) size = std::max({size, std::abs(at[0]), std::abs(at[1]), std::abs(at[2])});
  std::vector<BoundingBox> boxes;
  boxes.reserve(faces.size());
  for (const Triangle& face : faces) boxes.push_back(bounds_of(turned, face, 1e-12 * size));  // what turning rounds
  const BoxTree tree(std::move(boxes));

  std::vector<CrossingPair> found;
  std::vector<int> crossed;
  for (const auto& [p, q] : edges) {
    tree.for_each_on(turned[p], turned[q], [&, p = p, q = q](int f) {
      const auto& [a, b, c] = faces[f];
      if (tried != nullptr) ++*tried;
      if (p == a || p == b || p == c || q == a || q == b || q == c) return;
      const bool meet = touching && surface.body[p] != surface.body[a] ? touches(x[p], x[q], x[a], x[b], x[c])
                                                                       : crosses(x[p], x[q], x[a], x[b], x[c]);
      if (meet) crossed.push_back(f);
    });
    std::sort(crossed.begin(), crossed.end());  // whatever the order in which the tree names them
    for (const int f : crossed) found.push_back({{p, q}, faces[f]});
    crossed.clear();
  }
  return found;
}

}  // namespace

std::int64_t count_crossings(const SelfSurface& surface, const std::vector<Vec3>& x, std::int64_t* tried) {
  return std::ssize(find_crossings(surface, x, false, tried));
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
  model.notes.push_back("\"self_collision\": at the start " + said + "; what crosses collides once it has parted");
}

PairEstimate estimate_pairs(const SelfSurface& surface, const std::vector<Vec3>& x, double thickness) {
  constexpr std::size_t most_asked = 2000;
  PairEstimate estimate;
  const std::size_t n = surface.simplices.size();
  if (n == 0) return estimate;
  // As boxes along x, y and z the solver looks at them; what is near is so along the main directions too, in which long
  // thin triangles have thin boxes.
  const std::vector<Vec3> turned = seen_along(main_directions(parts_of(surface).edges, x), x);
  const auto tree_of = [&](const std::vector<Vec3>& at) {
    std::vector<BoundingBox> boxes;
    boxes.reserve(n);
    for (const Simplex& e : surface.simplices) boxes.push_back(bounds_of(at, e.corner, thickness));
    return BoxTree(std::move(boxes));
  };
  const BoxTree in_world = tree_of(x), in_main = tree_of(turned);
  const std::size_t step = (n + most_asked - 1) / most_asked;
  double looked_at = 0, near = 0, asked = 0;
  for (std::size_t e = 0; e < n; e += step, ++asked) {
    const auto& corners = surface.simplices[e].corner;
    looked_at += static_cast<double>(in_world.count_overlaps(bounds_of(x, corners, thickness)) - 1);
    const auto near_in = [&](const BoxTree& tree, const std::vector<Vec3>& at) {
      return tree.count_overlaps(bounds_of(at, corners, 0)) - 1;
    };
    near += static_cast<double>(std::min(near_in(in_world, x), near_in(in_main, turned)));
  }
  // A triangle has about half a particle and one and a half edges of its own: two have one pair of a particle with a
  // triangle and 2.25 of edges.
  const double per_two = (surface.triangles > 0 ? 3.25 : 1) / 2 * static_cast<double>(n) / asked;
  estimate.looked_at = per_two * looked_at, estimate.near = per_two * near;
  return estimate;
}

void check_pairs(Model& model, const SelfSurface& surface) {
  // Flat sheets with a thickness of one edge have some 230 a particle, of two edges 650.
  // Kept are those that may come nearer than is wanted: all near ones of bodies apart, few of what is near at rest.
  constexpr double most_per_particle = 500, most_numbered = 2147483647.0;
  const double thickness = model.scene.self_collision->thickness;
  const PairEstimate pairs = estimate_pairs(surface, model.x, thickness);
  const bool wide = model.scene.solver.precision == Precision::Double;
  constexpr double room = 1.4;  // for a quarter more, in blocks that are not all full
  const double block = wide ? sizeof(ContactBlock<double>) : sizeof(ContactBlock<float>);
  const double need = room * pairs.near * (block + sizeof(PairBits)) / kPairBlock;
  const auto there = static_cast<double>(available_memory());
  const std::string found = "some " + shown(std::round(pairs.looked_at)) +
                            " pairs whose boxes come nearer than twice the thickness of " + shown(thickness) +
                            " m at the start, for " + counted(surface.particles, "particle");
  if (need > there || pairs.looked_at > most_numbered)
    refuse<OutOfMemory>(
        model.scene.file, "/self_collision/thickness", found + ", which take up to " + in_gib(need),
        "pairs that take no more than the memory that is left, " + in_gib(there) +
            ", and no more than 2147483647 of them: a thickness below the length of the edges, and bodies apart from "
            "each other");
  if (pairs.looked_at > most_per_particle * surface.particles)
    model.notes.push_back("\"self_collision\": " + found + ", which will take long and up to " + in_gib(need) +
                          "; take a thickness below the length of the edges, and bodies that lie apart");
}

}  // namespace malha
