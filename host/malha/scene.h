// SPDX-License-Identifier: Apache-2.0
// A scene: what is simulated, with what, and what is expected of it. SI units throughout.
// What a scene does not name is absent here too (empty vector or optional), and costs nothing later.
#pragma once
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "malha/mesh.h"

namespace malha {

/// x -> translate + rotate(axis, degrees) * scale * x.
struct Transform {
  Vec3 translate{0, 0, 0};  ///< m
  Vec3 axis{0, 1, 0};       ///< any length but zero
  double degrees = 0;
  Vec3 scale{1, 1, 1};  ///< > 0
};

// Shapes. Generated ones are listed in the order in which their particles are numbered.
struct MeshFile {
  std::string
      path;  ///< absolute, or relative to the working directory: load_scene resolves it against the scene's folder
  std::optional<double> weld{};  ///< m in the file: vertices no farther apart become one; none: of bodies none do
};
struct GridShape {  ///< in the plane y = 0, x in [0, size[0]], z in [0, size[1]]; x runs fastest; quads
  std::array<double, 2> size{1, 1};
  std::array<int, 2> cells{16, 16};
};
struct SphereShape {  ///< subdivided icosahedron about the origin: 10 * 4^subdivisions + 2 points, triangles
  double radius = 0.5;
  int subdivisions = 3;
};
struct BoxShape {  ///< closed surface about the origin, quads
  Vec3 size{1, 1, 1};
  std::array<int, 3> cells{4, 4, 4};
};
struct BarShape {  ///< a box whose long side lies along x, from x = 0; square cells of side width / cells
  double length = 1, width = 0.1;
  int cells = 2;  ///< across the width
};
struct ChainShape {  ///< segments + 1 points on a line, edges without faces
  Vec3 from{0, 0, 0}, to{1, 0, 0};
  int segments = 10;
};
struct LatticeShape {  ///< a lattice of loose particles that fills the box [min, max]; x runs fastest
  Vec3 min{0, 0, 0}, max{1, 1, 1};
  std::array<int, 3> count{2, 2, 2};
};
struct TetBoxShape {  ///< a box about the origin, filled with cells of five tetrahedra each; x runs fastest
  Vec3 size{1, 1, 1};
  std::array<int, 3> cells{2, 2, 2};
};
struct MeshDataShape {       ///< a mesh given in place; vertices count from 0, and those that nothing uses are left out
  std::vector<Vec3> points;  ///< m
  std::vector<Quad> faces;   ///< a triangle has -1 in its last place
  std::vector<Edge> lines;
  std::vector<Tetrahedron> tetrahedra;
  /// Without any of these its particles are loose.
  bool loose() const { return faces.empty() && lines.empty() && tetrahedra.empty(); }
};
using Shape = std::variant<MeshFile, GridShape, SphereShape, BoxShape, BarShape, ChainShape, LatticeShape, TetBoxShape,
                           MeshDataShape>;

inline bool is_loose(const Shape& shape) {
  const auto* listed = std::get_if<MeshDataShape>(&shape);
  return std::holds_alternative<LatticeShape>(shape) || (listed && listed->loose());
}

/// A pose at a time; motion between keyframes is linear in translate and spherical-linear in rotation.
struct Keyframe {
  double time = 0;  ///< s
  Vec3 translate{0, 0, 0};
  Vec3 axis{0, 1, 0};
  double degrees = 0;  ///< any size: 720 is two turns from the keyframe at 0
};

// Which particles are meant. Places are in the world, at the start.
struct RowPin {
  bool last = false;
};  ///< grids and chains only: the first or last row (point) of the shape
struct BoxPin {
  Vec3 min{}, max{};
};
struct SpherePin {
  Vec3 center{};
  double radius = 0;
};
struct NearestPin {
  Vec3 point{};
};
struct ListPin {
  std::vector<int> particles;  ///< vertices, as the file or the shape counts them
};
using Selector = std::variant<RowPin, BoxPin, SpherePin, NearestPin, ListPin>;

/// Particles that the solver does not move.
struct Pin {
  Selector at;
  std::vector<Keyframe>
      motion;  ///< of the places at the start, about the origin; at time 0 it moves nothing. Empty: rest
  std::optional<double> release_time;  ///< s, > 0: released then, with the velocity that the pin has; none: never

