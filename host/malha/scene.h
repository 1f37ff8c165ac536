// SPDX-License-Identifier: Apache-2.0
// Scenes: bodies, their environment, the solver, outputs and expectations, in SI units. What a scene does not name is
// an empty vector or optional here, and costs nothing in the simulation.
#pragma once
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "malha/mesh.h"

namespace malha {

/// Maps x to translate + rotate(axis, degrees) * scale * x.
struct Transform {
  Vec3 translate{0, 0, 0};  ///< m
  Vec3 axis{0, 1, 0};       ///< direction of the rotation axis; any length except zero
  double degrees = 0;
  Vec3 scale{1, 1, 1};  ///< > 0
};

/// A mesh read from a file.
struct MeshFile {
  /// Absolute, or relative to the working directory; load_scene() resolves it against the scene's folder.
  std::string path;
  /// Vertices up to this distance apart become one point (m, before the transform). Without it those with equal
  /// positions are merged of glTF files, which have several vertices where texture coordinates part, and of the
  /// environment; no others of bodies.
  std::optional<double> weld{};
  /// The vertices of the part are numbered from 0, in the order of the file. It holds for the files of the rest shape
  /// and the animation too.
  MeshPart part{};
};
/// A grid of quads in the plane y = 0, with x in [0, size[0]] and z in [0, size[1]]. In the numbering x runs fastest.
struct GridShape {
  std::array<double, 2> size{1, 1};
  std::array<int, 2> cells{16, 16};
};
/// A subdivided icosahedron about the origin: 10 * 4^subdivisions + 2 points, triangles. Without subdivisions it is an
/// exact sphere, for the environment alone.
struct SphereShape {
  double radius = 0.5;
  std::optional<int> subdivisions = 3;
};
/// The surface of a box about the origin, of quads. Without cells it is an exact box, for the environment alone.
struct BoxShape {
  Vec3 size{1, 1, 1};
  std::optional<std::array<int, 3>> cells = std::array<int, 3>{4, 4, 4};
};
/// The surface of a bar that runs along x from x = 0, of square cells with sides of width / cells.
struct BarShape {
  double length = 1, width = 0.1;
  int cells = 2;  ///< across the width
};
/// segments + 1 points on a line, with edges and without faces.
struct ChainShape {
  Vec3 from{0, 0, 0}, to{1, 0, 0};
  int segments = 10;
};
/// A lattice of loose particles in the box [min, max]. In the numbering x runs fastest.
struct LatticeShape {
  Vec3 min{0, 0, 0}, max{1, 1, 1};
  std::array<int, 3> count{2, 2, 2};
};
/// A box about the origin, filled with cells of five tetrahedra each. In the numbering x runs fastest.
struct TetBoxShape {
  Vec3 size{1, 1, 1};
  std::array<int, 3> cells{2, 2, 2};
};
/// A mesh whose data are part of the scene. Vertices are numbered from 0; those that no face, line or tetrahedron uses
/// are left out.
struct MeshDataShape {
  std::vector<Vec3> points;  ///< m
  std::vector<Quad> faces;   ///< corners; the last one of a triangle is -1
  std::vector<Edge> lines;
  std::vector<Tetrahedron> tetrahedra;
  /// True if the mesh consists of points only, which become loose particles.
  bool loose() const { return faces.empty() && lines.empty() && tetrahedra.empty(); }
};
/// The half-space y <= 0; particles stay above it. This and the shapes below are exact, and for the environment alone.
struct PlaneShape {};
/// All points within a radius of the line between two points.
struct CapsuleShape {
  Vec3 from{0, -0.5, 0}, to{0, 0.5, 0};  ///< m, different points
  double radius = 0.25;                  ///< m
};
/// A cylinder between the centres of its two faces.
struct CylinderShape {
  Vec3 from{0, -0.5, 0}, to{0, 0.5, 0};  ///< m, different points
  double radius = 0.25;                  ///< m
};
using Shape = std::variant<MeshFile, GridShape, SphereShape, BoxShape, BarShape, ChainShape, LatticeShape, TetBoxShape,
                           MeshDataShape, PlaneShape, CapsuleShape, CylinderShape>;

/// True if the shape is exact: it has no mesh, and particles keep their distance from the surface itself.
inline bool is_exact(const Shape& shape) {
  const auto* sphere = std::get_if<SphereShape>(&shape);
  const auto* box = std::get_if<BoxShape>(&shape);
  return (sphere && !sphere->subdivisions) || (box && !box->cells) || std::holds_alternative<PlaneShape>(shape) ||
         std::holds_alternative<CapsuleShape>(shape) || std::holds_alternative<CylinderShape>(shape);
}

/// True if the particles of the shape are loose: without faces, lines and tetrahedra.
inline bool is_loose(const Shape& shape) {
  const auto* data = std::get_if<MeshDataShape>(&shape);
  return std::holds_alternative<LatticeShape>(shape) || (data && data->loose());
}

/// A rigid motion: a rotation about the origin, then a translation.
struct RigidPose {
  Vec3 translate{0, 0, 0};  ///< m
  Vec3 axis{0, 1, 0};       ///< direction of the rotation axis; any length except zero
  double degrees = 0;
};

/// A pose at a time. Between keyframes the translation is interpolated linearly, the rotation spherically.
struct Keyframe {
  double time = 0;  ///< s
  Vec3 translate{0, 0, 0};
  Vec3 axis{0, 1, 0};
  double degrees = 0;  ///< of any size: 720 is two turns from a keyframe at 0
};

/// Values at the vertices of a body's shape: a list, or what its file or a picture says of each.
struct VertexMap {
  std::vector<double> values;  ///< of each vertex, in the numbering of the file or shape; empty: one of those below
  /// "red", "green", "blue" or "alpha" of the vertex colours of the shape's file (OBJ, PLY, glTF), as it has them.
  std::string colours;
  std::string
      picture;  ///< path of a PNG or JPEG file, which the file's texture coordinates (OBJ, glTF) lay on the shape
  std::string channel = "red";          ///< of the picture, as of `colours`
  std::array<double, 2> range{{0, 1}};  ///< values where the channel is 0 and where it is 1
};

// Selectors of particles. Positions are those at the start, in world space (m).

/// The first or last row of a grid, or point of a chain.
struct RowPin {
  bool last = false;
};
/// All particles in an axis-aligned box.
struct BoxPin {
  Vec3 min{}, max{};
};
/// All particles in a sphere.
struct SpherePin {
  Vec3 center{};
  double radius = 0;
};
/// The particle nearest to a point.
struct NearestPin {
  Vec3 point{};
};
/// Particles by number.
struct ListPin {
  std::vector<int> particles;  ///< vertices, in the numbering of the file or the shape
};
/// The particles at the boundary of a mesh: those of edges with one face.
struct RimPin {
  std::optional<Vec3> nearest;  ///< m, of the closed line of the boundary that is nearest to this point; none: of all
};
/// The particles at whose vertices a map is above a bound.
struct MapPin {
  VertexMap map;
  double above = 0.5;
};
using Selector = std::variant<RowPin, BoxPin, SpherePin, NearestPin, ListPin, RimPin, MapPin>;

/// Particles that are pinned: the solver does not move them.
struct Pin {
  Selector at;
  /// Motion of the positions at the start, about the origin; the identity at time 0. Empty: the pin is at rest.
  std::vector<Keyframe> motion;
  /// s, > 0: the particles are released then, with the velocity of the pin. None: never.
  std::optional<double> release_time;

