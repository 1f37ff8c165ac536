// SPDX-License-Identifier: Apache-2.0
// Lights of pictures: a warm area light over the left shoulder of the camera, a bluish sky, a warm floor.
#pragma once
#include "host/render/stage.h"

namespace malha {

/// Visible share of each light at a point, [0, 1].
struct Visibility {
  float key = 0, sky = 0;
};

class Light {
 public:
  /// `unit` is the height of the whole picture at the target, m.
  Light(const Lens& view, float unit);

  /// Estimates the visible share of the lights by a few shadow rays. `pattern`, 0 to 15, chooses their directions; all
  /// 16 together are one even set.
  Visibility visibility_at(const RenderScene& scene, const SurfaceHit& surface, int pattern) const;

  /// Returns the linear RGB that the surface reflects towards the eye.
  Vec shade(const RenderScene& scene, const SurfaceHit& surface, const Visibility& visibility,
            const Vec& towards_eye) const;

 private:
  Vec key_, key_right_, key_up_;  // unit vectors towards the key light, and perpendicular to it
  float sky_reach_;               // m, length of occlusion rays towards the sky
};

/// Returns the linear RGB of the background; `height` in [0, 1] from the bottom to the top of the picture.
Vec background(float height);

}  // namespace malha
