// SPDX-License-Identifier: Apache-2.0
// The surfaces of the bodies that collide with themselves and with each other, and what of them crosses: counted by
// itself, in double, with nothing of the solver's.
#pragma once
#include <cstdint>
#include <vector>

#include "host/model/model.h"
#include "kernels/geometry/simplex.h"

namespace malha {

struct SelfSurface {
  std::vector<Simplex> simplices;         // solver's numbers; in the order of their lowest particles
  std::vector<unsigned char> takes_part;  // a particle
  std::vector<int> body;                  // of each particle
  int particles = 0, edges = 0, triangles = 0;
};

/// Quads as triangles(mesh) splits them. Of the bodies that self_collision names, in a scene that has it.
SelfSurface self_surface(const Model& model);
/// The same of all bodies.
SelfSurface bodies_surface(const Model& model);

/// An edge that goes through a triangle, solver's numbers.
struct CrossingPair {
  Edge edge;
  Triangle triangle;
};

/// Edges that properly cross triangles of which they have no particle, at x (solver's order). `tried` grows by the
/// triangles whose boxes edges touch.
std::int64_t count_crossings(const SelfSurface& surface, const std::vector<Vec3>& x, std::int64_t* tried = nullptr);

/// Those, and edges that touch triangles of other bodies: bodies that are placed evenly cross a step later.
std::vector<CrossingPair> crossings_and_touches(const SelfSurface& surface, const std::vector<Vec3>& x);
/// The same in the solver's precision, before the first step: there what is almost apart may touch.
std::vector<CrossingPair> crossings_at_start(const Model& model, const SelfSurface& surface);

/// How many pairs of particles and triangles, and of edges, the solver's search would find, from a sample of the boxes:
/// within its reach of twice the thickness, and within the thickness. Those that share a particle are counted too.
struct PairEstimate {
  double looked_at = 0, near = 0;
};
PairEstimate estimate_pairs(const SelfSurface& surface, const std::vector<Vec3>& x, double thickness);

/// Refuses a model whose pairs at the start would not fit the memory that is left, and notes where they are very many.
void check_pairs(Model& model, const SelfSurface& surface);

/// Refuses a model whose bodies cross or touch at the start, or notes it where the scene ignores that.
void check_crossings(Model& model, const SelfSurface& surface);

}  // namespace malha