  Pin() = default;
  template <class S>
  requires std::is_constructible_v<Selector, S> Pin(S&& selector) : at(std::forward<S>(selector)) {}
};

/// Particles attached to one point each, by a spring of rest length 0 or rigidly.
struct Attachment {
  Selector at;
  std::optional<Vec3> point;           ///< m, the point of all particles; none: each one's position at the start
  std::vector<Keyframe> motion;        ///< of those points, as of a pin
  std::string environment;             ///< object in whose frame the points are fixed; "": none
  double stiffness = 1;                ///< [0, 1]; PBD. Ignored if compliance is set
  std::optional<double> compliance;    ///< m/N, >= 0; XPBD
  std::optional<double> release_time;  ///< s, > 0: the attachment ends then; none: never
};

/// Tearing: one end of an edge that is longer than (1 + strain) times its rest length is split in two (Müller et al.
/// 2006, figure 10).
struct Tear {
  double strain = 0.5;  ///< > 0
};

/// Moduli of an orthotropic material, such as woven fabric, in the units of its modulus along.
struct Orthotropy {
  double across = 0;  ///< > 0, the modulus across
  /// > 0, the modulus in shear (`membrane`) or twist (`plate`). Without it: Huber's, of a material without a softest
  /// direction between the two, see host/model/material.h.
  std::optional<double> shear{};
  /// The direction of the modulus along, of any length, in the space of the rest shape before its transform. It is
  /// projected into each triangle. None: the x axis, or the first of the y axis, the z axis and (1, 1, 1) that is
  /// perpendicular to no triangle.
  std::optional<Vec3> along{};
};

/// One constraint kind on one body. `type` is a name of the registry (kernels/constraints/constraint_registry.h),
/// "pressure" or "long_range".
struct ConstraintSpec {
  std::string type;
  std::vector<std::string> elements;      ///< of edge constraints: a subset of "edges", "shear"
  double stiffness = 1;                   ///< [0, 1]; PBD. Ignored if compliance is set
  std::optional<double> compliance;       ///< >= 0; XPBD, m/N for lengths, rad/(N m) for angles, m^5/N for volumes
  double parameter = 1;                   ///< parameter of the kind: rest_scale, poisson_ratio ...
  std::optional<double> rigidity{};       ///< > 0; N/m of surfaces, N of lines, N m of bending
  std::optional<double> young_modulus{};  ///< > 0; Pa of solids, N/m of membranes
  /// Of `membrane` and `plate`: the modulus above is that along, and the parameter contraction across over stretch
  /// along.
  std::optional<Orthotropy> orthotropy{};
  /// Factor of the stiffness at each vertex, > 0; an element has the mean of its vertices. With a modulus or a
  /// compliance > 0. Neither `pressure` nor `long_range` takes a map.
  std::optional<VertexMap> map{};
  /// Factor of `parameter` at each vertex, likewise; no factor takes the parameter out of its range. Materials of two
  /// moduli do not take it.
  std::optional<VertexMap> parameter_map{};
  /// Of `pressure`: the other bodies whose meshes, joined at seams with that of the body, enclose the volume.
  std::vector<std::string> with{};
};
/// The modulus of a material by its key in scenes: "rigidity" or "young_modulus".
inline std::optional<double>& modulus_of(ConstraintSpec& spec, const std::string& key) {
  return key == "rigidity" ? spec.rigidity : spec.young_modulus;
}

// Rest shapes apart from the start. They are in metres: the body's transform does not apply to them.

/// A file with the vertices, faces, lines and tetrahedra of the shape, in the same order, at other places.
struct RestMesh {
  std::string path;  ///< as of a MeshFile
};
/// The flat pattern of a mesh file's texture coordinates (u, v): its points are (u, v, 0) times `metres`. A corner of a
/// face has a place of its own, so that a pattern may have seams.
struct RestUv {
  double metres = 1;  ///< > 0, length of a unit of u and v
};
/// A place for each vertex of the shape, in the numbering of the file or the list.
struct RestPoints {
  std::vector<Vec3> points;  ///< m
};
using RestSpec = std::variant<RestMesh, RestUv, RestPoints>;

struct BodySpec {
  std::string name;
  Shape shape;
  Transform transform;           ///< of the mesh; part of the rest state, unless `rest` says otherwise
  std::optional<RestSpec> rest;  ///< the shape in which nothing is strained; none: that of the start
  Vec3 velocity{0, 0, 0};        ///< m/s
  Vec3 spin{0, 0, 0};            ///< rad/s, about the centre of mass
  /// kg, of the whole body. Particles share it by volume (tetrahedra), area (faces), length (lines) or equally (loose),
  /// all at rest.
  /// Exactly one of mass and density is required.
  std::optional<double> mass;
  /// kg/m^2 of faces, kg/m of lines, kg/m^3 of tetrahedra, all at rest.
  std::optional<double> density;
  /// Factor of the density at each vertex, > 0. With `mass`, whose share it multiplies, the sum stays.
  std::optional<VertexMap> density_map;
  /// Factor of Coulomb's mu of all contacts at each vertex, >= 0. Contacts of two bodies, and of a body with itself,
  /// have the mean of the factors at their two points.
  std::optional<VertexMap> friction_map;
  /// Factor of the thickness in self-collision at each vertex, > 0 and at most 1. A pair of primitives keeps the
  /// smallest thickness of its vertices.
  std::optional<VertexMap> thickness_map;
  double damping = 0;  ///< [0, 1] per step dt; 1: only rigid motion remains
  std::vector<Pin> pins;
  std::vector<Attachment> attachments;
  std::optional<Tear> tear;
  /// Name of the fabric whose density and constraints are among those here, see apply_material() of malha/fabrics.h;
  /// "": none.
  std::string material;
  std::vector<ConstraintSpec> constraints;
};

/// Calls use(map) for each map of the body's vertices.
template <class Use>
void for_each_map(BodySpec& body, const Use& use) {
  const auto use_selector = [&use](Selector& at) {
    if (auto* pin = std::get_if<MapPin>(&at)) use(pin->map);
  };
  for (std::optional<VertexMap>* map : {&body.density_map, &body.friction_map, &body.thickness_map})
    if (*map) use(**map);
  for (Pin& pin : body.pins) use_selector(pin.at);
  for (Attachment& attachment : body.attachments) use_selector(attachment.at);
  for (ConstraintSpec& spec : body.constraints)
    for (std::optional<VertexMap>* map : {&spec.map, &spec.parameter_map})
      if (*map) use(**map);
}

/// What a seam joins, on one of its two sides.
struct SeamEnd {
  std::string body;
  std::optional<Selector> at;  ///< particles; none: with `pairs`, or the body's surface
  bool surface = false;        ///< of `to`: the points of the surface that are closest at the start
};

/// A seam between two bodies, or two parts of one: particles whose gap at the start closes and which then are at one
/// place. It turns freely, as a hinge does.
struct SeamSpec {
  SeamEnd from, to;
  /// m, > 0: each particle of `from` is sewn to the nearest of `to` at the start, at most so far away; where both have
  /// as many, each to one of its own. None: with `pairs`.
  std::optional<double> within;
  std::vector<Edge> pairs;  ///< vertices of `from` and of `to`, in the numbering of the files or shapes
  double closing = 0;       ///< s, in which the gap shrinks to 0, at a constant rate; at least a step
  double compliance = 0;    ///< m/N, >= 0
};

/// Sides of an environment mesh: a closed solid, a sheet that acts on the side of its normals, a sheet that acts on
/// both.
enum class Sides { Solid, OneSided, TwoSided };

/// Vertices of an environment object that move over time: those of a clip of a glTF file, of frames, or set by the
/// program.
struct AnimationSpec {
  std::string file;                         ///< .glb or .gltf with the vertices of the shape; "": the shape's own file
  std::variant<int, std::string> clip = 0;  ///< of that file: its number or its name
  /// Instead of a clip: a .pc2 file with the vertices of the shape, or OBJ or PLY files with its vertices and faces,
  /// one for each frame, as a folder or a pattern with a '*' for the number of the frame; "": none.
  std::string frames;
  std::optional<double> frames_per_second;  ///< > 0; of frames
  double speed = 1;                         ///< > 0, s of the animation in a second of the simulation
  double offset = 0;                        ///< s of the animation at time 0
  bool loop = false;                        ///< false: the first pose before the animation, the last one after it
  bool from_code = false;                   ///< the program sets the vertices; nothing else is set then
};

struct EnvironmentSpec {
  std::string name;
  Shape shape;  ///< exact, or with faces; of a glTF file with an animation its pose at time 0
  Transform transform;
  Sides sides = Sides::Solid;  ///< of a mesh; exact shapes are solid
  bool push_out = false;       ///< moves bodies that start inside of a solid out of it; otherwise they are refused
  /// m, distance that particles keep from the surface; 0: default_thickness() of host/model/unlikely.h.
  double thickness = 0.005;
  double friction = 0;     ///< Coulomb's mu, >= 0
  double restitution = 0;  ///< [0, 1]
  bool edges = false;      ///< detects contacts of its edges and corners too, not only of its surface with particles
  std::vector<Keyframe> motion;            ///< empty: the object is at rest
  std::optional<AnimationSpec> animation;  ///< of the vertices, before the transform and the motion; none: it is rigid
};

/// Air, which may move. `drag` acts on particles, `density` on faces; a scene has one of them or both.
struct Wind {
  Vec3 velocity{0, 0, 0};         ///< m/s
  double drag = 0;                ///< N s/m per particle, >= 0
  double density = 0;             ///< kg/m^3 of air, >= 0
  double drag_coefficient = 1.2;  ///< of faces, >= 0, see kernels/forces/air.h
  double lift_coefficient = 1.2;  ///< >= 0
};

/// A scene falls asleep when no particle of it was faster than `speed` for `after` seconds.
struct Sleep {
  double speed = 0.01;  ///< m/s, > 0
  double after = 0.5;   ///< s, >= 0
};

/// Collisions of bodies with themselves and with each other.
struct SelfCollision {
  double thickness = 0;             ///< m, > 0: distance that the surfaces keep
  double friction = 0;              ///< Coulomb's mu, >= 0
  std::vector<std::string> bodies;  ///< names; empty: all
  /// Primitives that cross at the start collide once they have separated. Otherwise the scene is refused.
  bool ignores_crossings = false;
};

struct Camera {
  Vec3 eye{3, 2, 3}, target{0, 0, 0};
  double fov_degrees = 40;  ///< vertical
};

struct PictureSpec {
  std::array<int, 2> size{1280, 720};
  std::optional<Camera> camera;  ///< none: chosen so that the bodies at the start fit
};

/// One HTML file that replays the run in a browser.
struct PageSpec {
  double max_megabytes = 20;  ///< largest size; a page of one frame may exceed it
};

/// Formats of frames.
inline const std::vector<std::string> kFrameFormats{"vtp", "pc2", "ply", "obj", "glb", "usda"};

struct OutputSpec {
  int every = 0;                     ///< steps between frames; 0: none
  std::vector<std::string> formats;  ///< of kFrameFormats
  int picture_every = 0;             ///< steps between pictures; 0: with `picture`, only one at the end
  std::optional<PictureSpec> picture;
  std::optional<PageSpec> page;
  std::optional<int> checkpoint_every;  ///< steps between checkpoints; 0: only at the end; none: see RunOptions
};

/// Bounds of a number. A single number is the upper bound.
struct Range {
  std::optional<double> at_least, at_most;
  Range() = default;
  Range(double upper) : at_most(upper) {}
  explicit operator bool() const { return at_least || at_most; }
  friend bool operator==(const Range&, const Range&) = default;
};

/// The axis-aligned box (m) in which all particles of a body must lie.
struct ExpectOfBody {
  std::string name;
  Vec3 bounds_min, bounds_max;
};

/// Conditions that must be met at the end of the run. What is absent is not checked.
struct Expect {
  Range max_strain;                                          ///< largest |l - l0| / l0 over the distance constraints
  Range rms_strain;                                          ///< root mean square of the same
  Range max_penetration;                                     ///< m, depth below the surface of an environment object
  Range max_crossings;                                       ///< edges that cross triangles of colliding bodies
  std::optional<double> energy_not_above, energy_not_below;  ///< J
  Range max_speed;                                           ///< m/s
  std::optional<Vec3> bounds_min, bounds_max;                ///< m, box in which every particle must lie
  std::vector<ExpectOfBody> bodies;                          ///< boxes of single bodies
  std::optional<std::array<double, 2>> volume_ratio;  ///< volume / rest volume of bodies with pressure or tetrahedra
  Range max_seam_gap;                                 ///< m, largest distance of particles that a seam joins
  Range inverted_tetrahedra;                          ///< number of tetrahedra with negative volume
};

enum class Precision { Float, Double };

enum class FilterKind { Auto, Dense, Sparse };
/// This says how PBD solves bending of a given rigidity or compliance. Auto filters what projections leave too soft.
enum class BendingMethod { Auto, Projected, Filtered };
enum class Storage { Float, Double, Int16 };
enum class Corrector { Inertia, Paper, Off };

/// Settings of Desbrun's method.
struct DesbrunSpec {
  double spring_constant = 1e4;  ///< N/m, > 0; times the stiffness of a constraint without compliance
  FilterKind filter = FilterKind::Auto;
  std::optional<Storage> storage;      ///< of the filter's entries; none: as precision. Int16: dense filter only
  bool filter_external_forces = true;  ///< false: gravity and wind are not filtered, as in the paper
  std::optional<Corrector> corrector;  ///< of the torque on free bodies; none: see corrects()
  int refinement_iterations = 0;  ///< >= 0, further solves per substep: 0: the paper's method; many: backward Euler
  /// Over-elongation / length of the distance limits at which their iterations end; none: all iterations are run.
  std::optional<double> tolerance;
  /// s for the distance limits in each substep; results then depend on the clock.
  std::optional<double> time_budget;

