// SPDX-License-Identifier: Apache-2.0
// A model: a scene made ready to be simulated, still without precision or executor. Particles in the solver's order.
#pragma once
#include <string>
#include <vector>

#include "host/model/air_faces.h"
#include "host/model/long_range.h"
#include "host/model/ordering/patches.h"
#include "host/model/pins.h"
#include "host/model/springs.h"
#include "malha/scene.h"

namespace malha {

/// Constraints of one kind that share their numbers, over all the bodies that name them so.
struct ConstraintSet {
  std::string type;  // a name of the registry
  int arity = 2;
  double stiffness = 1;
  std::optional<double> compliance;
  double parameter = 1;
  std::vector<int> particles;    // arity a constraint
  std::vector<double> softness;  // each constraint's own part of its compliance, as of a material; empty: 1
  std::vector<double> rest{};    // each constraint's rest value; empty: that of the places at rest
  bool pressed = false;          // whether its bodies have a pressure
  int count() const { return static_cast<int>(particles.size()) / arity; }
  /// The compliance of its constraint c; 0 without one.
  double alpha(int c) const { return compliance.value_or(0) * (softness.empty() ? 1 : softness[c]); }
};

struct PressureSet {
  double volume_ratio = 1, stiffness = 1;  // of the volume at rest
  std::optional<double> compliance;        // m^5/N
  std::vector<int> particles;              // of the closed mesh
  std::vector<Triangle> triangles;         // solver indices
};

/// A connected body that is damped: particles first .. first + count - 1.
struct DampedIsland {
  int first, count;
  double damping;
};

/// A connected body that nothing holds and whose momenta are kept: particles first .. first + count - 1.
struct FreeIsland {
  int first, count;
};

/// What the scene's meshes look like to a person: everything in the user's order, all bodies one after the other.
struct RenderMesh {
  std::vector<Vec3> points;  // at the start
  std::vector<Quad> faces;
  std::vector<Edge> lines;
  std::vector<int> body_begin;              // first particle of each body, and one more: the number of particles
  std::vector<int> face_begin, line_begin;  // the same for faces and lines
  std::vector<FileVertices> vertices;       // of each body, before any tear
};

struct EnvironmentMesh {
  EnvironmentSpec spec;
  Mesh mesh;  // the spec's transform applied
};

/// Seconds that the parts of build_model took.
struct ModelSeconds {
  double load = 0;     // meshes read or made, checked and placed; their edges, masses and pins
  double order = 0;    // the solver's order
  double connect = 0;  // constraints listed
  double patches = 0;  // cut, their particles coloured and sorted
};

struct Model {
  Scene scene;
  RenderMesh render_mesh;
  std::vector<int> user_index;          // user's index of each particle of the solver
  std::vector<Vec3> x, v;               // m, m/s
  std::vector<double> w;                // 1/kg, 0 where pinned for good
  std::vector<double> mass;             // kg, of pinned particles too
  std::vector<ConstraintSet> sets;      // in the registry's order of kinds
  std::vector<SpringSet> springs;       // of Desbrun's method; `sets` then holds what is projected after the filter,
  std::vector<ConstraintSet> stencils;  // and these what else the filter sees, all with a compliance
  std::vector<PressureSet> pressures;
  LongRangeSet long_range;                           // of all bodies that name it
  AirFaces air;                                      // empty unless the wind has a density
  std::vector<std::vector<Tetrahedron>> tetrahedra;  // of each body that has any
  std::vector<DampedIsland> damped;
  std::vector<int> islands;      // first particle of each connected body; loose ones in a row count as one
  std::vector<FreeIsland> free;  // none unless the solver keeps their momenta
  std::vector<MovedPins> moved;
  std::vector<AttachmentSet> attached;
  Patches patches;
  std::vector<EnvironmentMesh> environment;
  ModelSeconds seconds;
  bool interactive = false;        // particles may be taken by hand (host/attachments/particle_handles.h)
  int zero_area_faces = 0;         // dropped from meshes, see check_mesh
  std::vector<std::string> notes;  // what a person should know of how the meshes were taken
  int count() const { return static_cast<int>(x.size()); }
};

/// Loads or generates the scene's meshes, checks them, and lays the model out, the same on any `threads`. Throws
/// InputError.
Model build_model(const Scene& scene, int threads = 1, const PatchBounds& bounds = {});

/// The number of the user's particle in its body, as its file counts vertices.
int number_in_body(const Model& model, int user_index);

/// Whose particle this is, for messages: "particle 12 of body 'sheet'" from an index in the user's order.
std::string particle_name(const Model& model, int user_index);

/// Of each vertex of a body's mesh, as its file counts them, the user's particle, or -1 where nothing uses it; then the
/// particles that tearing added.
std::vector<int> particles_of_vertices(const RenderMesh& render_mesh, std::size_t body);

/// The body of the user's particle; those of all particles, in the solver's order.
int body_of(const Model& model, int user_index);
std::vector<int> bodies_of(const Model& model);

}  // namespace malha
