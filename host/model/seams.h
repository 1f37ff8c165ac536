// SPDX-License-Identifier: Apache-2.0
// Seams of a scene: the particles that they join, and what follows for bodies as wholes. A seam is a set of constraints
// (kernels/constraints/seam.h) from which everything else about it is derived.
#pragma once
#include <vector>

#include "host/mesh/compressed_lists.h"
#include "host/model/body.h"
#include "host/model/model.h"

namespace malha {

/// The joints of one seam.
struct Joints {
  bool to_surface;     // particles to triangles rather than to particles
  double per_closing;  // 1/s, the rate at which the gap closes
  double compliance;   // m/N
  /// In the user's numbering: two for each joint, or a particle and the corners of the triangle that it is attached to.
  std::vector<int> particles;
  int arity() const { return to_surface ? 4 : 2; }
};

/// Finds the joints of all seams of the scene. `body_begin`: the first particle of each body. Throws InputError for an
/// end without particles, for particles without a partner, for pinned particles that are sewn together but apart, and
/// for bodies that tear or that differ in damping.
std::vector<Joints> find_joints(const Scene& scene, const std::vector<Body>& bodies,
                                const std::vector<int>& body_begin);

/// Pairs of particles that joints connect, such as edges of a graph.
std::vector<Edge> edges_of(const std::vector<Joints>& joints);

/// Tells whether a set consists of joints.
bool is_seam(const ConstraintSet& set);

/// The particle, in the user's numbering, that stands for all that seams join in one place with each particle: the
/// lowest. Attachments to surfaces join nothing in one place.
std::vector<int> places_of_particles(int particles, const std::vector<Joints>& joints);

/// For each particle of the model those that seams hold at its place, or at a triangle that has its place as a corner
/// or it as the attached point; of triangles the corners. Empty lists if the model has no seams.
CompressedLists<int> sewn_particles(const Model& model);

/// Tells whether seams without compliance hold particles in one place.
bool has_closed_places(const Model& model);

/// Tells whether seams without compliance hold three particles or more in one place. The patches' solves, which close
/// one pair after the other, leave such places open.
bool has_shared_places(const Model& model);

/// The particles at each place that seams without compliance hold; none without such seams.
CompressedLists<int> closed_places(const Model& model);

/// The lowest of the bodies that seams connect with each body.
std::vector<int> sewn_bodies(const Model& model);

/// The time (s) from which on all seams are closed; 0 without seams.
double time_of_closed_seams(const Model& model);

/// Adds notes for seams that close fast, for edges whose ends are sewn to one place, and for a thickness of
/// self-collision at which a seam keeps its neighbourhood open.
void note_unlikely_seams(Model& model);

}  // namespace malha
