// SPDX-License-Identifier: Apache-2.0
// With self-collision on, no particle is ever inside a solid of the environment, at rest or moving, and no surface
// intersects another: the last displacement of a substep is checked against both. This file tells the inside by a
// winding number of its own.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "host/measure/solver_stats.h"
#include "host/mesh/generate.h"
#include "host/mesh/topology.h"
#include "host/solver/solver.h"
#include "tests/mesh/irregular_sheet.h"
#include "tests/numbers.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

using Place = Vector3<double>;

Place place_of(const Vec3& a) { return {a[0], a[1], a[2]}; }
Place unit_of(const Place& a) { return a * (1 / std::sqrt(dot(a, a))); }

/// The rotation by Rodrigues' formula.
Place turned(const Place& a, const Place& axis, double degrees) {
  const Place k = unit_of(axis);
  const double t = degrees * kPi / 180;
  return a * std::cos(t) + cross(k, a) * std::sin(t) + k * (dot(k, a) * (1 - std::cos(t)));
}

/// A solid as triangles in world space at the start, and its motion: a velocity, and a spin about an axis through its
/// origin, applied first.
struct TrackedSolid {
  std::vector<Place> points;
  std::vector<Triangle> triangles;
  Place velocity{0, 0, 0}, axis{0, 1, 0};
  double spin = 0, release_time = INFINITY;  // degrees/s; s: where it stops

  Place at_start(const Place& world, double time) const {
    const double t = std::min(time, release_time);
    return turned(world - velocity * t, axis, -spin * t);
  }
  /// The winding number of the surface around a point (van Oosterom, Strackee 1983).
  double winding(const Place& p) const {
    double angle = 0;
    for (const Triangle& t : triangles) {
      const Place a = points[t[0]] - p, b = points[t[1]] - p, c = points[t[2]] - p;
      const double la = std::sqrt(dot(a, a)), lb = std::sqrt(dot(b, b)), lc = std::sqrt(dot(c, c));
      angle += 2 * std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
    }
    return angle / (4 * kPi);
  }
  double distance(const Place& p) const {
    double least = INFINITY;
    for (const Triangle& t : triangles)
      least = std::min(least, to_triangle(p, points[t[0]], points[t[1]], points[t[2]]));
    return least;
  }
  /// The depth of a point inside the solid at a time; 0 outside.
  double depth(const Place& world, double time) const {
    const Place p = at_start(world, time);
    return winding(p) > 0.5 ? distance(p) : 0;
  }

 private:
  static double to_segment(const Place& p, const Place& a, const Place& b) {
    const Place ab = b - a;
    const double t = std::clamp(dot(p - a, ab) / dot(ab, ab), 0.0, 1.0);
    const Place d = p - a - ab * t;
    return std::sqrt(dot(d, d));
  }
  static double to_triangle(const Place& p, const Place& a, const Place& b, const Place& c) {
    const Place n = unit_of(cross(b - a, c - a));
    const bool above =
        dot(cross(b - a, p - a), n) >= 0 && dot(cross(c - b, p - b), n) >= 0 && dot(cross(a - c, p - c), n) >= 0;
    if (above) return std::abs(dot(p - a, n));
    return std::min({to_segment(p, a, b), to_segment(p, b, c), to_segment(p, c, a)});
  }
};

/// A solid of the environment with its triangles.
struct PlacedSolid {
  EnvironmentSpec spec;
  TrackedSolid tracked;
};

PlacedSolid placed(const std::string& name, const Mesh& mesh, const Place& axis, double degrees, const Place& at) {
  PlacedSolid solid;
  MeshDataShape shape;
  for (const Vec3& x : mesh.points) {
    const Place world = turned(place_of(x), axis, degrees) + at;
    solid.tracked.points.push_back(world);
    shape.points.push_back({world.x, world.y, world.z});
  }
  solid.tracked.triangles = triangles(mesh);
  for (const Triangle& t : solid.tracked.triangles) shape.faces.push_back({t[0], t[1], t[2], -1});
  solid.spec.name = name, solid.spec.shape = shape;
  return solid;
}

