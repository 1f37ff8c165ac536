// SPDX-License-Identifier: Apache-2.0
// Boundary conditions of bodies: permanent pins, pins that move or are released, and attachments to points; and changes
// of the pins between two steps.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "malha/scene.h"

namespace malha {

/// The target positions of pinned or attached particles, which move rigidly or with the surface of an object.
struct Target {
  std::optional<Vec3> point;     // m, one for all at the start; none: the position of each particle at the start
  std::vector<Keyframe> motion;  // that of the environment object, if there is one, otherwise relative to the start
  std::string environment;       // object in whose frame the targets are fixed; "": none
  bool deforms = false;          // the object deforms: each target follows the triangle closest to it at the start
  bool has_motion() const { return deforms || !motion.empty(); }
  bool moves() const { return point || has_motion(); }
};

/// Particles of a pin that moves or is released, or of a rigid attachment, which acts like one.
struct MovedPins {
  Target target;
  std::optional<double> release_time;  // s; none: never released
  std::vector<int> particles;
};

/// Particles attached to their targets by springs.
struct AttachmentSet {
  Target target;
  double stiffness = 1;
  std::optional<double> compliance;    // m/N
  std::optional<double> release_time;  // s
  std::vector<int> particles;
};

/// Boundary conditions of a body's particles, in the body's numbering.
struct BoundaryConditions {
  std::vector<bool> pinned;  // whether each particle is pinned permanently
  std::vector<MovedPins> moved;
  std::vector<AttachmentSet> attached;
  /// Tells whether each particle is pinned at the start.
  std::vector<bool> at_start() const;
};

/// Finds the boundary conditions of scene.bodies[body], whose transformed mesh is `mesh`. Throws InputError for a
/// selector that finds no particle or does not fit the shape, for pins that contradict each other, for an attachment
/// whose particles are all pinned, and for one to an environment object that does not exist.
BoundaryConditions find_boundary_conditions(const Scene& scene, std::size_t body, const Mesh& mesh);

/// The particles of scene.bodies[body], whose transformed mesh is `mesh`, that a selector selects: ascending, each
/// once. Throws InputError, which names the JSON pointer `here`, if there are none; `allowed` says what is there.
std::vector<int> select_particles(const Scene& scene, std::size_t body, const Mesh& mesh, const Selector& selector,
                                  const std::string& here, const std::string& allowed);

/// The points that vertices of the file became. Throws InputError for a vertex that does not exist or that no face,
/// line or tetrahedron uses.
std::vector<int> points_of(const Scene& scene, const Mesh& mesh, std::vector<int> vertices, const std::string& here);

struct Model;

/// Tells whether each particle (the solver's numbering) is fixed at the start by a pin or a rigid attachment, or, with
/// `include_springs`, by an attachment with a spring.
std::vector<bool> fixed_at_start(const Model& model, bool include_springs);

/// Copies the boundary conditions of a vertex that splits to its duplicate, which is the next particle of the body.
void split_boundary_conditions(int vertex, BoundaryConditions& boundary);

/// The particles that are pinned permanently and at rest, in the user's numbering, ascending.
std::vector<int> static_pins(const Model& model);

/// Tells whether each particle (the user's numbering) has a pin or a rigid attachment that moves.
std::vector<bool> has_keyframes(const Model& model);

/// The scene of the model with these particles (the user's numbering, ascending) as its static pins. Throws InputError
/// for an index out of range, and for a particle of a rigid attachment or of a pin with keyframes or a release time.
Scene with_pins(const Model& model, const std::vector<int>& particles);

}  // namespace malha
