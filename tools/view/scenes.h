// SPDX-License-Identifier: Apache-2.0
// Scenes that the window makes: of a mesh that was dropped on it, and with a thrown ball.
#pragma once
#include <string>
#include <vector>

#include "malha/scene.h"

namespace malha::view {

/// Returns the scene files beside this one, in the folder scenes of the working directory, and installed with this
/// program, sorted without duplicates.
std::vector<std::string> scenes_near(const std::string& scene);

/// Returns a scene of a mesh file as a cloth, or as a soft solid if it has tetrahedra, above a floor. Throws
/// InputError.
Scene scene_of_mesh(const std::string& path);

/// Adds a ball as an environment object with keyframes: it flies from a position (m) at a time (s) with a velocity
/// (m/s) under the scene's gravity, and nothing slows it.
void throw_ball(Scene& scene, double time, const Vec3& from, const Vec3& velocity, double radius);

}  // namespace malha::view
