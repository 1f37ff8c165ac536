// SPDX-License-Identifier: Apache-2.0
// The model of a scene: particles in the solver's order, constraints, boundary conditions and patches, independent of
// precision and executor.
#pragma once
#include <string>
#include <vector>

#include "host/model/exact_shape.h"
#include "host/model/ordering/patches.h"
#include "host/model/pins.h"
#include "malha/scene.h"

namespace malha {

/// Constraints of one kind with the same parameters, of all bodies that have them.
struct ConstraintSet {
  std::string type;  // name of the kind in the registry
  int arity = 2;     // particles per constraint
  double stiffness = 1;
  std::optional<double> compliance;
  double parameter = 1;
  std::vector<int> particles;    // arity for each constraint
  std::vector<double> softness;  // factor of the compliance of each constraint, as of a material; empty: 1
  std::vector<double> rest{};    // rest value of each constraint; empty: that of the rest positions
  bool pressed = false;          // true if its bodies have a pressure
  int count() const { return static_cast<int>(particles.size()) / arity; }
  /// The compliance of constraint c; 0 if the set has none.
  double alpha(int c) const { return compliance.value_or(0) * (softness.empty() ? 1 : softness[c]); }
};

/// Pressure of a closed body.
struct PressureSet {
  double volume_ratio = 1, stiffness = 1;  // target volume over rest volume
  std::optional<double> compliance;        // m^5/N
  std::vector<int> particles;              // all particles of the closed mesh
  std::vector<Triangle> triangles;         // of the closed mesh
};

/// Springs of Desbrun's method.
struct SpringSet {
  std::string type;               // of the constraints
  std::vector<Edge> ends;         // the two particles of each spring
  std::vector<double> stiffness;  // N/m, of each
  std::vector<double> rest;       // m
};

/// Long-range attachments of particles to pins (Kim, Chentanez, Müller 2012). Those of particle[k] are begin[k] ..
/// begin[k + 1] - 1.
struct LongRangeSet {
  std::vector<int> particle;
  std::vector<int> begin;
  std::vector<int> anchor;           // pinned particle of each attachment; for each particle the farthest first
  std::vector<double> max_distance;  // m, of each attachment
  int items() const { return static_cast<int>(particle.size()); }
};

/// Faces on which the air acts, and the incident faces of each particle.
struct AirFaces {
  std::vector<Quad> faces;
  std::vector<int> particle;  // particles with a face, including pinned ones, which may be released
  // The faces of particle[k] are incident[begin[k]] .. incident[begin[k + 1] - 1].
  std::vector<int> begin, incident;
};

/// A connected component with damping: particles first .. first + count - 1.
struct DampedIsland {
  int first, count;
  double damping;
};

/// A connected component without pins and attachments whose momenta are conserved: particles first .. first + count
/// - 1.
struct FreeIsland {
  int first, count;
};

/// The meshes of all bodies for output and display, one after the other, in the user's order.
struct RenderMesh {
  std::vector<Vec3> points;  // m, at the start
  std::vector<Quad> faces;
  std::vector<Edge> lines;
  std::vector<int> body_begin;              // first particle of each body, then the number of particles
  std::vector<int> face_begin, line_begin;  // first face and line of each body, then their numbers
  std::vector<FileVertices> vertices;       // of each body, before any tear
};

/// An object of the environment.
struct EnvironmentMesh {
  EnvironmentSpec spec;
  Mesh mesh;                         // after the transform of the spec; of an exact shape for drawing alone
  std::optional<PlacedShape> exact;  // none: particles touch the mesh
};

/// Duration of the parts of build_model(), s.
struct ModelSeconds {
  double load = 0;               // reading or generating, checking and transforming meshes; edges, masses and pins
  double order = 0;              // the solver's order of particles
  double build_constraints = 0;  // listing constraints
  double patches = 0;            // cutting into patches, colouring and sorting their particles
};

struct Model {
  Scene scene;
  RenderMesh render_mesh;
  std::vector<int> user_index;      // the user's index of each particle of the solver
  std::vector<Vec3> x, v;           // m, m/s
  std::vector<double> w;            // 1/kg, 0 where pinned permanently
  std::vector<double> mass;         // kg, including pinned particles
  std::vector<ConstraintSet> sets;  // in the registry's order of kinds
  // With Desbrun's method `springs` and `stencils`, all of which have a compliance, are in the filter; `sets` are
  // projected after it.
  std::vector<SpringSet> springs;
  std::vector<ConstraintSet> stencils;
  std::vector<PressureSet> pressures;
  LongRangeSet long_range;                           // of all bodies
  AirFaces air;                                      // empty unless the wind has a density
  std::vector<std::vector<Tetrahedron>> tetrahedra;  // of each body with tetrahedra
  std::vector<DampedIsland> damped;
  std::vector<FreeIsland> free;  // empty unless the solver corrects momenta
  std::vector<MovedPins> moved;
  std::vector<AttachmentSet> attached;
  Patches patches;
  std::vector<EnvironmentMesh> environment;
  ModelSeconds seconds;
  bool interactive = false;        // particles may be dragged or held (host/attachments/particle_handles.h)
  int zero_area_faces = 0;         // dropped from meshes, see check_mesh()
  std::vector<std::string> notes;  // lines for the user about the scene and its meshes
  int count() const { return static_cast<int>(x.size()); }
};

/// Builds the model of a scene: reads or generates its meshes, checks them, and lays the model out. The result is the
/// same for any number of threads. Throws InputError.
Model build_model(const Scene& scene, int threads = 1, const PatchBounds& bounds = {});

/// The number of the user's particle in its body, in the numbering of its file.
int number_in_body(const Model& model, int user_index);

/// The name of a particle in messages, from its index in the user's order: "particle 12 of body 'sheet'".
std::string particle_name(const Model& model, int user_index);

/// The user's particle of each vertex of a body's mesh, in the numbering of its file, or -1 for an unused vertex; the
/// particles that tearing added follow.
std::vector<int> particles_of_vertices(const RenderMesh& render_mesh, std::size_t body);

/// The body of the user's particle.
int body_of(const Model& model, int user_index);
/// The body of each particle, in the solver's order.
std::vector<int> bodies_of(const Model& model);

/// True if an object of the environment has "edges".
bool names_edges(const Scene& scene);
/// The number of objects of the environment that are meshes, and not exact shapes.
std::size_t mesh_count(const Model& model);

}  // namespace malha
