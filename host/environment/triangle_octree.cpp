// SPDX-License-Identifier: Apache-2.0
#include "host/environment/triangle_octree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory_resource>
#include <new>

namespace malha {

namespace {

constexpr std::size_t kCompared = 6;          // candidates that are compared with all others
constexpr std::size_t kCellMemory = 1 << 16;  // bytes on the stack, for some 450 triangles
constexpr std::size_t kLongestMemory = std::size_t{1} << 24;
constexpr std::size_t kUsualList = 256;
constexpr int kFinestGrid = 7;        // depth: 16 MiB of virtual memory, allocated page by page on first use
constexpr double kSideInEdges = 2.5;  // side of the grid's cells, in mean edge lengths
constexpr double kLoose = 0.9;        // of the distance of a grid cell's centre: Embree then visits few triangles

using S = Lane<double>;
constexpr int kWide = kLanes<double>;
using Corners = std::array<double, 8>;  // a value for each corner of a cell

bool is_behind(const Corners& least, const Corners& most) {
  bool all_behind = true;
  for (int j = 0; j < 8; ++j) all_behind &= least[j] > most[j];
  return all_behind;
}

}  // namespace

struct TriangleOctree::Cube {
  Vector3<double> centre;
  double half;  // half of the side, m

  Cube part(int which) const {
    const double h = half / 2;
    return {centre + Vector3<double>{which & 1 ? h : -h, which & 2 ? h : -h, which & 4 ? h : -h}, h};
  }
  double radius() const { return std::sqrt(3.0) * half; }

