// SPDX-License-Identifier: Apache-2.0
// What a picture shows, ready for rays: geometry, smooth normals, colours.
#pragma once
#include <span>
#include <vector>

#include "host/environment/embree.h"
#include "host/render/picture.h"
#include "host/render/view.h"

namespace malha {

/// Where a ray meets the scene.
struct SurfaceHit {
  int drawing = -1;  // -1: the background
  Vec point;         // m
  Vec start;         // m, where light rays leave: a little above the smooth surface that the triangles stand for
  Vec normal;        // unit, shading; on the side of the ray's origin
  Vec flat;          // unit, geometric; likewise
  float reach = 0;   // m, distance from the ray's origin
  float wire = 0;    // [0, 1], how much of a wire covers the place
};

class Stage {
 public:
  /// `unit` is the height of the whole picture at the target, m: balls, rods and wires have sizes relative to it.
  Stage(std::span<const Drawing> drawings, float unit);

  /// `pixel` is the side of a pixel at distance 1; wires are about a pixel wide.
  SurfaceHit look(const Vec& origin, const Vec& direction, float pixel) const;

  /// Whether something lies between the origin and origin + reach direction.
  bool shadowed(const Vec& origin, const Vec& direction, float reach) const;

  /// Linear RGB.
  const Vec& colour(int drawing) const { return parts_[drawing].colour; }

 private:
  struct Part {
    const Drawing* drawing;
    Vec colour;
    std::vector<Vec> normals;  // 3 a triangle, one a corner; zero where the triangle has no area
  };
  struct Source {  // of an Embree geometry
    int drawing;
    bool triangles;
  };

  void add(int drawing, bool triangles, int geometry);
  void add_round(int number, const Drawing& drawing, float unit);
  void on_triangle(const Part& part, const Hit& hit, float pixel, bool behind, SurfaceHit& surface) const;

  Device device_;
  RayScene scene_;
  std::vector<Part> parts_;
  std::vector<Source> sources_;  // by Hit::geometry
};

/// Unit normals at the corners of the triangles, 3 a triangle: the mean over the triangles around the point that lie
/// within the crease angle of this one, weighted by their angles there (Thürmer and Wüthrich 1998). Zero where a
/// triangle has no area or is not finite.
std::vector<Vec> corner_normals(const std::vector<std::array<float, 3>>& points,
                                const std::vector<Triangle>& triangles);

}  // namespace malha
