// SPDX-License-Identifier: Apache-2.0
// Surfaces of the bodies that collide with themselves and with each other, and their intersections. These are counted
// in double precision, independently of the solver.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "host/mesh/compressed_lists.h"
#include "host/model/model.h"
#include "kernels/geometry/simplex.h"

namespace malha {

struct SelfSurface {
  std::vector<Simplex> simplices;         // in the solver's numbering, ordered by their lowest particles
  std::vector<unsigned char> takes_part;  // 1 for each particle that collides
  std::vector<int> body;                  // of each particle
  std::vector<int> sewn_body;             // of each particle the lowest of the bodies that seams connect with its own
  CompressedLists<int> sewn;              // see sewn_particles(): pairs of these do not collide
  int particles = 0, edges = 0, triangles = 0;
};

/// Tells whether the "self_collision" of the scene, if there is one, has this body.
bool self_collides(const Scene& scene, const std::string& body);

/// The surface of the bodies that the "self_collision" of the scene names; the scene must have one. Quads are split as
/// by triangles(mesh).
SelfSurface self_surface(const Model& model);
/// The surface of all bodies.
SelfSurface bodies_surface(const Model& model);

/// Where each particle (the solver's order) is at rest, from the first particle of its body, m; empty if no body has
/// places at rest apart from the start.
std::vector<Vec3> at_rest_in_bodies(const Model& model);

/// An edge that crosses a triangle, in the solver's numbering.
struct CrossingPair {
  Edge edge;
  Triangle triangle;
};

/// Number of pairs of an edge and a triangle without a common or sewn particle that cross at the positions x (m,
/// solver's order). If `tests` is given, it is increased by the number of pairs whose boxes overlap.
std::int64_t count_crossings(const SelfSurface& surface, const std::vector<Vec3>& x, std::int64_t* tests = nullptr);

/// The pairs that cross, and those of different bodies that touch: bodies placed exactly side by side cross a step
/// later.
std::vector<CrossingPair> crossings_and_touches(const SelfSurface& surface, const std::vector<Vec3>& x);
/// crossings_and_touches() of the start positions in the solver's precision, in which small gaps may close.
std::vector<CrossingPair> crossings_at_start(const Model& model, const SelfSurface& surface);

/// Estimated number of pairs, of particles with triangles and of edges with edges, that the broad phase of the solver
/// finds: within its search distance of twice the thickness (candidates), and within the thickness (near). It is
/// computed from a sample of the boxes and includes pairs with a common particle.
struct PairEstimate {
  double candidates = 0, near = 0;
};
PairEstimate estimate_pairs(const SelfSurface& surface, const std::vector<Vec3>& x, double thickness);

/// Throws OutOfMemory if the pairs at the start would not fit into the free memory, and adds a note if they are very
/// many.
void check_pairs(Model& model, const SelfSurface& surface);

/// Throws InputError if bodies cross or touch at the start, or adds a note if the scene ignores crossings.
void check_crossings(Model& model, const SelfSurface& surface);

}  // namespace malha
