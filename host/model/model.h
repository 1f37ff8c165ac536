// SPDX-License-Identifier: Apache-2.0
// The model of a scene: particles in the solver's order, constraints, boundary conditions and patches, independent of
// precision and executor.
#pragma once
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "host/animation/animation.h"
#include "host/mesh/rest_shape.h"
#include "host/model/exact_shape.h"
#include "host/model/ordering/patches.h"
#include "host/model/pins.h"
#include "kernels/parallel/compute.h"
#include "kernels/projection/constraint_kind.h"
#include "kernels/projection/rest.h"
#include "malha/scene.h"

namespace malha {

class Animation;

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
  // Rest positions of the corners (m), arity for each constraint; empty: the start positions of the particles.
  std::vector<Vec3> rest_corners{};
  bool pressed = false;                      // true if its bodies have a pressure
  std::optional<Orthotropic> orthotropic{};  // of kinds of orthotropic material, whose compliance is that along
  double per_closing = 0;                    // 1/s, of seams: the rate at which their gaps close
  std::vector<double> parameters{};          // of each constraint, as by a map; empty: `parameter`
  int count() const { return static_cast<int>(particles.size()) / arity; }
  double softness_of(int c) const { return softness.empty() ? 1 : softness[c]; }
  /// The compliance of constraint c; 0 if the set has none.
  double alpha(int c) const { return compliance.value_or(0) * softness_of(c); }
};

/// The constants from which the rest values of a set of this kind are computed.
template <class Kind>
Materials<Kind> materials_of(const ConstraintSet& set) {
  if constexpr (std::is_same_v<Material<Kind>, Orthotropic>)
    return {*set.orthotropic};
  else
    return {set.parameter, set.parameters.empty() ? nullptr : set.parameters.data()};
}
/// The constants of constraint c of the set.
template <class Kind>
Material<Kind> material_of(const ConstraintSet& set, int c) {
  return materials_of<Kind>(set).of(c);
}

/// Pressure of a closed body, or of bodies whose meshes are closed where seams join them.
struct PressureSet {
  double volume_ratio = 1, stiffness = 1;  // target volume over rest volume
  std::optional<double> compliance;        // m^5/N
  std::vector<int> particles;              // all particles of the closed mesh
  std::vector<Triangle> triangles;         // of the closed mesh
  // A particle of the closed mesh and another one that a seam holds at its place, which moves with it.
  std::vector<Edge> followers{};
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
  // The rest mesh of each body in the form of RestShape (host/mesh/rest_shape.h), without points where the body is at
  // rest at the start; empty if all are.
  std::vector<Mesh> rest;
};

/// Vertices of an object that the program sets: they move from one place to the next in a step, and rest otherwise.
struct SetVertices {
  std::vector<Vec3> from, to;  // m, in the object's frame; empty: none were set yet
  double start = 0, end = 0;   // s
};

/// An object of the environment.
struct EnvironmentMesh {
  EnvironmentSpec spec;
  Mesh mesh;  // after the transform of the spec; of an animation at time 0; of an exact shape for drawing alone
  std::optional<PlacedShape> exact{};            // none: particles touch the mesh
  std::shared_ptr<const Animation> animation{};  // of the mesh's points; null: none, or from code
  SetVertices set{};                             // of an animation from code
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
  std::vector<int> user_index;  // the user's index of each particle of the solver
  std::vector<Vec3> x, v;       // m, m/s
  std::vector<double> w;        // 1/kg, 0 where pinned permanently
  std::vector<double> mass;     // kg, including pinned particles
  // Factors of the friction and of the thickness in self-collision at each particle; empty: no body has a map of them.
  std::vector<double> friction_factor, thickness_factor;
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
  // m, the place of each particle at rest; empty if no body has a rest mesh. Of one with seams, or of texture
  // coordinates, it is that of the start.
  std::vector<Vec3> rest_x;
  int count() const { return static_cast<int>(x.size()); }
  const std::vector<Vec3>& at_rest() const { return rest_x.empty() ? x : rest_x; }
  /// The same of a pressure: that of several bodies, whose rest shapes lie anywhere, refers to the start.
  const std::vector<Vec3>& at_rest(const PressureSet& set) const { return set.followers.empty() ? at_rest() : x; }
};

/// The rest positions of a set's constraints, for rest_values() (kernels/projection/rest.h).
inline RestPositions<Vec3> rest_positions(const Model& model, const ConstraintSet& set) {
  return {model.x.data(), set.particles.data(), set.rest_corners.empty() ? nullptr : set.rest_corners.data()};
}

/// The rest shape of a body, whose mesh is body_mesh() of it.
inline RestShape rest_shape(const RenderMesh& render_mesh, std::size_t body, const Mesh& mesh) {
  const bool has_rest = !render_mesh.rest.empty() && !render_mesh.rest[body].points.empty();
  return {mesh, has_rest ? &render_mesh.rest[body] : nullptr};
}

/// Builds the model of a scene: reads or generates its meshes, checks them, and lays the model out. The result is the
/// same for any number of threads. Throws InputError.
Model build_model(const Scene& scene, const OpenMP& threads = 1, const PatchBounds& bounds = {});

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

/// Tells whether an object is a mesh that does not deform.
inline bool is_rigid_mesh(const EnvironmentMesh& object) { return !object.exact && !object.spec.animation; }
/// Numbers of objects of the environment that are such meshes, and exact shapes; the others are meshes that deform.
std::size_t mesh_count(const Model& model);
std::size_t shape_count(const Model& model);

/// True if an object of the environment has "edges".
bool names_edges(const Scene& scene);
/// Tells whether the final guards of bodies, edges and kinds of environment objects move particles in turns.
bool guards_run_in_turns(const Model& model);

}  // namespace malha
