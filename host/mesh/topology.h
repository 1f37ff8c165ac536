// SPDX-License-Identifier: Apache-2.0
// Topology of meshes: edges, hinges, connected components, volume and lumped masses. All results are deterministic and
// follow the order of the faces; all functions take (nearly) linear time.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "malha/mesh.h"

namespace malha {

/// The edges of a mesh: every side of a face, every line and every edge of a tetrahedron once, the lower point first,
/// in the order of first appearance in faces, lines and tetrahedra.
std::vector<Edge> edges(const Mesh& mesh);

/// The diagonals of every quad: 0-2, then 1-3.
std::vector<Edge> shear(const Mesh& mesh);

/// The faces as triangles: a quad becomes (0, 1, 2) and (0, 2, 3).
std::vector<Triangle> triangles(const Mesh& mesh);

/// For each side of each triangle (3 t + k, from its corner k to the next) the side of the other triangle at that edge;
/// -1 at edges with one triangle or with more than two. If `non_manifold` is given, the number of the latter is added
/// to it.
std::vector<int> opposite_sides(std::size_t points, const std::vector<Triangle>& triangles,
                                int* non_manifold = nullptr);

/// The hinges {a, b, c, d} of a mesh: one for every edge a-b that the triangle (a, b, c) of triangles(mesh) shares with
/// one other triangle of corners a, b, d, in the order of first appearance. Diagonals of quads are included. The
/// orientation of the triangles does not matter. Edges with one triangle or with more than two have no hinge; the
/// number of the latter is added to `non_manifold`, if it is given.
std::vector<std::array<int, 4>> hinges(const Mesh& mesh, int* non_manifold = nullptr);

/// The connected component of each particle. Components are numbered from 0 in the order of their lowest particles;
/// `count` gets their number.
std::vector<int> components(int particles, const std::vector<Edge>& edges, int& count);

/// The volume (m^3) that a closed mesh encloses; negative if the faces point inwards.
double signed_volume(const std::vector<Vec3>& points, const std::vector<Triangle>& triangles);

/// The lumped mass (kg) of each point for `density` in kg/m^2 of faces and kg/m of lines. A triangle gives a third of
/// its mass to each corner, a quad the mean over its two triangulations, a line half to each end; a point without faces
/// and lines gets 0. In a mesh with tetrahedra `density` is in kg/m^3, and each tetrahedron gives a quarter of its mass
/// to each corner; faces then have no mass.
/// `rest`, a mesh in the form of RestShape (host/mesh/rest_shape.h), has the areas, lengths and volumes.
std::vector<double> masses_by_density(const Mesh& mesh, double density, const Mesh& rest);
inline std::vector<double> masses_by_density(const Mesh& mesh, double density) {
  return masses_by_density(mesh, density, mesh);
}

/// The masses (kg) in the same proportions, scaled to a total of `mass` (kg). A point without faces and lines gets the
/// equal share mass / points.
std::vector<double> masses_by_total(const Mesh& mesh, double mass, const Mesh& rest);
inline std::vector<double> masses_by_total(const Mesh& mesh, double mass) { return masses_by_total(mesh, mass, mesh); }

/// Throws InputError for a mesh that is not a closed surface oriented outwards: for an edge with one face (open) or
/// with more than two, for neighbours with opposite orientations, and for an enclosed volume that is not positive
/// (inside out). `why` is the reason in the message, such as "pressure needs a closed mesh".
void require_closed(const Mesh& mesh, const std::string& file, const std::string& why);

}  // namespace malha