/// Moves the object so until a time (s); it rests then.
void set_moving(PlacedSolid& solid, const Place& velocity, const Place& axis, double spin, double release_time) {
  solid.tracked.velocity = velocity, solid.tracked.axis = axis, solid.tracked.spin = spin,
  solid.tracked.release_time = release_time;
  Keyframe end;
  end.time = release_time,
  end.translate = {velocity.x * release_time, velocity.y * release_time, velocity.z * release_time};
  end.axis = {axis.x, axis.y, axis.z}, end.degrees = spin * release_time;
  solid.spec.motion = {Keyframe{}, end};
}

/// A prism over an L-shaped polygon, as high as wide.
Mesh l_prism(double side) {
  const double s = side / 2, corner[6][2] = {{-s, -s}, {s, -s}, {s, 0}, {0, 0}, {0, s}, {-s, s}};
  Mesh mesh;
  for (const double z : {-s, s})
    for (const auto& c : corner) mesh.points.push_back({c[0], c[1], z});
  for (const Triangle t : {Triangle{0, 1, 2}, Triangle{0, 2, 3}, Triangle{0, 3, 4}, Triangle{0, 4, 5}}) {
    mesh.faces.push_back({t[0], t[2], t[1], -1});
    mesh.faces.push_back({t[0] + 6, t[1] + 6, t[2] + 6, -1});
  }
  for (int k = 0; k < 6; ++k) mesh.faces.push_back({k, (k + 1) % 6, (k + 1) % 6 + 6, k + 6});
  return mesh;
}

struct InsideScene {
  Scene scene;
  std::vector<PlacedSolid> solids;
  std::string what;
};

class InsideScenes {
 public:
  explicit InsideScenes(const TemporaryFolder& folder) : folder_(folder) {}

  InsideScene make(unsigned seed) {
    Random random(seed);
    InsideScene made;
    const double speed = 0.5 * std::pow(60, random(0, 1));
    constexpr int substeps[] = {1, 2, 3, 5, 10, 40};
    Scene& scene = made.scene;
    scene = scene_of({}, random() < 0.5 ? kEarth : Vec3{}, std::min(1.0 / 60, 0.2 / speed), substeps[random.below(6)],
                     random() < 0 ? Precision::Float : Precision::Double);
    scene.self_collision = SelfCollision{5e-4 * std::pow(40, random(0, 1)), std::max(0.0, random()), {}};
    scene.solver.iterations = 1 + random.below(2);
    if (random() < -0.3) scene.solver.type = "desbrun";
    const int kind = random.below(4);
    const double falls = kind == 0 || kind == 3 ? speed : 0;
    if (kind == 0)
      made.what = "falls", block(scene, random, falls);
    else if (kind == 1)
      made.what = "hit", sheets(scene, random, 1);
    else if (kind == 2)
      made.what = "hit on a ground", sheets(scene, random, 2);
    else
      made.what = "sheets fall", sheets(scene, random, 2);
    if (kind == 3)
      for (BodySpec& body : scene.bodies) body.velocity = {0, -falls, 0};
    if (kind != 1) add(made, ground(random));
    if (kind == 0 || kind == 3) add(made, obstacle(random, {random(-0.3, 0.3), -0.35, random(-0.3, 0.3)}));
    if (kind == 1 || kind == 2) {
      PlacedSolid hammer = obstacle(random, {random(-0.2, 0.2), kind == 1 ? 0.6 : 0.8, random(-0.2, 0.2)});
      const double way = kind == 1 ? 3 : random(0.5, 0.8);
      const Place velocity{random(-0.2, 0.2) * speed, -speed, random(-0.2, 0.2) * speed};
      set_moving(hammer, velocity, random.direction(), kind == 1 ? random(-90, 90) * speed : 0,
                 std::max(way / speed, 2 * scene.solver.dt));
      add(made, hammer);
    }
    made.what += ", " + std::to_string(speed) + " m/s, " + std::to_string(scene.solver.substeps) + " substeps, " +
                 scene.solver.type;
    return made;
  }

