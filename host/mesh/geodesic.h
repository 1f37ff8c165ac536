// Distances along a mesh from some of its points.
#pragma once
#include <vector>

#include "host/mesh.h"

namespace malha {

/// Where the nearest source of each point is, and how far along the mesh.
struct Geodesics {
  std::vector<double> distance;  // m; infinite where no source can be reached
  std::vector<int> source;       // a point; -1 there
};

/// Along edges, lines, both diagonals of quads, and straight across triangles: two corners of a triangle that have
/// their distances from one source tell where that source lies in the triangle's unfolded plane, and so how far the
/// third corner is (Novotni and Klein, "Computing geodesic distances on triangular meshes", 2002, section 3).
/// Exact where the shortest way crosses flat surface only; never below the straight line. Behind a concave corner of 40
/// cells 0.6 % too long, across irregular flat triangles up to 0.7 %; on a sphere of 162 points up to 4 % too short, of
/// 10,242 up to 0.7 %. (Edges alone would be 41 % too long on a grid.)
Geodesics geodesics(const Mesh& mesh, const std::vector<int>& sources);

}  // namespace malha
