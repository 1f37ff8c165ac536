// SPDX-License-Identifier: Apache-2.0
// The pinhole camera of host/render/picture.h.
#pragma once
#include <Eigen/Core>

#include "malha/scene.h"

namespace malha {

using Vec = Eigen::Vector3f;

/// Camera rays through an image plane.
struct Lens {
  Vec eye, right, up, forward;  // m; an orthonormal basis
  float pixel;                  // side of a pixel on the plane at distance 1
  float width, height;          // pixels

  Lens(const Camera& camera, int image_width, int image_height);

  /// Returns the unit direction through a point of the image, in pixels from the top left corner.
  Vec direction(float x, float y) const {
    return (forward + (x - 0.5f * width) * pixel * right + (0.5f * height - y) * pixel * up).normalized();
  }
};

}  // namespace malha
