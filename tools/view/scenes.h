// SPDX-License-Identifier: Apache-2.0
// Scenes that the window makes: of a mesh that was dropped on it, and with a ball thrown in.
#pragma once
#include <string>
#include <vector>

#include "malha/scene.h"

namespace malha::view {

/// The scene files beside this one, those of the folder scenes here, and those that were installed with this program;
/// sorted, each once.
std::vector<std::string> scenes_near(const std::string& scene);

/// A mesh as a cloth, or as a soft solid where it is full of tetrahedra, above a floor. Throws InputError.
Scene scene_of_mesh(const std::string& path);

/// A solid ball (m) that flies from a place at a time (s) with a velocity (m/s) under the scene's gravity, whatever it
/// hits: an object of the environment with keyframes.
void throw_ball(Scene& scene, double time, const Vec3& from, const Vec3& velocity, double radius);

}  // namespace malha::view