  /// The corrector in use: by default the inertia's, or none if the solution is refined.
  Corrector corrects() const {
    return corrector.value_or(refinement_iterations > 0 ? Corrector::Off : Corrector::Inertia);
  }
};

inline constexpr int kAutoLevels = -1, kMaxLevels = 30;
/// Largest interval of levels, in substeps. After more substeps of sweeps alone, levels correct the sag too hard.
inline constexpr int kMaxLevelsInterval = 3;

struct SolverSpec {
  std::string type = "pbd";  ///< or "desbrun"
  double dt = 1.0 / 60;      ///< s, > 0
  int substeps = 10;         ///< >= 1
  int iterations = 1;        ///< >= 1, per substep
  Precision precision = Precision::Float;
  int levels = kAutoLevels;  ///< pbd: largest number of levels; 0: none; kAutoLevels: where they help
  int levels_interval = 0;   ///< substeps; 0: chosen by levels_interval() (host/model/levels.h)
  BendingMethod bending = BendingMethod::Auto;  ///< pbd
  bool keeps_momenta = false;      ///< "corrector" of pbd: restores the momenta of free bodies after projections
  bool stiffness_of_step = false;  ///< PBD's k is that of a step of one substep, for any number of substeps
  DesbrunSpec desbrun;
};

struct Scene {
  std::string file;  ///< name of the file in messages; may be empty
  std::string name;
  SolverSpec solver;
  Vec3 gravity{0, 0, 0};  ///< m/s^2
  std::optional<Wind> wind;
  std::optional<Sleep> sleep;                ///< none: the scene never sleeps
  std::vector<BodySpec> bodies;              ///< at least one
  std::vector<SeamSpec> seams;               ///< joints of bodies
  std::vector<EnvironmentSpec> environment;  ///< if it has no mesh, Embree is not used
  std::optional<SelfCollision> self_collision;
  double duration = 1;  ///< s
  OutputSpec outputs;
  Expect expect;
};

/// Reads and checks a scene file; "-" is standard input. Mesh paths are resolved against the scene's folder, or, if the
/// scene is a symbolic link and the mesh does not exist there, against the folder of its target. Meshes are not read.
/// Throws InputError, which names the file, the line and column or JSON pointer, what was found and what is allowed.
Scene load_scene(const std::string& path);

/// load_scene() for a text. `file` is its name in messages; relative mesh paths are resolved against `folder`.
Scene parse_scene(const std::string& text, const std::string& file, const std::string& folder);

/// The scene as JSON with every value written out, which parse_scene() reads back. Mesh paths are relative to `folder`,
/// in which the text will be stored; if it is empty they are absolute.
std::string to_json(const Scene& scene, const std::string& folder = "");

}  // namespace malha
