// SPDX-License-Identifier: Apache-2.0
// Which particles of a body do not move, which follow keyframes or are released, and which are tied to points.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "malha/scene.h"

namespace malha {

/// Where held particles belong: places that move rigidly.
struct Target {
  std::optional<Vec3> point;     // one for all at the start (m); none: their own places there
  std::vector<Keyframe> motion;  // of the environment mesh where there is one, otherwise relative to the start
  std::string environment;       // the mesh that carries them; "": none
  bool moves() const { return point || !motion.empty(); }
};

/// The particles of a pin that moves or is let go, or of a rigid attachment, which is the same.
struct MovedPins {
  Target target;
  std::optional<double> release_time;  // s; none: never let go
  std::vector<int> particles;
};

/// Particles on springs to their places.
struct AttachmentSet {
  Target target;
  double stiffness = 1;
  std::optional<double> compliance;    // m/N
  std::optional<double> release_time;  // s
  std::vector<int> particles;
};

/// What holds a body's particles, in the body's own numbers.
struct Holds {
  std::vector<bool> pinned;  // of each particle: for good
  std::vector<MovedPins> moved;
  std::vector<AttachmentSet> attached;
  /// Whether each particle is pinned at the start.
  std::vector<bool> at_start() const;
};

/// Of the particles of `mesh`, the placed mesh of scene.bodies[body]. Throws InputError for a selector that finds no
/// particle or does not fit the shape, for pins that leave nothing to move or contradict each other, and for an
/// attachment to an environment object that is not there.
Holds find_holds(const Scene& scene, std::size_t body, const Mesh& mesh);

struct Model;

/// Whether each particle (the solver's number) is held at the start: by pins, rigid attachments, and, where they are to
/// be `tied` too, by the springs of others.
std::vector<bool> held_at_start(const Model& model, bool tied);

/// What holds a vertex that splits holds its duplicate too, the next particle.
void split_holds(int vertex, Holds& holds);

}  // namespace malha