  /// Distances of a triangle from the corners of the cube.
  Corners distances(const OctreeView& mesh, int triangle) const {
    const int* t = mesh.triangles[triangle];
    const auto all = [](const Vec4<double>& a) { return Vector3<S>{S(a.x), S(a.y), S(a.z)}; };
    const Vector3<S> a = all(mesh.corners[t[0]]), b = all(mesh.corners[t[1]]), c = all(mesh.corners[t[2]]);
    Corners x, y, z, out;
    for (int j = 0; j < 8; ++j) {
      x[j] = centre.x + (j & 1 ? half : -half);
      y[j] = centre.y + (j & 2 ? half : -half);
      z[j] = centre.z + (j & 4 ? half : -half);
    }
    for (int k = 0; k < 8; k += kWide) {
      Vector3<S> p;
      load(x.data() + k, p.x), load(y.data() + k, p.y), load(z.data() + k, p.z);
      const Vector3<S> d = p - nearest_point(p, a, b, c).q;
      store(sqrt(dot(d, d)), out.data() + k);
    }
    return out;
  }
};

/// A candidate triangle, with lower bounds for the comparison of its distances at the corners of the cell; as distances
/// are convex, the corners decide for all points of the cell.
struct TriangleOctree::Candidate {
  int triangle;
  double distance;  // m, from the centre of the cell
  Corners least;
  bool removed = false;
};

TriangleOctree::TriangleOctree(const TriangleScene& scene, ReadableVector<Vec4<double>>& corners,
                               const ReadableVector<std::array<int, 3>>& triangles, const Vector3<double>& half,
                               double skin)
    : scene_(scene), skin_(skin), cells_(nullptr, nullptr), lists_(nullptr, nullptr) {
  const double size = norm(half);
  rounding_ = 1e-11 * size;
  mesh_.corners = corners.data(), mesh_.triangles = reinterpret_cast<const int(*)[3]>(triangles.data());
  mesh_.half = 1.2 * std::max({half.x, half.y, half.z});
  mesh_.per_cell = (1 << kMaxDepth) / (2 * mesh_.half);
  double edges = 0;
  for (const auto& t : triangles) {
    const Vector3<double> a = corners[t[0]].xyz(), ab = corners[t[1]].xyz() - a, ac = corners[t[2]].xyz() - a;
    const double longest = std::max({norm(ab), norm(ac), norm(ab - ac)}), twice_area = norm(cross(ab, ac));
    edges += longest;
    // In a projection onto a face, rounding is amplified by the ratio of the distance to the height of the face.
    const double enlarged = size * longest / twice_area;
    error_.push_back(16 * longest * std::numeric_limits<double>::epsilon() * enlarged * enlarged);
    if (!(error_.back() >= 0)) error_.back() = INFINITY;
  }
  const auto count = static_cast<long>(triangles.size());
  mesh_.leaf = count <= kSmallMesh ? kShortList : kLeafList;
  const double side = kSideInEdges * edges / static_cast<double>(count);
  while (count > kMaxListLength && mesh_.start < kFinestGrid && 2 * mesh_.half > side * (1 << mesh_.start))
    ++mesh_.start;
  mesh_.side = 2 * mesh_.half / (1 << mesh_.start);
  max_cells_ = static_cast<int>(std::min(4096 + count, 1L << 28));
  max_listed_ = static_cast<int>(std::min(65536 + 32 * count, 1L << 30));
  cells_ = readable_array<OctreeNode>(max_cells_, false);
  lists_ = readable_array<int>(max_listed_, false);
  mesh_.cells = cells_.get(), mesh_.lists = lists_.get();
  clear();
}

void TriangleOctree::clear() {
  grid_ = readable_array<GridCell>(std::size_t{1} << 3 * mesh_.start, true, memory_);
  mesh_.grid = grid_.get();
  cells_used_ = 1, listed_ = 0, full_ = false;
}

bool TriangleOctree::reset_if_full() {
  if (!full_) return false;
  clear();
  return true;
}

void TriangleOctree::measure(const OctreeKey& path) {
  GridCell& cell = grid_[grid_index(mesh_, path)];
  float known;
  __atomic_load(&cell.distance, &known, __ATOMIC_RELAXED);
  if (known > 0) return;
  const Vector3<double> p = grid_cell_centre(mesh_, path);
  double nearest = 8 * mesh_.half;
  const double slack = skin_ + 1e-6 * norm(p);
  point_query(scene_, {float(p.x), float(p.y), float(p.z)}, float(nearest + slack), [&](int t) {
    nearest = std::min(nearest, distance(p, t) - error_[t]);
    return static_cast<float>(std::max(kLoose * nearest, 0.0) + slack);
  });
  float below = std::max(static_cast<float>(kLoose * nearest * (1 - 1e-6) - rounding_), 1e-30f);
  __atomic_store(&cell.distance, &below, __ATOMIC_RELAXED);
}

bool TriangleOctree::make(const OctreeKey& path) try {
  if (full_) return false;
  Cube cube{grid_cell_centre(mesh_, path), mesh_.side / 2};
  int* link = &grid_[grid_index(mesh_, path)].cell;
  for (int parent = 0;;) {
    int at = published(*link);
    if (at == 0) {
      const int made = make(parent, cube, path);
      if (made == 0) return false;
      // Another thread may have made the same cell meanwhile: both have the same list, and one is used.
      if (__atomic_compare_exchange_n(link, &at, made, false, __ATOMIC_ACQ_REL, __ATOMIC_ACQUIRE)) at = made;
    }
    OctreeNode& cell = cells_[at];
    if (is_leaf(mesh_, cell)) return cell.count <= kMaxListLength;
    const int part = path.child_index(cell.depth);
    cube = cube.part(part), link = &cell.child[part], parent = at;
  }
} catch (const std::bad_alloc&) {
  return false;  // no list: the whole mesh is queried; no exception may leave a thread
}

double TriangleOctree::distance(const Vector3<double>& p, int triangle) const {
  const int* c = mesh_.triangles[triangle];
  const auto at = [&](int k) { return mesh_.corners[c[k]].xyz(); };
  return norm(p - nearest_on_triangle(p, at(0), at(1), at(2)).q);
}

/// All triangles that may be closest to a point of the cube: no farther from its centre than the closest one plus twice
/// the distance to a corner.
std::pmr::vector<int> TriangleOctree::candidates_for(const Cube& cube, std::pmr::memory_resource& memory) const {
  const Vector3<double>& p = cube.centre;
  std::pmr::vector<std::pair<double, int>> found_triangles(&memory);
  found_triangles.reserve(kUsualList);
  double nearest = 8 * mesh_.half;
  const double more = 2 * cube.radius() + rounding_, slack = skin_ + 1e-6 * norm(p);
  point_query(scene_, {float(p.x), float(p.y), float(p.z)}, float(nearest + more + slack), [&](int t) {
    const double least = distance(p, t) - error_[t];
    nearest = std::min(nearest, least + 2 * error_[t]);
    if (!(least > nearest + more)) found_triangles.push_back({least, t});
    return static_cast<float>(nearest + more + slack);
  });
  std::pmr::vector<int> triangles(&memory);
  triangles.reserve(found_triangles.size());
  for (const auto& [least, t] : found_triangles)
    if (!(least > nearest + more)) triangles.push_back(t);
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

/// Removes every triangle to which some other one is nearer at all points of the cell. The distance of the other one is
/// bounded from above by its values at the corners, as it is convex; that of the removed one from below by its tangent
/// at the centre: so a comparison at the corners decides.
int TriangleOctree::make(int parent, const Cube& cube, const OctreeKey& path) {
  const int depth = parent == 0 ? mesh_.start : cells_[parent].depth + 1;
  // Cells are made during steps, which allocate nothing: longer lists use memory that each thread keeps.
  std::array<std::byte, kCellMemory> bytes;
  thread_local std::pmr::unsynchronized_pool_resource longer({0, kLongestMemory});  // keeps what it has allocated
  std::pmr::monotonic_buffer_resource memory(bytes.data(), bytes.size(), &longer);
  std::pmr::vector<int> own(&memory);
  const bool is_split = depth > mesh_.start;
  if (!is_split) own = candidates_for(cube, memory);
  const int* const list = is_split ? lists_.get() + cells_[parent].first : own.data();
  const int count = is_split ? cells_[parent].count : static_cast<int>(own.size());
  if (count == 0) return 0;

  struct Found {
    double distance;
    Vector3<double> d;
  };
  std::pmr::vector<Found> found(count + kWide, Found{}, &memory);
  const Vector3<S> p{S(cube.centre.x), S(cube.centre.y), S(cube.centre.z)};
  for (int k = 0; k < count; k += kWide) {
    const Vector3<S> d = p - closest_points_on(mesh_, p, list + k, count - k).q;
    const S distance = sqrt(dot(d, d));
    for (int l = 0; l < kWide; ++l) found[k + l] = {lane(distance, l), {lane(d.x, l), lane(d.y, l), lane(d.z, l)}};
  }
  const auto margin = [&](int triangle) { return rounding_ + 16 * error_[triangle]; };
  int nearest = 0;
  for (int k = 0; k < count; ++k)
    if (found[k].distance + margin(list[k]) < found[nearest].distance + margin(list[nearest])) nearest = k;
  const auto most_of = [&](int triangle) {
    Corners most = cube.distances(mesh_, triangle);
    for (double& at : most) at += margin(triangle);
    return most;
  };
  const Corners of_nearest = most_of(list[nearest]);
  const double farthest = *std::max_element(of_nearest.begin(), of_nearest.end());
  std::pmr::vector<Candidate> all(&memory);
  all.reserve(static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k) {
    const double least = found[k].distance - margin(list[k]);
    if (least - cube.radius() > farthest) continue;
    Candidate candidate{list[k], found[k].distance, {}};
    if (found[k].distance > cube.half / 8) {  // nearer the slope is not reliable
      const Vector3<double> slope = found[k].d * (cube.half / found[k].distance);
      for (int j = 0; j < 8; ++j)
        candidate.least[j] =
            least + (j & 1 ? slope.x : -slope.x) + (j & 2 ? slope.y : -slope.y) + (j & 4 ? slope.z : -slope.z);
      if (k != nearest && is_behind(candidate.least, of_nearest)) continue;
    }
    all.push_back(candidate);
  }
  // The candidates nearest to the centre remove most of the triangles that can be removed.
  const auto compared = std::min(all.size(), kCompared);
  std::partial_sort(all.begin(), all.begin() + compared, all.end(),
                    [](const Candidate& t, const Candidate& u) { return t.distance < u.distance; });
  for (std::size_t u = 0; u < compared; ++u) {
    if (all[u].removed || all[u].triangle == list[nearest]) continue;
    const Corners most = most_of(all[u].triangle);
    for (std::size_t t = 0; t < all.size(); ++t) all[t].removed |= t != u && is_behind(all[t].least, most);
  }
  all.resize(std::remove_if(all.begin(), all.end(), [](const Candidate& t) { return t.removed; }) - all.begin());
  std::sort(all.begin(), all.end(), [](const Candidate& t, const Candidate& u) { return t.triangle < u.triangle; });
  const bool hardly_shorter = is_split && 4 * all.size() > 3 * static_cast<std::size_t>(count);
  const long listed = static_cast<long>(all.size()), first = listed_.fetch_add(listed);
  if (first + listed > max_listed_) {
    full_ = true;
    return 0;
  }
  double error = 0;
  for (int k = 0; k < listed; ++k) {
    lists_[first + k] = all[k].triangle;
    error = std::max(error, margin(all[k].triangle));
  }
  const int bits = kMaxDepth - depth;
  return add({{},
              int(first),
              int(listed),
              depth,
              hardly_shorter ? cells_[parent].failed_splits + 1 : 0,
              path.x >> bits,
              path.y >> bits,
              path.z >> bits,
              1.001f * static_cast<float>(error)});
}

int TriangleOctree::add(const OctreeNode& cell) {
  const int number = cells_used_.fetch_add(1);
  if (number >= max_cells_) {
    full_ = true;
    return 0;
  }
  cells_[number] = cell;
  return number;
}

std::size_t TriangleOctree::bytes() const {
  return std::min<std::size_t>(cells_used_, max_cells_) * sizeof(OctreeNode) +
         std::min<std::size_t>(listed_, max_listed_) * sizeof(int) + (sizeof(GridCell) << 3 * mesh_.start) +
         error_.size() * sizeof(double);
}

}  // namespace malha
