// SPDX-License-Identifier: Apache-2.0
// Vertices of frames in the order of each body's mesh file, so that the file's UVs and materials fit every frame.
#pragma once
#include <vector>

#include "host/model/model.h"
#include "host/output/frames.h"

namespace malha {

class FrameVertices {
 public:
  explicit FrameVertices(const RenderMesh& render_mesh);

  std::size_t count() const { return particle_.empty() ? particles_ : particle_.size(); }

  /// The topology of the frames. It reads the bodies' mesh files again, for what they say of polygons. Throws
  /// InputError for a file that has changed since.
  FrameTopology topology(const Model& model) const;

  /// Maps positions (m) and velocities (m/s) of the particles, in the user's order, to the vertices. Unused vertices
  /// stay where they start.
  std::vector<Vec3> vertex_positions(std::vector<Vec3> of_particles) const;
  std::vector<Vec3> vertex_velocities(std::vector<Vec3> of_particles) const;

  /// Maps positions of the vertices to the particles; returns none if there are not count() of them.
  std::vector<Vec3> particle_positions(std::vector<Vec3> of_vertices) const;

 private:
  /// The faces of a body by vertices.
  std::vector<Quad> faces_of(const RenderMesh& render_mesh, std::size_t body) const;
  std::vector<Vec3> spread(std::vector<Vec3> of_particles, const std::vector<Vec3>& of_unused) const;
  int particle_at(int vertex) const { return particle_.empty() ? vertex : particle_[vertex]; }
  int lowest_vertex(int particle) const { return lowest_.empty() ? particle : lowest_[particle]; }

  std::size_t particles_;
  // All are empty where vertex i is particle i.
  std::vector<int> particle_;  // particle of each vertex; -1: unused
  std::vector<int> lowest_;    // lowest vertex of each particle
  std::vector<int> begin_;     // first vertex of each body
  std::vector<Vec3> unused_;   // m, positions of the unused vertices
};

}  // namespace malha
