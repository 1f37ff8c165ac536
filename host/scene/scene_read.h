// SPDX-License-Identifier: Apache-2.0
// Readers of the parts of a scene, shared by scene*.cpp.
#pragma once
#include <string>

#include "host/scene/json_reader.h"
#include "malha/scene.h"

namespace malha {

/// A name that is also valid as a file name: without '/' and '\', and without '.' in front.
std::string read_name(const JsonReader& at);

enum class ShapeUse { Body, Environment };  // shapes of the environment need faces
/// Relative mesh paths are resolved against `folder`.
Shape read_shape(const JsonReader& at, ShapeUse use, const std::string& folder);
Transform read_transform(const JsonReader& at);
void read_rotation(const JsonReader& at, Vec3& axis, double& degrees);
/// Reads "min" and "max" of an axis-aligned box (m). Refuses min > max.
void read_box(const JsonReader& at, Vec3& min, Vec3& max);

/// Reads keyframes at increasing times.
std::vector<Keyframe> read_motion(const JsonReader& at);

SolverSpec read_solver(const JsonReader& at);
BodySpec read_body(const JsonReader& at, const std::string& folder);
Pin read_pin(const JsonReader& at, const Shape& shape);
Attachment read_attachment(const JsonReader& at, const Shape& shape);
Tear read_tear(const JsonReader& at);
ConstraintSpec read_constraint(const JsonReader& at);
EnvironmentSpec read_environment(const JsonReader& at, const std::string& folder);
OutputSpec read_outputs(const JsonReader& at);
/// `bodies` are the names of the bodies of the scene; empty if they are unknown.
Expect read_expect(const JsonReader& at, const std::vector<std::string>& bodies);

constexpr double max_particles = 2e7;  // of a shape that is generated or part of the scene
constexpr int max_steps = 1000000000;  // of a run, and of intervals of steps

}  // namespace malha
