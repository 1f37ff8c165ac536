// SPDX-License-Identifier: Apache-2.0
// The scene of a picture for ray tracing: geometry, smooth normals, colours.
#pragma once
#include <span>
#include <vector>

#include "host/environment/embree.h"
#include "host/render/picture.h"
#include "host/render/view.h"

namespace malha {

/// The hit of a ray.
struct SurfaceHit {
  int drawing = -1;      // -1: the background
  Vec point;             // m
  Vec shadow_origin;     // m, origin of shadow rays: slightly above the smooth surface that the triangles approximate
  Vec normal;            // unit shading normal on the side of the ray's origin
  Vec geometric_normal;  // unit normal of the triangle on the same side
  float distance = 0;    // m, from the ray's origin
  float wire = 0;        // [0, 1], coverage by a wire
};

class RenderScene {
 public:
  /// `unit`: height of the whole picture at the target, m, to which the sizes of balls, rods and wires are relative.
  RenderScene(std::span<const Drawing> drawings, float unit);

  /// Returns the first hit of a ray. `pixel`: side of a pixel at distance 1; wires are about a pixel wide.
  SurfaceHit trace(const Vec& origin, const Vec& direction, float pixel) const;

  /// Returns whether anything lies between the origin and origin + reach direction.
  bool is_occluded(const Vec& origin, const Vec& direction, float reach) const;

  /// Returns the linear RGB of a drawing.
  const Vec& colour(int drawing) const { return parts_[drawing].colour; }

 private:
  struct Part {
    const Drawing* drawing;
    Vec colour;
    std::vector<Vec> normals;  // 3 a triangle, one a corner; zero if the triangle has no area
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

/// Returns unit normals at the corners of the triangles, 3 a triangle: the mean over the triangles around the point
/// whose angle to this one is within the crease angle, weighted by their angles at the point (Thürmer and Wüthrich
/// 1998). They are zero if a triangle has no area or is not finite.
std::vector<Vec> corner_normals(const std::vector<std::array<float, 3>>& points,
                                const std::vector<Triangle>& triangles);

}  // namespace malha
