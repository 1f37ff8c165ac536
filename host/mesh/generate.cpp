// SPDX-License-Identifier: Apache-2.0
#include "host/mesh/generate.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <unordered_map>

#include "host/mesh/io/mesh_io.h"
#include "host/mesh/tetrahedra.h"
#include "host/mesh/vectors.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {
namespace {

constexpr double most_points = 1 << 27;

void require_at_least_one(const char* shape, const char* what, int value) {
  if (value < 1) refuse(shape, what, std::to_string(value), "1 or more");
}

// The count is a double so that it cannot overflow.
void require_countable(const char* shape, double points) {
  if (points <= most_points) return;
  refuse(shape, "", shown(points) + " points", "at most " + std::to_string(static_cast<int>(most_points)));
}

// The i-th of n equal steps from `from` to `to`; both ends are exact.
double step(double from, double to, int i, int n) { return i == n ? to : from + (to - from) * (double(i) / n); }

Mesh make(const GridShape& grid) {
  const auto [nx, nz] = grid.cells;
  require_at_least_one("grid", "cells", std::min(nx, nz));
  require_countable("grid", (nx + 1.0) * (nz + 1.0));
  Mesh mesh;
  mesh.points.reserve((nx + std::size_t{1}) * (nz + std::size_t{1}));
  mesh.faces.reserve(static_cast<std::size_t>(nx) * nz);
  for (int j = 0; j <= nz; ++j) {
    for (int i = 0; i <= nx; ++i)
      mesh.points.push_back({step(0, grid.size[0], i, nx), 0, step(0, grid.size[1], j, nz)});
  }
  for (int j = 0; j < nz; ++j) {
    for (int i = 0; i < nx; ++i) {
      const int corner = i + j * (nx + 1), next_row = corner + nx + 1;
      mesh.faces.push_back({corner, next_row, next_row + 1, corner + 1});
    }
  }
  return mesh;
}

void to_unit_length(Vec3& point) {
  const double length = std::hypot(point[0], point[1], point[2]);
  for (double& value : point) value /= length;
}

Mesh icosahedron() {
  const double g = std::numbers::phi;
  Mesh mesh;
  mesh.points = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                 {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  const std::vector<Triangle> triangles{{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                        {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                        {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                        {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (const auto& [a, b, c] : triangles) mesh.faces.push_back({a, b, c, -1});
  for (Vec3& point : mesh.points) to_unit_length(point);
  return mesh;
}

// Divides every triangle into four; the two triangles at an edge share its midpoint.
Mesh subdivide(const Mesh& coarse) {
  Mesh fine;
  fine.points = coarse.points;
  fine.faces.reserve(4 * coarse.faces.size());
  std::unordered_map<std::uint64_t, int> midpoints;
  midpoints.reserve(2 * coarse.faces.size());
  const auto midpoint = [&](int a, int b) {
    const auto key = static_cast<std::uint64_t>(std::min(a, b)) << 32 | static_cast<std::uint64_t>(std::max(a, b));
    const auto [found, is_new] = midpoints.try_emplace(key, static_cast<int>(fine.points.size()));
    if (is_new) {
      const Vec3 &p = coarse.points[a], &q = coarse.points[b];
      fine.points.push_back({p[0] + q[0], p[1] + q[1], p[2] + q[2]});
      to_unit_length(fine.points.back());
    }
    return found->second;
  };
  for (const auto& [a, b, c, none] : coarse.faces) {
    const int ab = midpoint(a, b), bc = midpoint(b, c), ca = midpoint(c, a);
    fine.faces.push_back({a, ab, ca, none});
    fine.faces.push_back({b, bc, ab, none});
    fine.faces.push_back({c, ca, bc, none});
    fine.faces.push_back({ab, bc, ca, none});
  }
  return fine;
}

Mesh make(const SphereShape& sphere) {
  if (!sphere.subdivisions) refuse("sphere", "subdivisions", "none, which is an exact sphere", "a number, for a mesh");
  if (*sphere.subdivisions < 0) refuse("sphere", "subdivisions", std::to_string(*sphere.subdivisions), "0 or more");
  require_countable("sphere", 10 * std::pow(4.0, *sphere.subdivisions) + 2);
  Mesh mesh = icosahedron();
  for (int level = 0; level < *sphere.subdivisions; ++level) mesh = subdivide(mesh);
  for (Vec3& point : mesh.points) {
    for (double& value : point) value *= sphere.radius;
  }
  return mesh;
}

// The surface points of a lattice of cells, numbered x fastest, then y, then z.
class SurfaceLattice {
 public:
  explicit SurfaceLattice(const std::array<int, 3>& cells) : cells_(cells) {}

  int number(const std::array<int, 3>& at) const {
    const auto [nx, ny, nz] = cells_;
    const auto [i, j, k] = at;
    const int full = (nx + 1) * (ny + 1), ring = 2 * (nx + ny);  // points of an end layer, and of a layer in between
    if (k == 0) return i + j * (nx + 1);
    const int before = full + (k - 1) * ring;
    if (k == nz) return before + i + j * (nx + 1);
    if (j == 0) return before + i;
    if (j == ny) return before + (nx + 1) + 2 * (ny - 1) + i;
    return before + (nx + 1) + 2 * (j - 1) + (i == 0 ? 0 : 1);
  }

 private:
  std::array<int, 3> cells_;
};

Mesh box_between(const char* shape, const Vec3& low, const Vec3& high, const std::array<int, 3>& cells) {
  const auto [nx, ny, nz] = cells;
  require_at_least_one(shape, "cells", std::min({nx, ny, nz}));
  require_countable(shape, 2 * ((nx + 1.0) * (ny + 1.0) + (ny + 1.0) * (nz + 1.0) + (nz + 1.0) * (nx + 1.0)));
  const SurfaceLattice lattice(cells);
  Mesh mesh;
  for (int k = 0; k <= nz; ++k) {
    for (int j = 0; j <= ny; ++j) {
      const bool inner_row = k > 0 && k < nz && j > 0 && j < ny;
      for (int i = 0; i <= nx; i += inner_row ? nx : 1) {
        mesh.points.push_back(
            {step(low[0], high[0], i, nx), step(low[1], high[1], j, ny), step(low[2], high[2], k, nz)});
      }
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;  // the cross product of u and v points along axis
    for (const int layer : {0, cells[axis]}) {
      for (int b = 0; b < cells[v]; ++b) {
        for (int a = 0; a < cells[u]; ++a) {
          const auto corner = [&](int da, int db) {
            std::array<int, 3> at;
            at[axis] = layer, at[u] = a + da, at[v] = b + db;
            return lattice.number(at);
          };
          Quad face{corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)};
          if (layer == 0) std::swap(face[1], face[3]);
          mesh.faces.push_back(face);
        }
      }
    }
  }
  return mesh;
}

Mesh make(const BoxShape& box) {
  if (!box.cells) refuse("box", "cells", "none, which is an exact box", "numbers, for a mesh");
  const auto [x, y, z] = box.size;
  return box_between("box", {-x / 2, -y / 2, -z / 2}, {x / 2, y / 2, z / 2}, *box.cells);
}

Mesh make(const BarShape& bar) {
  require_at_least_one("bar", "cells", bar.cells);
  const double along = std::max(1.0, std::round(bar.length / bar.width * bar.cells));
  require_countable("bar", along * bar.cells);
  const double half = bar.width / 2;
  return box_between("bar", {0, -half, -half}, {bar.length, half, half},
                     {static_cast<int>(along), bar.cells, bar.cells});
}

// Each cell becomes four tetrahedra at alternate corners and one between them. Adjacent cells are mirrored, so that
// their triangles match.
Mesh make(const TetBoxShape& box) {
  const int nx = box.cells[0], ny = box.cells[1], nz = box.cells[2];  // no structured binding: lambdas capture them
  require_at_least_one("tet_box", "cells", std::min({nx, ny, nz}));
  require_countable("tet_box", (nx + 1.0) * (ny + 1.0) * (nz + 1.0));
  Mesh mesh;
  const auto along = [&](int axis, int i) { return step(-box.size[axis] / 2, box.size[axis] / 2, i, box.cells[axis]); };
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i) mesh.points.push_back({along(0, i), along(1, j), along(2, k)});
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) {
        // Bits 0, 1 and 2 of a corner are x, y and z; every second cell is mirrored along x.
        const auto corner = [&](int bits) {
          bits ^= (i + j + k) & 1;
          return (i + (bits & 1)) + (nx + 1) * ((j + (bits >> 1 & 1)) + (ny + 1) * (k + (bits >> 2)));
        };
        for (const auto& [a, b, c, d] :
             {Tetrahedron{0, 3, 5, 6}, {1, 0, 3, 5}, {2, 0, 3, 6}, {4, 0, 5, 6}, {7, 3, 5, 6}})
          mesh.tetrahedra.push_back({corner(a), corner(b), corner(c), corner(d)});
      }
  complete_tetrahedra(mesh, "tet_box");
  return mesh;
}

Mesh make(const ChainShape& chain) {
  require_at_least_one("chain", "segments", chain.segments);
  require_countable("chain", chain.segments + 1.0);
  Mesh mesh;
  for (int i = 0; i <= chain.segments; ++i) {
    Vec3& point = mesh.points.emplace_back();
    for (int axis = 0; axis < 3; ++axis) point[axis] = step(chain.from[axis], chain.to[axis], i, chain.segments);
    if (i > 0) mesh.lines.push_back({i - 1, i});
  }
  return mesh;
}

/// A closed surface of revolution about the line between two points: rings of points, each at a place along the line
/// (m, from its start) with a radius, between two points on the line.
Mesh revolve(const Vec3& from, const Vec3& to, double below, double above,
             const std::vector<std::array<double, 2>>& rings) {
  constexpr int around = 32;
  const auto unit = [](const Vec3& a) {
    const double length = norm(a);
    return Vec3{a[0] / length, a[1] / length, a[2] / length};
  };
  const Vec3 along = unit(minus(to, from));
  const Vec3 other = std::abs(along[0]) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 0, 1};
  const Vec3 u = unit(cross(along, other)),
             v = cross(u, along);  // so that faces are counter-clockwise seen from outside
  const auto at = [&](double place, double x, double y) {
    Vec3 point{};
    for (int k = 0; k < 3; ++k) point[k] = from[k] + place * along[k] + x * u[k] + y * v[k];
    return point;
  };
  Mesh mesh;
  mesh.points = {at(below, 0, 0), at(above, 0, 0)};
  for (const auto& [place, radius] : rings)
    for (int j = 0; j < around; ++j) {
      const double angle = 2 * std::numbers::pi * j / around;
      mesh.points.push_back(at(place, radius * std::cos(angle), radius * std::sin(angle)));
    }
  const auto number = [](std::size_t ring, int j) { return 2 + static_cast<int>(ring) * around + j % around; };
  for (int j = 0; j < around; ++j) {
    mesh.faces.push_back({0, number(0, j), number(0, j + 1), -1});
    for (std::size_t ring = 0; ring + 1 < rings.size(); ++ring)
      mesh.faces.push_back({number(ring, j + 1), number(ring, j), number(ring + 1, j), number(ring + 1, j + 1)});
    mesh.faces.push_back({1, number(rings.size() - 1, j + 1), number(rings.size() - 1, j), -1});
  }
  return mesh;
}

Mesh make(const CapsuleShape& capsule) {
  constexpr int rings = 8;  // of a half sphere
  const double length = norm(minus(capsule.to, capsule.from)), radius = capsule.radius;
  std::vector<std::array<double, 2>> all;
  for (int k = 1; k <= rings; ++k) {
    const double angle = std::numbers::pi / 2 * k / rings;
    all.push_back({-radius * std::cos(angle), radius * std::sin(angle)});
  }
  for (int k = rings - 1; k >= 0; --k) all.push_back({length - all[k][0], all[k][1]});
  return revolve(capsule.from, capsule.to, -radius, length + radius, all);
}

Mesh make(const CylinderShape& cylinder) {
  const double length = norm(minus(cylinder.to, cylinder.from));
  return revolve(cylinder.from, cylinder.to, 0, length, {{0, cylinder.radius}, {length, cylinder.radius}});
}

Mesh make(const PlaneShape&) { return {{{-1, 0, -1}, {-1, 0, 1}, {1, 0, 1}, {1, 0, -1}}, {{0, 1, 2, 3}}, {}, {}}; }

Mesh make(const LatticeShape& lattice) {
  const auto [nx, ny, nz] = lattice.count;
  require_at_least_one("lattice", "count", std::min({nx, ny, nz}));
  require_countable("lattice", double(nx) * ny * nz);
  const auto along = [&](int axis, int i) {
    const double low = lattice.min[axis], high = lattice.max[axis];
    return lattice.count[axis] == 1 ? (low + high) / 2 : step(low, high, i, lattice.count[axis] - 1);
  };
  Mesh mesh;
  for (int k = 0; k < nz; ++k) {
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) mesh.points.push_back({along(0, i), along(1, j), along(2, k)});
    }
  }
  return mesh;
}

/// Refuses corners that are not points. The fourth corner may also be `missing`.
template <class Item>
void require_points(const char* what, const std::vector<Item>& items, int points, int missing) {
  for (std::size_t i = 0; i < items.size(); ++i)
    for (std::size_t k = 0; k < items[i].size(); ++k) {
      const int corner = items[i][k];
      if ((corner < 0 || corner >= points) && !(k == 3 && corner == missing))
        refuse("mesh_data", what + ("/" + std::to_string(i)), "vertex " + std::to_string(corner),
               "0 to " + std::to_string(points - 1));
    }
}

Mesh make(const MeshDataShape& data) {
  require_countable("mesh_data", static_cast<double>(data.points.size()));
  constexpr int triangle = -1, none = 0;
  const int points = static_cast<int>(data.points.size());
  require_points("faces", data.faces, points, triangle), require_points("lines", data.lines, points, none);
  require_points("tetrahedra", data.tetrahedra, points, none);
  Mesh mesh{data.points, data.faces, data.lines, data.tetrahedra};
  complete_tetrahedra(mesh, "mesh_data");
  return mesh;
}

Mesh make(const MeshFile& file) { refuse(file.path, "", "a mesh file", "a generated shape"); }

}  // namespace

Mesh generate(const Shape& shape) {
  return std::visit([](const auto& given) { return make(given); }, shape);
}

Mesh make_mesh(const Shape& shape) {
  const auto* file = std::get_if<MeshFile>(&shape);
  return file != nullptr ? read_mesh(file->path, file->part) : generate(shape);
}

void apply(const Transform& transform, Mesh& mesh) {
  const auto vector = [](const Vec3& v) { return Eigen::Vector3d(v[0], v[1], v[2]); };
  const double radians = transform.degrees * (std::numbers::pi / 180);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(radians, vector(transform.axis).normalized()).toRotationMatrix();
  const Eigen::Matrix3d turn_and_scale = turn * vector(transform.scale).asDiagonal();
  for (auto* points : {&mesh.points, &mesh.vertices.position})
    for (Vec3& point : *points) {
      const Eigen::Vector3d moved = vector(transform.translate) + turn_and_scale * vector(point);
      point = {moved[0], moved[1], moved[2]};
    }
}

}  // namespace malha
