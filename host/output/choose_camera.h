// SPDX-License-Identifier: Apache-2.0
// The camera of pictures whose scene names none.
#pragma once
#include "host/model/model.h"
#include "host/render/picture.h"

namespace malha {

/// Holds the bodies at the start, where they will hang if something is pinned, where they will lie if nothing is, and
/// as large as a pressure blows them up; and of the environment what is not much larger than they are (no ground
/// planes). It looks from the front, the right and above, unless objects hide most of the bodies from there: then from
/// whichever of some other places sees most of them.
Camera choose_camera(const Model& model, const PictureSpec& spec);

/// What a picture shows of an environment object at a time (s).
Drawing draw_environment(const EnvironmentMesh& mesh, double time);

}  // namespace malha