  Pin() = default;
  template <class S>
  requires std::is_constructible_v<Selector, S> Pin(S&& selector) : at(std::forward<S>(selector)) {}
};

/// Particles tied to a point each by a spring of rest length 0, or rigidly.
struct Attachment {
  Selector at;
  std::optional<Vec3> point;           ///< all to this one (m); none: each to its own place at the start
  std::vector<Keyframe> motion;        ///< of those points, as for pins
  std::string environment;             ///< or each to its own place in the frame of this mesh; "": not to a mesh
  double stiffness = 1;                ///< [0, 1]; PBD. Ignored where compliance is set
  std::optional<double> compliance;    ///< m/N, >= 0; XPBD
  std::optional<double> release_time;  ///< s, > 0: ends then
};

/// Where an edge is longer than (1 + strain) times its length at rest, one of its ends is split in two (Müller et al.
/// 2006, figure 10).
struct Tear {
  double strain = 0.5;  ///< > 0
};

/// One constraint kind on one body. `type` is a name of the registry (kernels/constraints/constraint_registry.h),
/// "pressure" or "long_range".
struct ConstraintSpec {
  std::string type;
  std::vector<std::string> elements;      ///< elements; for edge constraints a subset of "edges", "shear"
  double stiffness = 1;                   ///< [0, 1]; PBD. Ignored where compliance is set
  std::optional<double> compliance;       ///< >= 0; XPBD, m/N for lengths, rad/(N m) for angles, m^5/N for volumes
  double parameter = 1;                   ///< the kind's own number, by its own name (rest_scale, poisson_ratio ...)
  std::optional<double> rigidity{};       ///< > 0; of the material: N/m of surfaces, N of lines, N m of bending
  std::optional<double> young_modulus{};  ///< > 0, Pa of solids, N/m of membranes; of kinds without the other three
};
/// A material's modulus by its key in scenes: "rigidity" or "young_modulus".
inline std::optional<double>& modulus_of(ConstraintSpec& spec, const std::string& key) {
  return key == "rigidity" ? spec.rigidity : spec.young_modulus;
}

struct BodySpec {
  std::string name;
  Shape shape;
  Transform transform;         ///< shapes the rest state
  Vec3 velocity{0, 0, 0};      ///< m/s
  Vec3 spin{0, 0, 0};          ///< rad/s, about the centre of mass
  std::optional<double> mass;  ///< kg, the whole body, shared by volume (tetrahedra), area (faces), length (lines) or
                               ///< equally (loose)
  std::optional<double> density;  ///< kg/m^2 of surface, kg/m of lines, kg/m^3 of tetrahedra; one of both is required
  double damping = 0;             ///< [0, 1] per step dt; 1 = rigid motion
  std::vector<Pin> pins;
  std::vector<Attachment> attachments;
  std::optional<Tear> tear;
  std::vector<ConstraintSpec> constraints;
};

enum class Sides { Solid, OneSided, TwoSided };  ///< closed mesh; sheet seen from its normals; sheet

struct EnvironmentSpec {
  std::string name;
  Shape shape;  ///< with faces
  Transform transform;
  Sides sides = Sides::Solid;
  bool push_out = false;         ///< solids: bodies that start inside are moved out; otherwise they are refused
  double thickness = 0.005;      ///< m: particles are kept this far from the surface; 0: host/model/unlikely.h
  double friction = 0;           ///< Coulomb's mu, >= 0
  double restitution = 0;        ///< [0, 1]
  bool edges = false;            ///< whether its edges and corners touch bodies too, beside its faces their particles
  std::vector<Keyframe> motion;  ///< empty: does not move
};

/// Moving air, or air at rest. `drag` acts on particles, `density` on faces: a scene names one of them or both.
struct Wind {
  Vec3 velocity{0, 0, 0};         ///< m/s
  double drag = 0;                ///< N s/m per particle, >= 0
  double density = 0;             ///< kg/m^3 of air, >= 0
  double drag_coefficient = 1.2;  ///< of a face, >= 0, see kernels/forces/air.h
  double lift_coefficient = 1.2;  ///< >= 0
};

/// When a scene falls asleep: no particle of it has been faster than `speed` for `after` seconds.
struct Sleep {
  double speed = 0.01;  ///< m/s, > 0
  double after = 0.5;   ///< s, >= 0
};

/// Bodies that collide with themselves and with each other.
struct SelfCollision {
  double thickness = 0;             ///< m, > 0: how far apart their surfaces are kept
  double friction = 0;              ///< Coulomb's mu, >= 0
  std::vector<std::string> bodies;  ///< names; empty: all
  bool ignores_crossings = false;  ///< whether what crosses at the start collides only once it has parted; else refused
};

struct Camera {
  Vec3 eye{3, 2, 3}, target{0, 0, 0};
  double fov_degrees = 40;  ///< vertical
};

struct PictureSpec {
  std::array<int, 2> size{1280, 720};
  std::optional<Camera> camera;  ///< none: framed so that the bodies at the start fit
};

/// One HTML file that replays the run in a browser.
struct PageSpec {
  double max_megabytes = 20;  ///< at most; with one frame it may be more
};

/// What frames may be written as.
inline const std::vector<std::string> kFrameFormats{"vtp", "pc2", "ply", "obj", "glb"};

struct OutputSpec {
  int every = 0;                     ///< steps between frames; 0: none
  std::vector<std::string> formats;  ///< of kFrameFormats
  int picture_every = 0;             ///< steps between pictures; 0: only what `picture` says at the end
  std::optional<PictureSpec> picture;
  std::optional<PageSpec> page;
  std::optional<int> checkpoint_every;  ///< steps between checkpoints; 0: only that of the end; none: see RunOptions
};

/// What a number must be. A number alone is the most that it may be.
struct Range {
  std::optional<double> at_least, at_most;
  Range() = default;
  Range(double most) : at_most(most) {}
  explicit operator bool() const { return at_least || at_most; }
  friend bool operator==(const Range&, const Range&) = default;
};

/// The box that the particles of one body must lie in.
struct ExpectOfBody {
  std::string name;
  Vec3 bounds_min, bounds_max;
};

/// What must hold at the end of the whole run. Absent: not looked at.
struct Expect {
  Range max_strain;                                          ///< largest |l - l0| / l0 over the distance constraints
  Range rms_strain;                                          ///< same, root mean square
  Range max_penetration;                                     ///< m below an environment surface
  Range max_crossings;                                       ///< of edges with triangles, of bodies that collide
  std::optional<double> energy_not_above, energy_not_below;  ///< J
  Range max_speed;                                           ///< m/s
  std::optional<Vec3> bounds_min, bounds_max;                ///< every particle lies in this box
  std::vector<ExpectOfBody> bodies;                          ///< those of these bodies in theirs
  std::optional<std::array<double, 2>> volume_ratio;  ///< volume / rest volume of bodies with pressure or tetrahedra
  Range inverted_tetrahedra;                          ///< their number: of negative volume
};

enum class Precision { Float, Double };

enum class FilterKind { Auto, Dense, Sparse };
enum class Storage { Float, Double, Int16 };
enum class Corrector { Inertia, Paper, Off };

/// What only Desbrun's method has.
struct DesbrunSpec {
  double spring_constant = 1e4;  ///< N/m, > 0, of springs whose constraint has no compliance: times its stiffness
  FilterKind filter = FilterKind::Auto;
  std::optional<Storage> storage;      ///< of the filter's numbers; none: the precision's. Int16: dense only
  bool filter_external_forces = true;  ///< false: gravity and wind go round the filter, as in the paper
  std::optional<Corrector> corrector;  ///< of the torque on free bodies; none: inertia, or off where those are refined
  int refinement_iterations = 0;       ///< >= 0, further solves a substep: 0 is the paper's method, many backward Euler
  std::optional<double> tolerance;  ///< of the distance limits, over-elongation / length; none: all iterations are run
  std::optional<double> time_budget;  ///< s a substep for them; results then depend on the clock

