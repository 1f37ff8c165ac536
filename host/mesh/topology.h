// SPDX-License-Identifier: Apache-2.0
// What a mesh's connections say: edges, hinges, connected parts, volume, and how mass is shared.
// Everything here is deterministic, follows the order of the faces, and takes (nearly) linear time.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "malha/mesh.h"

namespace malha {

/// Every side of a face, every line and every edge of a tetrahedron once, lower point first, in order of first
/// appearance: faces, lines, tetrahedra.
std::vector<Edge> edges(const Mesh& mesh);

/// Both diagonals of every quad: 0-2, then 1-3.
std::vector<Edge> shear(const Mesh& mesh);

/// The faces as triangles: a quad becomes (0, 1, 2) and (0, 2, 3).
std::vector<Triangle> triangles(const Mesh& mesh);

/// Of each side of each triangle (3 t + k, from its corner k to the next), the side of the other triangle at that edge;
/// -1 at edges with one triangle or with more than two. `crowded`, where given, grows by the number of the latter.
std::vector<int> opposite_sides(std::size_t points, const std::vector<Triangle>& triangles, int* non_manifold = nullptr);

/// {a, b, c, d} for every edge a-b that a triangle (a, b, c) of triangles(mesh) shares with one other, of corners a, b,
/// d, quads' diagonals included, in order of first appearance. How the two are wound does not matter: the second is
/// taken as (b, a, d). Edges with one triangle or with more than two are left out; `crowded` as above.
std::vector<std::array<int, 4>> hinges(const Mesh& mesh, int* non_manifold = nullptr);

/// Which connected part each particle belongs to. Parts are numbered from 0 in the order of their lowest particles;
/// `count` becomes their number.
std::vector<int> components(int particles, const std::vector<Edge>& edges, int& count);

/// The volume (m^3) that a closed mesh encloses; negative where the faces point inwards.
double signed_volume(const std::vector<Vec3>& points, const std::vector<Triangle>& triangles);

/// The mass (kg) of each point for `density` in kg/m^2 of faces and kg/m of lines: a triangle gives a third of its mass
/// to each corner, a quad the mean of its two splits, a line half to each end. A point of no face or line gets 0.
/// In a mesh with tetrahedra `density` is in kg/m^3, and each gives a quarter of its mass to each corner; faces have
/// none.
std::vector<double> masses_by_density(const Mesh& mesh, double density);

/// The same proportions scaled to `mass` (kg) in all. A point of no face or line gets an equal share, mass / points.
std::vector<double> masses_by_total(const Mesh& mesh, double mass);

/// Refuses a mesh that is not a closed surface seen from outside: an edge with one face (open) or with more than two,
/// neighbours oriented against each other, an enclosed volume that is not positive (inside out).
/// `why` says what needs it: "pressure needs a closed mesh".
void require_closed(const Mesh& mesh, const std::string& file, const std::string& why);

}  // namespace malha
