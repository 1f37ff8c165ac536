// SPDX-License-Identifier: Apache-2.0
// Choice of a camera for scenes that name none.
#pragma once
#include "host/model/model.h"
#include "host/render/picture.h"

namespace malha {

/// Returns a camera whose picture contains the bodies at the start; where they will hang if particles are pinned, or
/// lie if none are; the size to which a pressure inflates them; and environment objects that are not much larger than
/// the bodies (no ground planes). It views from the front, the right and above. Where objects occlude most of the
/// bodies from there, it takes the first of some other directions from which enough of them is visible, or the best.
Camera choose_camera(const Model& model, const PictureSpec& spec);

/// Returns the drawing of an environment object at a time (s).
Drawing draw_environment(const EnvironmentMesh& mesh, double time);

}  // namespace malha
