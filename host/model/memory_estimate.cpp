// SPDX-License-Identifier: Apache-2.0
#include "host/model/memory_estimate.h"

#include <cmath>

#include "host/base/memory_size.h"
#include "malha/error.h"

namespace malha {

namespace {

/// Calls visit(array) for every array of the model.
template <class M, class Visit>
void for_each_array(M& model, const Visit& visit) {
  auto& render_mesh = model.render_mesh;
  visit(render_mesh.points), visit(render_mesh.faces), visit(render_mesh.lines);
  visit(render_mesh.body_begin), visit(render_mesh.face_begin), visit(render_mesh.line_begin);
  for (auto& file : render_mesh.vertices) visit(file.point), visit(file.position), visit(file.faces);
  for (auto& rest : render_mesh.rest) visit(rest.points), visit(rest.faces), visit(rest.lines);
  visit(model.rest_x), visit(model.user_index), visit(model.x), visit(model.v), visit(model.w), visit(model.mass);
  visit(model.friction_factor), visit(model.thickness_factor);
  for (auto* sets : {&model.sets, &model.stencils})
    for (auto& set : *sets) visit(set.particles), visit(set.softness), visit(set.parameters), visit(set.rest_corners);
  for (auto& set : model.springs) visit(set.ends), visit(set.stiffness), visit(set.rest);
  for (auto& set : model.pressures) visit(set.particles), visit(set.triangles), visit(set.followers);
  for (auto& body : model.tetrahedra) visit(body);
  visit(model.damped), visit(model.free);
  visit(model.long_range.particle), visit(model.long_range.begin);
  visit(model.long_range.anchor), visit(model.long_range.max_distance);
  visit(model.air.particle), visit(model.air.begin), visit(model.air.incident);
  visit(model.air.faces);
  for (auto& pins : model.moved) visit(pins.particles);
  for (auto& set : model.attached) visit(set.particles);
  visit(model.patches.begin), visit(model.patches.class_of);
  for (auto& environment : model.environment)
    visit(environment.mesh.points), visit(environment.mesh.faces), visit(environment.mesh.lines);
}

constexpr double kSphere = 10;  // an icosahedron after s subdivisions has 10 4^s + 2 vertices

double particles_of(const GridShape& s) { return (s.cells[0] + 1.0) * (s.cells[1] + 1.0); }
double particles_of(const SphereShape& s) { return kSphere * std::pow(4, *s.subdivisions) + 2; }
double particles_of(const BoxShape& s) {
  const double x = (*s.cells)[0], y = (*s.cells)[1], z = (*s.cells)[2];
  return 2 * (x * y + y * z + z * x) + 2;
}
double particles_of(const TetBoxShape& s) { return (s.cells[0] + 1.0) * (s.cells[1] + 1.0) * (s.cells[2] + 1.0); }
double particles_of(const BarShape& s) { return 4.0 * s.cells * std::floor(s.length / s.width * s.cells); }
double particles_of(const ChainShape& s) { return s.segments + 1.0; }
double particles_of(const LatticeShape& s) { return 1.0 * s.count[0] * s.count[1] * s.count[2]; }
double particles_of(const MeshDataShape& s) { return static_cast<double>(s.points.size()); }
double particles_of(const MeshFile&) { return 0; }
// Exact shapes have a few points for drawing alone.
double particles_of(const PlaneShape&) { return 0; }
double particles_of(const CapsuleShape&) { return 0; }
double particles_of(const CylinderShape&) { return 0; }

/// A lower bound of the memory for setting up the generated shapes of a scene, in bytes: measured with a million
/// particles each, and rounded down.
double min_setup_bytes(const Scene& scene) {
  // Measured per particle: a lattice takes 183 bytes, a grid 293, and 492 with edges and shear.
  constexpr double particle = 170, element = 80, constraint = 60;
  double sum = 0;
  for (const BodySpec& body : scene.bodies) {
    double each = particle + (is_loose(body.shape) ? 0 : element);
    for (const ConstraintSpec& spec : body.constraints) each += constraint * static_cast<double>(spec.elements.size());
    sum += each * std::visit([](const auto& shape) { return particles_of(shape); }, body.shape);
  }
  for (const EnvironmentSpec& object : scene.environment)
    if (!is_exact(object.shape))
      sum += element * std::visit([](const auto& shape) { return particles_of(shape); }, object.shape);
  return sum;
}

}  // namespace

void require_memory(const Scene& scene) {
  constexpr double small = 1 << 26;  // below this the free memory is not queried
  const double needs = min_setup_bytes(scene);
  if (needs < small) return;
  if (const auto free = static_cast<double>(available_memory()); needs > free)
    refuse<OutOfMemory>(scene.file.empty() ? scene.name : scene.file, "/bodies",
                        "a scene that needs at least " + in_gib(needs),
                        "one that fits into the free memory, " + in_gib(free));
}

std::size_t bytes(const Model& model) {
  std::size_t sum = 0;
  for_each_array(model, [&sum](const auto& array) { sum += array.capacity() * sizeof(array[0]); });
  return sum;
}

void release_setup_memory(Model& model) {
  model.v = {}, model.mass = {}, model.long_range = {}, model.air = {};
  for_each_array(model, [](auto& array) { array.shrink_to_fit(); });
}

}  // namespace malha
