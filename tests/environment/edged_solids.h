// SPDX-License-Identifier: Apache-2.0
// Solids with sharp edges and corners, and the cloth that they touch.
#pragma once
#include <cmath>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include "malha/scene.h"
#include "tests/numbers.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {

/// The position of a vertex of the object at a time (s), by its place in the file.
using Deformation = std::function<Vec3(const Vec3&, double)>;

/// Triangulated solids, written as one OBJ file.
class EdgedSolids {
 public:
  /// A ridge along z of the height of `low` to `high`, with a base `wide` on both sides of it.
  void ridge(double x, double wide, double low, double high, double z0, double z1) {
    const int a = corner({x - wide, low, z0}), b = corner({x + wide, low, z0}), c = corner({x, high, z0}),
              d = corner({x - wide, low, z1}), e = corner({x + wide, low, z1}), f = corner({x, high, z1});
    face(a, c, b), face(d, e, f), face(a, b, e), face(a, e, d), face(a, d, f), face(a, f, c), face(b, c, f),
        face(b, f, e);
  }
  /// A pyramid with its tip at `tip`.
  void nail(const Vec3& tip, double height, double radius, int sides, double turn) {
    const int first = corner(tip);
    for (int k = 0; k < sides; ++k) {
      const double a = turn - 2 * kPi * k / sides;
      corner({tip[0] + radius * std::cos(a), tip[1] - height, tip[2] + radius * std::sin(a)});
    }
    for (int k = 0; k < sides; ++k) face(first, first + 1 + k, first + 1 + (k + 1) % sides);
    for (int k = 1; k + 1 < sides; ++k) face(first + 1, first + 2 + k, first + 1 + k);
  }
  void box(const Vec3& low, const Vec3& high) {
    int at[8];
    for (int k = 0; k < 8; ++k)
      at[k] =
          corner({(k & 1) != 0 ? high[0] : low[0], (k & 2) != 0 ? high[1] : low[1], (k & 4) != 0 ? high[2] : low[2]});
    constexpr int sides[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    for (const auto& s : sides) face(at[s[0]], at[s[1]], at[s[2]]), face(at[s[0]], at[s[2]], at[s[3]]);
  }
  std::string obj(const Deformation& deformation = {}, double time = 0) const {
    std::ostringstream text;
    text.precision(17);
    for (const Vec3& x : points_) {
      const Vec3 at = deformation ? deformation(x, time) : x;
      text << "v " << at[0] << " " << at[1] << " " << at[2] << "\n";
    }
    for (const Triangle& t : faces_) text << "f " << t[0] << " " << t[1] << " " << t[2] << "\n";
    return text.str();
  }
  EnvironmentSpec object(const TemporaryFolder& folder, const std::string& name,
                         const Deformation& deformation = {}) const {
    EnvironmentSpec spec;
    spec.name = name, spec.shape = MeshFile{folder.write(name + ".obj", obj(deformation))};
    spec.thickness = 0.01, spec.friction = 0.3;
    return spec;
  }
  /// An object with edges whose vertices the test sets.
  EnvironmentSpec deforming_object(const TemporaryFolder& folder, const Deformation& deformation) const {
    EnvironmentSpec spec = object(folder, "object", deformation);
    spec.edges = true, spec.animation.emplace().from_code = true;
    return spec;
  }
  const std::vector<Vec3>& points() const { return points_; }

 private:
  int corner(const Vec3& at) {
    points_.push_back(at);
    return static_cast<int>(points_.size());
  }
  void face(int a, int b, int c) { faces_.push_back({a, b, c}); }
  std::vector<Vec3> points_;
  std::vector<Triangle> faces_;
};

/// A cloth of 1 x 1 m, `y` above the origin, of cells of 0.1 m or of irregular triangles of that size.
inline BodySpec cloth_above(double y, const std::string& file = "") {
  BodySpec body;
  body.name = "cloth";
  body.shape = GridShape{{1, 1}, {10, 10}};
  if (!file.empty()) body.shape = MeshFile{file};
  body.transform.translate = {-0.5, y, -0.5};
  body.density = 0.2;
  body.constraints = {stiff("distance", {"edges"}), stiff("bending", {}, 0.02)};
  return body;
}

}  // namespace malha
