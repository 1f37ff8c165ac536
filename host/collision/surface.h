// A triangle mesh to collide with, in its own frame: closest point with its sign, and segment crossings. Embree finds
// the candidates in float; the arithmetic on what it finds is in double.
#pragma once
#include <array>
#include <atomic>
#include <memory>
#include <vector>

#include "host/collision/embree.h"
#include "host/collision/near_cells.h"
#include "host/mesh.h"
#include "kernels/near_feature.h"

namespace malha {

using Point = Vector3<double>;

struct ClosestPoint {
  bool found = false;
  int triangle = -1;
  double distance = 0;    // m, >= 0
  Point q{};              // on the surface
  Point normal{};         // unit angle-weighted pseudonormal of the closest face, edge or corner
  bool boundary = false;  // on an edge or corner at the rim of an open mesh
};

struct Crossing {
  bool hit = false;
  Point q{};
  Point normal{};  // unit, of the face
};

class Surface {
 public:
  /// `mesh` has faces. Normals: Baerentzen, Aanaes 2005 ("Signed distance computation using the angle weighted
  /// pseudonormal"): by the closest feature they tell inside from outside without error, face normals do not.
  Surface(const Device& device, const Mesh& mesh);

  /// The nearest surface point within `radius` of a (both in the mesh's frame, m). A triangle that is known to be near
  /// makes the search short and changes nothing else.
  ClosestPoint closest(const Point& a, double radius, int known_near = -1) const;

  /// By the mesh's cells (kernels/near_cells.h): the one that answers for a, kept in `cell` from one look to the next;
  /// 0: none does.
  HOST_KERNEL int cell_of(const Point& a, int cell) const {
    const NearMesh& mesh = cells_->mesh();
    const CellPath path = path_to(mesh, a - centre_);
    if (!path.inside) return 0;
    if (cell > 0 && holds(mesh.cells[cell], path)) return cell;
    const int found = last_cell_at(mesh, path);
    return found > 0 && mesh.cells[found].count <= kMostListed ? found : 0;
  }
  /// Ask for what comes next ahead of its use.
  HOST_KERNEL void prefetch_cell(int cell) const { prefetch(cells_->mesh().cells + cell); }
  HOST_KERNEL void prefetch_normal(const NearTriangle& near) const {
    if (near.triangle >= 0 && near.where.corner < 0)
      prefetch(near.where.edge < 0 ? &face_normals_[near.triangle] : &edge_normals_[near.triangle][near.where.edge]);
  }
  /// Makes the cell of a where that is worth it, from any thread; 0: none is made.
  int make_cell(const Point& a) const {
    const CellPath path = path_to(cells_->mesh(), a - centre_);
    return path.inside && cells_->make(path) ? last_cell_at(cells_->mesh(), path) : 0;
  }
  /// The nearest triangle to a by a cell of it, compiled for an instruction set.
  template <class Isa>
  HOST_KERNEL NearTriangle nearest(const Point& a, int cell) const {
    return nearest_listed<Isa>(cells_->mesh(), cells_->mesh().cells[cell], a - centre_);
  }
  HOST_KERNEL const NearMesh& near_mesh() const { return cells_->mesh(); }
  HOST_KERNEL Point in_near_mesh(const Point& a) const { return a - centre_; }
  /// What closest finds of a, by its nearest triangle.
  HOST_KERNEL ClosestPoint within(double radius, const NearTriangle& near, const Point& a) const {
    if (!(near.distance < radius) || near.triangle < 0) return {};
    return of_feature(feature(near), a);
  }

  /// What is nearest on it. On faces of needles, whose normals are rounded too much, it is the point that was found.
  HOST_KERNEL NearFeature feature(const NearTriangle& near) const {
    const Triangle& c = triangles_[near.triangle];
    const int corner = near.where.corner, edge = near.where.edge;
    NearFeature f;
    f.triangle = near.triangle, f.o = near.where.q;
    if (corner >= 0) {
      f.kind = NearFeature::Corner, f.normal = corner_normals_[c[corner]], f.boundary = rim_corners_[c[corner]] != 0;
    } else if (edge >= 0) {  // either of its triangles tells the same
      const int a = c[edge], b = c[(edge + 1) % 3], first = a < b ? a : b;
      const Point way = point(a < b ? b : a) - point(first);
      const double l = root(dot(way, way));
      if (l > 1e-150) f.kind = NearFeature::Edge, f.o = point(first), f.d = way * (1 / l);  // shorter: squares are 0
      f.normal = edge_normals_[near.triangle][edge], f.boundary = rim_edges_[near.triangle][edge];
    } else {
      f.normal = face_normals_[near.triangle];
      if (!needles_[near.triangle]) f.kind = NearFeature::Face, f.o = point(c[0]), f.d = f.normal;
    }
    return f;
  }
  /// The same of every point whose nearest feature it is.
  HOST_KERNEL ClosestPoint of_feature(const NearFeature& f, const Point& a) const {
    const Point p = a - centre_, q = f.nearest(p), d = p - q;
    return {true, f.triangle, root(dot(d, d)), q + centre_, f.normal, f.boundary};
  }

  /// A lower bound of the distance of a: of a grid over the mesh's box, below 0 where that says nothing.
  double least_distance(const Point& a) const {
    const Point p = a - centre_;
    const CellPath path = path_to(cells_->mesh(), p);
    if (!path.inside) return -1;
    const double known = malha::least_distance(cells_->mesh(), path, p);
    if (known >= 0 || !cells_->measure(path)) return known;
    return malha::least_distance(cells_->mesh(), path, p);
  }
  bool tidy() { return cells_->tidy(); }

  /// The first crossing on the way from a to b and `beyond` metres further. With front_only, crossings from behind a
  /// face do not count and do not hide what lies behind them. What passes a rim by less than a skin may count.
  Crossing crossing(const Point& a, const Point& b, double beyond, bool front_only) const;

  /// A lower bound of the distance of a: that of the bounding box; 0 inside it.
  double box_distance(const Point& a) const;
  double diagonal() const;
  int triangles() const { return static_cast<int>(triangles_.size()); }
  std::size_t bytes() const;
  std::size_t cell_bytes() const { return cells_->bytes(); }
  /// How often the whole mesh was asked since the start.
  long long queries() const { return queries_->load(); }

 private:
  /// The first crossing from `start` (relative to centre_) over `far` metres. The ray starts a skin earlier, since rays
  /// that start on a surface miss it half the time.
  Crossing along(const Point& start, const Point& direction, double far, bool front_only) const;

  HOST_KERNEL Point point(int i) const { return points_[i].xyz(); }
  std::vector<Vec4<double>> points_;  // relative to centre_, so that float is fine wherever the mesh lies
  std::vector<Triangle> triangles_;
  std::vector<Point> face_normals_, corner_normals_;  // unit
  std::vector<std::array<Point, 3>> edge_normals_;    // unit; edge k joins corners k and k + 1
  std::vector<std::array<bool, 3>> rim_edges_;
  std::vector<unsigned char> rim_corners_, needles_;
  Point centre_{}, half_{};
  double skin_ = 0;
  std::unique_ptr<TriangleScene> scene_;
  std::unique_ptr<NearCells> cells_;
  std::unique_ptr<std::atomic<long long>> queries_ = std::make_unique<std::atomic<long long>>(0);
};

}  // namespace malha
