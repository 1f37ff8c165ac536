// SPDX-License-Identifier: Apache-2.0
// The parts of a scene, each read from its place in the JSON. Inside scene*.cpp only.
#pragma once
#include <string>

#include "host/scene/json_reader.h"
#include "malha/scene.h"

namespace malha {

/// A name that may also name a file: no '/' or '\', no '.' in front.
std::string read_name(const JsonReader& at);

enum class ShapeUse { Body, Environment };  // the environment needs faces
/// `folder` is where relative mesh paths start.
Shape read_shape(const JsonReader& at, ShapeUse use, const std::string& folder);
Transform read_transform(const JsonReader& at);
void read_rotation(const JsonReader& at, Vec3& axis, double& degrees);
/// "min" and "max" of an axis-aligned box; refuses min > max.
void read_box(const JsonReader& at, Vec3& min, Vec3& max);

/// Keyframes at increasing times.
std::vector<Keyframe> read_motion(const JsonReader& at);

SolverSpec read_solver(const JsonReader& at);
BodySpec read_body(const JsonReader& at, const std::string& folder);
Pin read_pin(const JsonReader& at, const Shape& shape);
Attachment read_attachment(const JsonReader& at, const Shape& shape);
Tear read_tear(const JsonReader& at);
ConstraintSpec read_constraint(const JsonReader& at);
EnvironmentSpec read_environment(const JsonReader& at, const std::string& folder);
OutputSpec read_outputs(const JsonReader& at);
/// `bodies`: the names of those that the scene has; none: not known.
Expect read_expect(const JsonReader& at, const std::vector<std::string>& bodies);

constexpr double max_particles = 2e7;  // of one shape that the scene makes or lists
constexpr int max_steps = 1000000000;  // the largest "every n steps"

}  // namespace malha
