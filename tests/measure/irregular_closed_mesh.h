// SPDX-License-Identifier: Apache-2.0
// Generator of irregular closed meshes, which resemble scans: jittered points, collapsed and flipped edges, slivers.
#pragma once
#include <algorithm>
#include <cmath>
#include <iterator>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "host/mesh/generate.h"
#include "malha/scene.h"

namespace malha {

/// A closed mesh that is made irregular step by step. It stays closed, oriented, and without doubled edges.
class IrregularClosedMesh {
 public:
  /// A mesh of about 1 m: a sphere of 10 * 4^subdivisions + 2 points, which depending on the seed is stretched and
  /// bumpy, jittered by up to 0.4 edges, with half of its points removed, with flipped edges and with slivers of 1:50.
  /// The same with every standard library.
  explicit IrregularClosedMesh(int seed, int subdivisions) : random_(static_cast<unsigned>(seed)) {
    const Mesh sphere = make_mesh(SphereShape{0.5, subdivisions});
    points_ = sphere.points;
    for (const Quad& face : sphere.faces) faces_.push_back({face[0], face[1], face[2]});
    bump();
    jitter(seed % 5 * 0.1 * 0.55 / std::pow(2, subdivisions));
    if (seed % 2 == 1) decimate();
    if (seed % 3 != 0) flip();
    if (seed % 4 != 0) add_slivers(0.1 * (seed % 4));
  }

  const std::vector<Triangle>& faces() const { return faces_; }
  double lowest() const {  // m
    double y = points_[0][1];
    for (const Vec3& p : points_) y = std::min(y, p[1]);
    return y;
  }
  std::string off() const {
    std::ostringstream text;
    text.precision(17);
    text << "OFF\n" << points_.size() << " " << faces_.size() << " 0\n";
    for (const Vec3& p : points_) text << p[0] << " " << p[1] << " " << p[2] << "\n";
    for (const Triangle& t : faces_) text << "3 " << t[0] << " " << t[1] << " " << t[2] << "\n";
    return text.str();
  }

 private:
  double unit() { return 2 * (double(random_()) / 4294967296.0) - 1; }  // in [-1, 1)
  int any(std::size_t count) { return static_cast<int>(random_() % count); }

  void bump() {
    double size[3], wave[6];
    for (double& a : size) a = 1 + 0.5 * unit();
    for (double& a : wave) a = unit();
    for (Vec3& p : points_) {
      const double r =
          1 + 0.25 * (wave[0] * std::sin(9 * p[0] + 6 * wave[1]) + wave[2] * std::sin(8 * p[1] + 6 * wave[3]) +
                      wave[4] * std::sin(10 * p[2] + 6 * wave[5]));
      for (int k = 0; k < 3; ++k) p[k] *= r * size[k];
    }
  }
  void jitter(double by) {
    for (Vec3& p : points_)
      for (double& a : p) a += by * unit();
  }

  std::vector<std::set<int>> neighbours() const {
    std::vector<std::set<int>> of(points_.size());
    for (const Triangle& t : faces_)
      for (int k = 0; k < 3; ++k) of[t[k]].insert(t[(k + 1) % 3]), of[t[(k + 1) % 3]].insert(t[k]);
    return of;
  }

  /// Tries to collapse as many edges as half of the points, where the surface stays closed.
  void decimate() {
    for (std::size_t left = points_.size() / 2; left > 0; --left) {
      const auto near = neighbours();
      const Triangle& t = faces_[any(faces_.size())];
      const int k = any(3), a = t[k], b = t[(k + 1) % 3];
      std::vector<int> both;
      std::set_intersection(near[a].begin(), near[a].end(), near[b].begin(), near[b].end(), std::back_inserter(both));
      if (both.size() != 2 || near[a].size() + near[b].size() > 14) continue;
      if (near[both[0]].size() <= 4 || near[both[1]].size() <= 4) continue;
      for (int axis = 0; axis < 3; ++axis) points_[a][axis] = (points_[a][axis] + points_[b][axis]) / 2;
      for (Triangle& face : faces_) std::replace(face.begin(), face.end(), b, a);
      std::erase_if(faces_, [](const Triangle& f) { return f[0] == f[1] || f[1] == f[2] || f[2] == f[0]; });
    }
    std::vector<int> to(points_.size(), -1);
    std::vector<Vec3> kept;
    for (Triangle& face : faces_)
      for (int& i : face) {
        if (to[i] < 0) to[i] = static_cast<int>(kept.size()), kept.push_back(points_[i]);
        i = to[i];
      }
    points_ = kept;
  }

  /// Flips edges to the other diagonal of their two triangles: three of ten triangles are tried.
  void flip() {
    for (std::size_t left = faces_.size() * 3 / 10; left > 0; --left) {
      const int one = any(faces_.size()), k = any(3);
      const int a = faces_[one][k], b = faces_[one][(k + 1) % 3], c = faces_[one][(k + 2) % 3];
      for (std::size_t two = 0; two < faces_.size(); ++two) {
        const auto at = std::find(faces_[two].begin(), faces_[two].end(), b) - faces_[two].begin();
        if (at == 3 || faces_[two][(at + 1) % 3] != a) continue;
        const int d = faces_[two][(at + 2) % 3];
        const auto near = neighbours();
        if (d == c || near[c].contains(d) || near[a].size() < 5 || near[b].size() < 5 || near[c].size() > 9 ||
            near[d].size() > 9)
          break;
        faces_[one] = {a, d, c}, faces_[two] = {d, b, c};
        break;
      }
    }
  }

  /// Splits a share of the triangles by a point at 1/50 of the height above a side.
  void add_slivers(double share) {
    std::vector<bool> used(faces_.size(), false);
    const std::size_t whole = faces_.size();
    for (auto left = static_cast<std::size_t>(share * double(whole)); left > 0; --left) {
      const int f = any(whole), k = any(3);
      if (used[f]) continue;
      used[f] = true;
      const int a = faces_[f][k], b = faces_[f][(k + 1) % 3], c = faces_[f][(k + 2) % 3];
      const double along = 0.3 + 0.2 * unit(), height = 1.0 / 50;
      Vec3 p;
      for (int axis = 0; axis < 3; ++axis)
        p[axis] =
            height * points_[c][axis] + (1 - height) * (along * points_[a][axis] + (1 - along) * points_[b][axis]);
      const int i = static_cast<int>(points_.size());
      points_.push_back(p);
      faces_[f] = {a, b, i};
      faces_.push_back({b, c, i}), faces_.push_back({c, a, i});
    }
  }

  std::mt19937 random_;
  std::vector<Vec3> points_;
  std::vector<Triangle> faces_;
};

}  // namespace malha
