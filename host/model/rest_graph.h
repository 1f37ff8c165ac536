// SPDX-License-Identifier: Apache-2.0
// A body at rest as its next coarser picture sees it: particles, and links that keep them together.
#pragma once
#include <vector>

#include "host/model/tangent.h"
#include "malha/mesh.h"

namespace malha {

/// A mean normal that is shorter says that the surface lies on itself.
inline constexpr double kFolded = 0.35;

struct Link {
  int a, b;
  double length;  // m, along the surface
  int set;        // of the constraints that it stands for
};

struct RestGraph {
  std::vector<Vector> x;       // m
  std::vector<Vector> mean;    // of the finest particles that it is the mass centre of: not on a curved surface
  std::vector<Vector> normal;  // of the surface there, a unit vector; 0: none, of lines and solids
  std::vector<bool> folded;    // whether the surface has an edge there, so that it has no tangent plane
  std::vector<Vector> give;    // how far weight stretches it (see stretch_by_weight()); empty: not at all
  std::vector<double> mass;    // kg
  std::vector<bool> pinned;
  std::vector<Link> links;   // what pulls
  std::vector<Edge> nearby;  // further neighbours, which nothing pulls together: pinned ones of each other
  int count() const { return static_cast<int>(x.size()); }
};

struct Model;

/// `more`, and those of links.
std::vector<Edge> edges_of(const std::vector<Link>& links, const std::vector<Edge>& more = {});

/// Of all bodies, in the user's numbers, without links. `w`: of the model's particles now, 1/kg, 0 where they are held.
RestGraph rest_graph(const Model& model, const std::vector<double>& w);

/// Of each particle a weighted mean of others.
struct Means {
  std::vector<int> begin{0}, of;
  std::vector<double> weight;  // >= 0, and those of a mean sum to 1
  int count() const { return static_cast<int>(begin.size()) - 1; }
  void reserve(std::size_t means, std::size_t each) {
    begin.reserve(means + 1), of.reserve(means * each), weight.reserve(means * each);
  }
};

/// A picture with about a quarter of the particles of a sheet, an eighth of a solid's, half of a line's.
struct Coarser {
  RestGraph graph;
  std::vector<int> chosen;  // of each coarse particle, the finer one in whose place it is
  Means up;                 // of each coarse particle: the mass centre of the finer ones that hang on it
  Means down;               // of each finer particle: the coarse ones that it follows, at most 4
};

/// The same on any `threads`. Pins come from pins, and stay where they are.
Coarser coarsen(const RestGraph& fine, int threads = 1);

}  // namespace malha