 private:
  static void add(InsideScene& made, PlacedSolid solid) {
    solid.spec.name = "solid " + std::to_string(made.solids.size());
    made.scene.environment.push_back(solid.spec), made.solids.push_back(solid);
  }
  static PlacedSolid obstacle(Random& random, const Place& at) {
    const int form = random.below(3);
    const double side = random(0.15, 0.4);
    const Mesh mesh = form == 0   ? generate(BoxShape{{side, side, side}, {{1, 1, 1}}})
                      : form == 1 ? generate(SphereShape{side / 2, 2})
                                  : l_prism(side);
    PlacedSolid solid = placed("", mesh, random.direction(), random(0, 180), at);
    touch(solid, random);
    return solid;
  }
  static PlacedSolid ground(Random& random) {
    PlacedSolid solid =
        placed("", generate(BoxShape{{6, 0.6, 6}, {{2, 1, 2}}}), {0, 1, 0}, random(0, 90), {0, -0.65, 0});
    touch(solid, random);
    return solid;
  }
  static void touch(PlacedSolid& solid, Random& random) {
    solid.spec.thickness = 1e-3 * std::pow(10, random(0, 1)), solid.spec.friction = std::max(0.0, random());
    if (random() < -0.6) solid.spec.restitution = random(0, 1);
  }
  static void block(Scene& scene, Random& random, double speed) {
    BodySpec body;
    body.name = "block";
    if (random() < 0)
      body.shape = TetBoxShape{{random(0.2, 0.5), random(0.2, 0.4), random(0.2, 0.4)}, {2, 2, 2}};
    else
      body.shape = SphereShape{0.2, 1 + random.below(2)};
    body.mass = std::pow(10, random(-1, 1));
    body.constraints = {stiff("distance", {"edges"}, random() < 0 ? 1 : 0.1)};
    const Place axis = random.direction();
    body.transform.axis = {axis.x, axis.y, axis.z}, body.transform.degrees = random(0, 90);
    body.transform.translate = {0, random(0.4, 0.6), 0};
    body.velocity = {0.2 * random() * speed, -speed, 0.2 * random() * speed};
    const Place spin = random.in_cube(5);
    body.spin = {spin.x, spin.y, spin.z};
    scene.bodies.push_back(body);
  }
  void sheets(Scene& scene, Random& random, int count) {
    for (int k = 0; k < count; ++k) {
      BodySpec body;
      body.name = "sheet " + std::to_string(k);
      body.shape = MeshFile{folder_.write("sheet" + std::to_string(++files_) + ".obj",
                                          irregular_sheet(1, 1, 5 + random.below(4), 5 + random.below(4), random))};
      body.density = 0.2 * std::pow(5, random(0, 1));
      body.constraints = {stiff("distance", {"edges"})};
      if (random() < 0) body.constraints.push_back(stiff("bending", {}, 0.1));
      body.transform.translate = {-0.5, 0.1 * k, -0.5};
      scene.bodies.push_back(body);
    }
  }

  const TemporaryFolder& folder_;
  int files_ = 0;
};

TEST(WindingNumber, TellsInsideFromOutside) {
  const PlacedSolid prism = placed("", l_prism(1), {0, 0, 1}, 0, {0, 0, 0});
  EXPECT_NEAR(prism.tracked.winding({-0.2, -0.3, 0.1}), 1, 1e-12);
  EXPECT_NEAR(prism.tracked.winding({0.2, 0.2, 0.1}), 0, 1e-12) << "in the corner of the L";
  EXPECT_NEAR(prism.tracked.depth({-0.25, -0.4, 0}, 0), 0.1, 1e-12);
}

struct Insides {
  int met = 0;      // scenes in which bodies touched both a solid and themselves
  int through = 0;  // scenes that reported a penetration of a body by what solids move along
  int inside = 0, crossed = 0;
};

/// The depth of the deepest particle in any solid (m), beyond rounding.
double deepest_in(const InsideScene& made, const Simulation& simulation) {
  // Rounding of positions a few metres away at most, and the surface's tolerance within which a ray may start.
  const double rounding = made.scene.solver.precision == Precision::Float ? 2e-6 : 1e-9;
  double deepest = 0;
  for (const Vec3& x : simulation.positions())
    for (const PlacedSolid& solid : made.solids) {
      const double depth = solid.tracked.depth(place_of(x), simulation.time());
      if (depth > rounding * (1 + length(x))) deepest = std::max(deepest, depth);
    }
  return deepest;
}

