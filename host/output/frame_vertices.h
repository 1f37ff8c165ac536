// SPDX-License-Identifier: Apache-2.0
// The vertices of frames: each body's as its file counts them, so that what hangs on the file (its UVs, its materials)
// fits every frame.
#pragma once
#include <vector>

#include "host/model/model.h"
#include "host/output/frames.h"

namespace malha {

class FrameVertices {
 public:
  explicit FrameVertices(const RenderMesh& render_mesh);

  std::size_t count() const { return particle_.empty() ? particles_ : particle_.size(); }
  FrameTopology topology(const Model& model) const;

  /// Places (m) and velocities (m/s) of the particles, in the user's order, as those of the vertices: what nothing uses
  /// lies where it starts.
  std::vector<Vec3> places(std::vector<Vec3> of_particles) const;
  std::vector<Vec3> velocities(std::vector<Vec3> of_particles) const;

  /// The places of the particles from those of the vertices; none where they are not `count`.
  std::vector<Vec3> of_particles(std::vector<Vec3> places) const;

 private:
  std::vector<Vec3> spread(std::vector<Vec3> of_particles, const std::vector<Vec3>& of_unused) const;
  int particle_at(int vertex) const { return particle_.empty() ? vertex : particle_[vertex]; }
  int lowest_vertex(int particle) const { return lowest_.empty() ? particle : lowest_[particle]; }

  std::size_t particles_;
  // Empty where vertex i is particle i:
  std::vector<int> particle_;  // of each vertex; -1: none
  std::vector<int> lowest_;    // vertex of each particle
  std::vector<int> begin_;     // first vertex of each body
  std::vector<Vec3> unused_;   // m, of the vertices that are no particle
};

}  // namespace malha