  Corrector corrects() const {
    return corrector.value_or(refinement_iterations > 0 ? Corrector::Off : Corrector::Inertia);
  }
};

inline constexpr int kAutoLevels = -1, kMostLevels = 30;
inline constexpr int kSeldomLevels = 3;  ///< substeps: what sweeps alone let go in more, levels pull back too hard

struct SolverSpec {
  std::string type = "pbd";  ///< or "desbrun"
  double dt = 1.0 / 60;      ///< s, > 0
  int substeps = 10;         ///< >= 1
  int iterations = 1;        ///< >= 1, per substep
  Precision precision = Precision::Float;
  int levels = kAutoLevels;        ///< of pbd: the most; 0: none; kAutoLevels: where they help
  int levels_interval = 0;         ///< substeps; 0: by what drives bodies (host/model/levels.h)
  bool keeps_momenta = false;      ///< "corrector" of pbd: free bodies get back what projections take of their momenta
  bool stiffness_of_step = false;  ///< PBD's k makes the spring of a step of one substep, whatever the substeps
  DesbrunSpec desbrun;
};

struct Scene {
  std::string file;  ///< where it was read from, for messages; may be empty
  std::string name;
  SolverSpec solver;
  Vec3 gravity{0, 0, 0};  ///< m/s^2
  std::optional<Wind> wind;
  std::optional<Sleep> sleep;                ///< none: never
  std::vector<BodySpec> bodies;              ///< at least one
  std::vector<EnvironmentSpec> environment;  ///< empty: no Embree
  std::optional<SelfCollision> self_collision;
  double duration = 1;  ///< s
  OutputSpec outputs;
  Expect expect;
};

/// Reads and checks a scene file. Throws InputError naming the file, the line and column or JSON pointer, what was
/// found and what is allowed. Mesh paths come back resolved against the scene's folder; where the scene is a symbolic
/// link and a mesh is not there, against that of its target. "-" is standard input. Meshes are not read here.
Scene load_scene(const std::string& path);

/// The same from text; `file` names it in messages, `folder` is where relative mesh paths start.
Scene parse_scene(const std::string& text, const std::string& file, const std::string& folder);

/// The scene as JSON that parse_scene takes back (every value spelled out).
std::string to_json(const Scene& scene);

}  // namespace malha
