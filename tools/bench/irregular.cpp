// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/irregular.h"

#include <cstdint>
#include <utility>

namespace malha::bench {

namespace {

/// SplitMix64 (Steele, Lea, Flood 2014). It uses integers only, so that every platform draws the same numbers.
class Random {
 public:
  std::uint64_t operator()() {
    std::uint64_t z = state_ += 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
  }
  int below(int n) { return static_cast<int>((*this)() % static_cast<std::uint64_t>(n)); }
  /// A uniform number in [-1, 1).
  double sign() { return static_cast<double>((*this)() >> 11) * 0x1p-52 - 1; }

 private:
  std::uint64_t state_ = 2019;
};

template <class T>
void shuffle(std::vector<T>& list, Random& random) {
  for (int i = static_cast<int>(list.size()) - 1; i > 0; --i) std::swap(list[i], list[random.below(i + 1)]);
}

/// A half-edge mesh: half-edge 3 t + k leads from corner k of triangle t to the next corner.
class Sheet {
 public:
  Sheet(int side, double size) : side_(side), cell_(size / (side - 1)), size_(size) {
    place_points();
    make_triangles();
    for (int attempts = 3 * static_cast<int>(corner_.size()); attempts > 0; --attempts)
      flip(random_.below(static_cast<int>(corner_.size())));
  }

  Mesh shuffled() {
    const int n = side_ * side_;
    std::vector<int> place(n);
    for (int i = 0; i < n; ++i) place[i] = i;
    shuffle(place, random_);
    Mesh mesh;
    mesh.points.resize(n);
    for (int i = 0; i < n; ++i) mesh.points[place[i]] = points_[i];
    for (std::size_t h = 0; h < corner_.size(); h += 3)
      mesh.faces.push_back({place[corner_[h]], place[corner_[h + 1]], place[corner_[h + 2]], -1});
    shuffle(mesh.faces, random_);
    return mesh;
  }

 private:
  bool on_border(int i) const {
    const int x = i % side_, z = i / side_;
    return x == 0 || z == 0 || x == side_ - 1 || z == side_ - 1;
  }

  void place_points() {
    constexpr double jitter = 0.2;  // in cells; below 0.25 no triangle can be inverted
    for (int z = 0; z < side_; ++z)
      for (int x = 0; x < side_; ++x) points_.push_back({place(x, jitter), 0, place(z, jitter)});
  }

  /// The coordinate of line i of the lattice; the border stays straight.
  double place(int i, double jitter) {
    const double shift = jitter * random_.sign();
    if (i == 0) return 0;
    return i == side_ - 1 ? size_ : (i + shift) * cell_;
  }

  void make_triangles() {
    valence_.assign(points_.size(), 0);
    for (int z = 0; z + 1 < side_; ++z)
      for (int x = 0; x + 1 < side_; ++x) {
        const int a = z * side_ + x, b = a + 1, c = a + side_, d = c + 1;
        const bool rising = random_() & 1;
        for (int corner : rising ? std::array{a, c, b, b, c, d} : std::array{a, c, d, a, d, b})
          corner_.push_back(corner);
      }
    link();
  }

  /// Finds the twin of every half-edge: -1 on the border.
  void link() {
    twin_.assign(corner_.size(), -1);
    std::vector<std::vector<int>> leaving(points_.size());
    for (int h = 0; h < static_cast<int>(corner_.size()); ++h) leaving[corner_[h]].push_back(h);
    for (int h = 0; h < static_cast<int>(corner_.size()); ++h) {
      for (const int g : leaving[end(h)])
        if (end(g) == corner_[h]) twin_[h] = g;
      ++valence_[corner_[h]];
      if (twin_[h] < 0) ++valence_[end(h)];  // no half-edge leaves the end for the start
    }
  }

  static int next(int h) { return h % 3 == 2 ? h - 2 : h + 1; }
  int end(int h) const { return corner_[next(h)]; }

  bool well_shaped(int a, int b, int c) const {
    const auto [ax, ay, az] = points_[a];
    const auto [bx, by, bz] = points_[b];
    const auto [cx, cy, cz] = points_[c];
    const auto squared = [](double u, double v) { return u * u + v * v; };
    const double twice_area = (bz - az) * (cx - ax) - (bx - ax) * (cz - az);
    const double squares = squared(bx - ax, bz - az) + squared(cx - bx, cz - bz) + squared(ax - cx, az - cz);
    // 2 sqrt(3) twice_area / squares is 1 for the equilateral triangle and 0.87 for half a square.
    return 3.4641016151377544 * twice_area > 0.5 * squares;
  }

  /// Flips the edge to the other diagonal of its two triangles, if triangles and valences stay good.
  void flip(int h) {
    const int g = twin_[h];
    if (g < 0) return;
    const int hn = next(h), hp = next(hn), gn = next(g), gp = next(gn);
    const int a = corner_[h], b = corner_[g], c = corner_[hp], d = corner_[gp];
    if (valence_[a] <= (on_border(a) ? 3 : 4) || valence_[b] <= (on_border(b) ? 3 : 4)) return;
    if (valence_[c] >= 9 || valence_[d] >= 9) return;
    if (!well_shaped(c, a, d) || !well_shaped(d, b, c)) return;
    --valence_[a], --valence_[b], ++valence_[c], ++valence_[d];
    const int outer[4] = {twin_[hp], twin_[gn], twin_[gp], twin_[hn]};  // of c-a, a-d, d-b, b-c
    const int s = h / 3 * 3, t = g / 3 * 3;
    corner_[s] = c, corner_[s + 1] = a, corner_[s + 2] = d;
    corner_[t] = d, corner_[t + 1] = b, corner_[t + 2] = c;
    join(s, outer[0]), join(s + 1, outer[1]), join(t, outer[2]), join(t + 1, outer[3]);
    join(s + 2, t + 2);
  }

  void join(int h, int g) {
    twin_[h] = g;
    if (g >= 0) twin_[g] = h;
  }

  int side_;
  double cell_, size_;
  Random random_;
  std::vector<Vec3> points_;
  std::vector<int> corner_, twin_;  // per half-edge: the point where it starts, and the opposite half-edge
  std::vector<int> valence_;        // number of edges of each point
};

}  // namespace

Mesh irregular_sheet(int side, double size) { return Sheet(side, size).shuffled(); }

}  // namespace malha::bench
