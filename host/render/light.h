// SPDX-License-Identifier: Apache-2.0
// The light in every picture: a warm key light of some width over the left shoulder, a bluish sky, a warm floor.
#pragma once
#include "host/render/stage.h"

namespace malha {

/// How much of each light reaches a place, [0, 1].
struct Lit {
  float key = 0, sky = 0;
};

class Light {
 public:
  /// `unit` is the height of the whole picture at the target, m.
  Light(const Lens& view, float unit);

  /// What reaches the surface, by a few rays in the directions of a pattern: 0 to 15, together one even set.
  Lit reach(const Stage& stage, const SurfaceHit& surface, int pattern) const;

  /// Linear RGB that leaves the surface towards the eye.
  Vec shade(const Stage& stage, const SurfaceHit& surface, const Lit& lit, const Vec& towards_eye) const;

 private:
  Vec key_, key_right_, key_up_;  // unit: towards the key light, and across it
  float sky_reach_;               // m: what is farther does not darken the sky
};

/// Linear RGB behind everything; `height` in [0, 1] from the bottom to the top of the picture.
Vec background(float height);

}  // namespace malha
