// SPDX-License-Identifier: Apache-2.0
// Graph of bodies at rest for coarsening: particles with normals and masses, and the links that keep them together.
#pragma once
#include <vector>

#include "kernels/parallel/compute.h"
#include "kernels/simd/vec.h"
#include "malha/mesh.h"

namespace malha {

using Vector = Vector3<double>;

/// A Vec3 as Vector.
inline Vector vector(const Vec3& a) { return {a[0], a[1], a[2]}; }

/// A mean normal shorter than this marks a fold: the surface has no tangent plane there.
inline constexpr double kFolded = 0.35;

struct Link {
  int a, b;
  double length;  // m, along the surface
  int set;        // constraint set that the link represents
};

struct RestGraph {
  std::vector<Vector> x;        // m
  std::vector<Vector> mean;     // m, mass centre of its finest particles; off the surface where that is curved
  std::vector<Vector> normal;   // unit normal of the surface; 0 for lines and solids
  std::vector<bool> folded;     // true where the surface has a crease and thus no tangent plane
  std::vector<Vector> stretch;  // static stretch, as in CoarseningGraph; empty: none
  std::vector<double> mass;     // kg
  std::vector<bool> pinned;
  std::vector<Link> links;   // pairs with a constraint between them
  std::vector<Edge> nearby;  // further neighbours, without a constraint between them, such as pairs of pins
  int count() const { return static_cast<int>(x.size()); }
};

struct Model;

/// The edges of `more`, then those of the links.
std::vector<Edge> edges_of(const std::vector<Link>& links, const std::vector<Edge>& more = {});

/// The graph of all bodies in the user's numbering, without links. `w` are the present inverse masses (1/kg) in the
/// solver's order, 0 for pinned particles.
RestGraph rest_graph(const Model& model, const std::vector<double>& w);

/// Weighted means of particles, one for each particle of another level. Mean i has the terms begin[i] .. begin[i + 1]
/// - 1.
struct Means {
  std::vector<int> begin{0}, of;  // of: the particle of each term
  std::vector<double> weight;     // of each term, >= 0; those of a mean sum to 1
  int count() const { return static_cast<int>(begin.size()) - 1; }
  void reserve(std::size_t means, std::size_t each) {
    begin.reserve(means + 1), of.reserve(means * each), weight.reserve(means * each);
  }
};

/// A coarser graph, with about a quarter of the particles of a sheet, an eighth of those of a solid, half of those of a
/// line.
struct Coarsening {
  RestGraph graph;
  std::vector<int> chosen;  // finer particle from which each coarse one was made
  Means restriction;        // for each coarse particle the mass centre of the finer ones that depend on it
  Means prolongation;       // for each finer particle a mean of at most 4 coarse ones
};

/// Coarsens a graph. Pinned coarse particles are made from pinned ones and keep their positions. The result is the same
/// for any number of threads.
Coarsening coarsen(const RestGraph& fine, const OpenMP& threads = 1);

}  // namespace malha
