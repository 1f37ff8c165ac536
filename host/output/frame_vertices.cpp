// SPDX-License-Identifier: Apache-2.0
#include "host/output/frame_vertices.h"

#include <algorithm>
#include <utility>

#include "host/output/topology_builder.h"

namespace malha {

FrameVertices::FrameVertices(const RenderMesh& render_mesh) : particles_(render_mesh.points.size()) {
  if (std::ranges::all_of(render_mesh.vertices, [](const FileVertices& file) { return file.point.empty(); })) return;
  lowest_.resize(particles_);
  for (std::size_t b = 0; b < render_mesh.vertices.size(); ++b) {
    begin_.push_back(static_cast<int>(particle_.size()));
    const std::vector<int> own = particles_of_vertices(render_mesh, b);
    for (int vertex = static_cast<int>(own.size()); vertex-- > 0;) {
      if (own[vertex] >= 0) lowest_[own[vertex]] = begin_[b] + vertex;
    }
    for (std::size_t vertex = 0; vertex < own.size(); ++vertex)
      if (own[vertex] < 0) unused_.push_back(render_mesh.vertices[b].position[vertex]);
    particle_.insert(particle_.end(), own.begin(), own.end());
  }
}

FrameTopology FrameVertices::topology(const Model& model) const {
  const RenderMesh& render_mesh = model.render_mesh;
  FrameTopology all;
  all.lines = render_mesh.lines, all.rest = vertex_positions(render_mesh.points);
  all.in_double = model.scene.solver.precision == Precision::Double;
  all.environment = model.environment;
  if (!begin_.empty())
    for (Edge& line : all.lines) line = {lowest_[line[0]], lowest_[line[1]]};
  TopologyBuilder builder(model.scene, all);
  for (std::size_t b = 0; b < model.scene.bodies.size(); ++b) {
    const int begin = begin_.empty() ? render_mesh.body_begin[b] : begin_[b];
    const auto end = b + 1 == model.scene.bodies.size() ? count()
                     : begin_.empty()                   ? static_cast<std::size_t>(render_mesh.body_begin[b + 1])
                                                        : static_cast<std::size_t>(begin_[b + 1]);
    builder.add_body(begin, static_cast<int>(end), faces_of(render_mesh, b));
  }

  builder.name_environment();

  std::vector<bool> drawn(count(), false), used(particles_, false);
  const auto use = [&](const auto& corners) {
    for (const int vertex : corners) {
      drawn[vertex] = true;
      if (const int particle = particle_at(vertex); particle >= 0) used[particle] = true;
    }
  };
  use(all.polygons.corners);
  for (const Edge& line : all.lines) use(line);
  for (int i = 0; i < static_cast<int>(particles_); ++i)
    if (!used[i]) all.loose.push_back(lowest_vertex(i)), drawn[lowest_vertex(i)] = true;
  for (int vertex = 0; vertex < static_cast<int>(drawn.size()); ++vertex)
    if (!drawn[vertex]) all.unused.push_back(vertex);
  return all;
}

std::vector<Quad> FrameVertices::faces_of(const RenderMesh& render_mesh, std::size_t b) const {
  const auto first = render_mesh.faces.begin();
  std::vector<Quad> faces(first + render_mesh.face_begin[b], first + render_mesh.face_begin[b + 1]);
  if (begin_.empty()) return faces;
  const std::vector<Quad>& in_file = render_mesh.vertices[b].faces;
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (int k = 0; k < 4; ++k) {
      const int particle = faces[f][k];
      if (particle < 0) continue;
      // The vertex that the file names for this corner, unless tearing replaced its particle.
      const int own = in_file.empty() ? -1 : begin_[b] + in_file[f][k];
      faces[f][k] = own >= 0 && particle_[own] == particle ? own : lowest_[particle];
    }
  return faces;
}

std::vector<Vec3> FrameVertices::vertex_positions(std::vector<Vec3> of_particles) const {
  return spread(std::move(of_particles), unused_);
}

std::vector<Vec3> FrameVertices::vertex_velocities(std::vector<Vec3> of_particles) const {
  return spread(std::move(of_particles), std::vector<Vec3>(unused_.size()));
}

std::vector<Vec3> FrameVertices::spread(std::vector<Vec3> of_particles, const std::vector<Vec3>& of_unused) const {
  if (particle_.empty()) return of_particles;
  std::vector<Vec3> all;
  auto unused = of_unused.begin();
  for (const int particle : particle_) all.push_back(particle < 0 ? *unused++ : of_particles[particle]);
  return all;
}

std::vector<Vec3> FrameVertices::particle_positions(std::vector<Vec3> of_vertices) const {
  if (of_vertices.size() != count()) return {};
  if (particle_.empty()) return of_vertices;
  std::vector<Vec3> all;
  for (const int vertex : lowest_) all.push_back(of_vertices[vertex]);
  return all;
}

}  // namespace malha