void look_inside(const InsideScene& made, int steps, Insides& found) {
  Simulation simulation(made.scene, {.threads = 1});
  bool met = false;
  double deepest = 0;
  std::int64_t crossings = 0;
  for (int step = 0; step < steps && deepest == 0 && crossings == 0; ++step) {
    simulation.step();
    const Measures measures = simulation.measure();
    met = met || (measures.contacts > 0 && measures.self_contacts > 0);
    crossings = measures.crossings;
    deepest = deepest_in(made, simulation);
    EXPECT_EQ(deepest, 0) << "step " << step;
  }
  const bool through = simulation.solver().facts().self->substeps_kinematic_penetration > 0;
  EXPECT_TRUE(crossings == 0 || through) << crossings << " crossings that nothing said";
  found.met += met, found.through += through, found.inside += deepest > 0, found.crossed += crossings > 0;
}

Insides look_inside(unsigned first, unsigned scenes, int steps) {
  const TemporaryFolder folder;
  InsideScenes all(folder);
  Insides found;
  for (unsigned seed = first; seed < first + scenes; ++seed) {
    const InsideScene made = all.make(seed);
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + made.what);
    look_inside(made, steps, found);
  }
  return found;
}

TEST(NothingInside, OfAHundredScenes) {
  const Insides found = look_inside(0, 100, 20);
  EXPECT_EQ(found.inside, 0);
  EXPECT_GT(found.met, 40);
  EXPECT_LE(found.crossed, 1) << "there is room for all";
}

TEST(NothingInside, DISABLED_OfThreeThousandScenes) {
  const Insides found = look_inside(1000, 3000, 30);
  EXPECT_EQ(found.inside, 0);
  std::printf(
      "%d scenes in which bodies met solids and themselves, %d said that something may have gone through, in %d "
      "it did\n",
      found.met, found.through, found.crossed);
}

// A box that moves down onto a free sheet carries it along.
TEST(NothingInside, OfABoxThatFallsOnASheet) {
  for (const double speed : {5.0, 30.0})
    for (const int substeps : {1, 10, 40})
      for (const char* const method : {"pbd", "desbrun"}) {
        SCOPED_TRACE(std::to_string(speed) + " m/s, " + std::to_string(substeps) + " substeps, " + method);
        BodySpec sheet;
        sheet.name = "sheet", sheet.shape = GridShape{{1, 1}, {10, 10}}, sheet.density = 0.2;
        sheet.transform.translate = {-0.5, 0, -0.5}, sheet.constraints = {stiff("distance", {"edges"})};
        InsideScene made;
        made.scene = scene_of({sheet}, {}, 1.0 / 60, substeps, Precision::Float);
        made.scene.solver.type = method, made.scene.self_collision = SelfCollision{0.005, 0.3, {}};
        PlacedSolid box =
            placed("box", generate(BoxShape{{0.3, 0.3, 0.3}, {{1, 1, 1}}}), {1, 0.2, 0.4}, 20, {0, 0.4, 0});
        set_moving(box, {0, -speed, 0}, {0, 1, 0}, 0, 3 / speed);
        made.scene.environment = {box.spec}, made.solids = {box};
        Insides found;
        look_inside(made, 30, found);
        EXPECT_EQ(found.inside + found.crossed, 0);
      }
}

// A block of tetrahedra that falls on a still box ends on it.
TEST(NothingInside, OfABlockThatFallsOnABox) {
  for (const double speed : {0.0, 20.0})
    for (const int substeps : {1, 10})
      for (const char* const method : {"pbd", "desbrun"}) {
        SCOPED_TRACE(std::to_string(speed) + " m/s, " + std::to_string(substeps) + " substeps, " + method);
        BodySpec block;
        block.name = "block", block.shape = TetBoxShape{{0.2, 0.2, 0.2}, {3, 3, 3}}, block.density = 1000;
        block.transform.translate = {0.02, 0.55, 0.03}, block.velocity = {0, -speed, 0};
        block.constraints = {compliant("distance", 1e-4, {"edges"})};
        InsideScene made;
        made.scene = scene_of({block}, kEarth, 1.0 / 60, substeps, Precision::Float);
        made.scene.solver.type = method, made.scene.self_collision = SelfCollision{0.005, 0.3, {}};
        const PlacedSolid box =
            placed("box", generate(BoxShape{{0.3, 0.3, 0.3}, {{1, 1, 1}}}), {0, 1, 0}, 20, {0, 0, 0});
        made.scene.environment = {box.spec}, made.solids = {box};
        Insides found;
        look_inside(made, 40, found);
        EXPECT_EQ(found.inside + found.crossed, 0);
      }
}

}  // namespace
}  // namespace malha
