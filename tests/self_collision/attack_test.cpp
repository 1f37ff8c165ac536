// SPDX-License-Identifier: Apache-2.0
// Randomised stress test of self-collision: bodies of all kinds are thrown, moved and squeezed into each other. After
// no step may anything intersect, by a count that shares no code with the collider.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "host/measure/solver_stats.h"
#include "host/model/model.h"
#include "host/solver/solver.h"
#include "tests/mesh/irregular_sheet.h"
#include "tests/numbers.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

/// Counts edges through triangles that share no particle with them, by signs of volumes in extended precision.
class CrossingCount {
 public:
  explicit CrossingCount(const RenderMesh& render_mesh) {
    for (const Quad& face : render_mesh.faces) {
      if (!is_triangle(face)) throw std::logic_error("the count takes triangles");
      faces_.push_back({face[0], face[1], face[2]});
      for (int k = 0; k < 3; ++k) edges_.push_back(std::minmax(face[k], face[(k + 1) % 3]));
    }
    std::sort(edges_.begin(), edges_.end());
    edges_.erase(std::unique(edges_.begin(), edges_.end()), edges_.end());
  }
  int operator()(const std::vector<Vec3>& x) const {
    int count = 0;
    for (const auto& [p, q] : edges_)
      for (const auto& [a, b, c] : faces_)
        if (a != p && a != q && b != p && b != q && c != p && c != q && may_meet(x, p, q, a, b, c) &&
            sign(x[a], x[b], x[c], x[p]) * sign(x[a], x[b], x[c], x[q]) < 0) {
          const int ab = sign(x[p], x[q], x[a], x[b]);
          count += ab != 0 && ab == sign(x[p], x[q], x[b], x[c]) && ab == sign(x[p], x[q], x[c], x[a]);
        }
    return count;
  }

 private:
  static bool may_meet(const std::vector<Vec3>& x, int p, int q, int a, int b, int c) {
    for (int k = 0; k < 3; ++k)
      if (std::max(x[p][k], x[q][k]) < std::min({x[a][k], x[b][k], x[c][k]}) ||
          std::min(x[p][k], x[q][k]) > std::max({x[a][k], x[b][k], x[c][k]}))
        return false;
    return true;
  }
  /// The sign of the volume of a tetrahedron; 0 where it may be due to rounding.
  static int sign(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    using Wide = long double;
    Wide e[3][3], size = 0;
    for (int k = 0; k < 3; ++k) {
      e[0][k] = Wide(b[k]) - a[k], e[1][k] = Wide(c[k]) - a[k], e[2][k] = Wide(d[k]) - a[k];
      for (int j = 0; j < 3; ++j) size = std::max(size, std::abs(e[j][k]));
    }
    const Wide volume = e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
                        e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
                        e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
    const Wide least = 1e-17L * size * size * size;
    return volume > least ? 1 : volume < -least ? -1 : 0;
  }
  std::vector<Triangle> faces_;
  std::vector<std::pair<int, int>> edges_;
};

TEST(IntersectionCount, CountsAnEdgeThroughATriangleAndNoneBesideIt) {
  RenderMesh render_mesh;
  render_mesh.faces = {{0, 1, 2, -1}, {3, 4, 5, -1}};
  const CrossingCount count(render_mesh);
  std::vector<Vec3> x{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.2, -1}, {0.2, 0.2, 1}, {5, 5, 0.5}};
  EXPECT_EQ(count(x), 2) << "an edge of each goes through the other";
  for (int i = 3; i < 6; ++i) x[i][0] += 2;
  EXPECT_EQ(count(x), 0);
}

constexpr int kKinds = 7;
constexpr const char* kNames[kKinds] = {"sheets",          "closed bodies", "full bodies", "fast pins",
                                        "squeezing walls", "moving edges",  "bounces"};

struct Attack {
  Scene scene;
  std::string what;
};

class Attacks {
 public:
  explicit Attacks(const TemporaryFolder& folder) : folder_(folder) {}

  Attack make(int kind, unsigned seed) {
    Random random(8 * seed + kind);
    constexpr int substeps[] = {1, 2, 3, 5, 10, 20};
    const double speed = 0.3 * std::pow(1000, random(0, 1)), gap = 0.5;
    const Vec3 gravity = random() < 0 ? kEarth : Vec3{};
    const int count = substeps[random.below(6)];
    const Precision precision = random() < 0 ? Precision::Float : Precision::Double;
    Scene scene = scene_of({}, gravity, std::min(1.0 / 60, gap / speed / 4), count, precision);
    const double thickness = 1e-4 * std::pow(200, random(0, 1)), friction = std::max(0.0, random());
    scene.self_collision = SelfCollision{thickness, friction, {}};
    scene.solver.iterations = 1 + random.below(3);
    if (random() < -0.5) scene.solver.type = "desbrun";
    target(scene, random);
    if (kind == 3)
      drive(scene, random, speed);
    else if (kind == 4)
      squeeze(scene, random, speed);
    else if (kind == 5)
      cut_in(scene, random, speed);
    else if (kind == 6)
      bounce(scene, random, speed);
    else
      throw_at(scene, random, kind, speed, gap);
    return {scene, std::string(kNames[kind]) + ", " + std::to_string(speed) + " m/s, thickness " +
                       std::to_string(scene.self_collision->thickness) + " m, " +
                       std::to_string(scene.solver.substeps) + " substeps, " + scene.solver.type};
  }

 private:
  BodySpec sheet(Random& random, double side) {
    BodySpec body;
    body.name = "sheet " + std::to_string(++count_);
    const int across = 5 + random.below(5), along = 5 + random.below(5);
    body.shape = MeshFile{
        folder_.write("mesh" + std::to_string(count_) + ".obj", irregular_sheet(side, side, across, along, random))};
    body.density = 0.2;
    body.constraints = {stiff("distance", {"edges"})};
    if (random() < 0) body.constraints.push_back(stiff("bending", {}, 0.1));
    body.transform.translate = {-side / 2, 0, -side / 2};
    return body;
  }
  /// A body about the origin, free or pinned at two corners.
  void target(Scene& scene, Random& random) {
    BodySpec body = sheet(random, 1);
    if (random() < 0) body.pins = {NearestPin{{-0.5, 0, -0.5}}, NearestPin{{0.5, 0, -0.5}}};
    scene.bodies.push_back(body);
  }
  void throw_at(Scene& scene, Random& random, int kind, double speed, double gap) {
    BodySpec body;
    if (kind == 0) {
      body = sheet(random, 0.8);
    } else {
      body.name = "thrown";
      if (kind == 1)
        body.shape = SphereShape{0.25, 1 + random.below(2)};
      else
        body.shape = TetBoxShape{{0.4, 0.3, 0.3}, {2, 2, 2}};
      body.mass = std::pow(10, random(-2, 1));
      body.constraints = {stiff("distance", {"edges"})};
    }
    const Vector3<double> axis = random.direction(), spin = random.in_cube(5 + 0.2 * speed);
    body.transform.axis = {axis.x, axis.y, axis.z};
    body.transform.degrees = kind == 0 ? random(-20, 20) : random(0, 180);
    body.transform.translate[1] += gap + 0.3;
    const Vector3<double> aside = random.in_cube(0.2 * speed);
    body.velocity = {aside.x, -speed, aside.z};
    body.spin = {spin.x, spin.y, spin.z};
    scene.bodies.push_back(body);
  }
  /// A sheet whose edge is moved through the position of another one.
  void drive(Scene& scene, Random& random, double speed) {
    BodySpec body = sheet(random, 0.8);
    body.transform.translate[1] = 0.3;
    Keyframe start, end;
    end.time = 20 * scene.solver.dt;
    const Vector3<double> aside = random.in_cube(0.3);
    end.translate = {aside.x, -speed * end.time, aside.z};
    Pin pin = BoxPin{{-0.41, 0, -0.41}, {0.41, 1, random(-0.35, 0)}};
    pin.motion = {start, end};
    body.pins = {pin};
    scene.bodies.push_back(body);
    scene.bodies.front().pins.clear();
  }
  /// Several sheets between two walls that close.
  void squeeze(Scene& scene, Random& random, double speed) {
    for (int k = 1; k <= 2; ++k) {
      BodySpec body = sheet(random, 0.8);
      body.transform.translate[1] = 0.1 * k;
      scene.bodies.push_back(body);
    }
    for (const int side : {-1, 1}) {
      EnvironmentSpec wall;
      wall.name = side < 0 ? "below" : "above";
      wall.shape = BoxShape{{3, 0.5, 3}, {{1, 1, 1}}};
      wall.transform.translate = {0, side < 0 ? -0.4 : 0.6, 0};
      wall.thickness = 0.004;
      wall.friction = 0.3;
      Keyframe start, end;
      end.time = std::max(0.22 / speed, 5 * scene.solver.dt);
      end.translate = {0, side < 0 ? 0.2 : -0.2, 0};  // to within 10 cm
      wall.motion = {start, end};
      scene.environment.push_back(wall);
    }
  }
  /// Several sheets on the ground, into which a slab moves edge first.
  void cut_in(Scene& scene, Random& random, double speed) {
    for (int k = 1; k <= 2; ++k) {
      BodySpec body = sheet(random, 0.8);
      body.transform.translate[1] = 0.1 * k;
      scene.bodies.push_back(body);
    }
    EnvironmentSpec slab;
    slab.name = "slab", slab.edges = true;
    slab.shape = BoxShape{{random(0.1, 0.8), 0.3, random(0.02, 0.3)}, {{1, 1, 1}}};
    slab.thickness = 0.004;
    slab.friction = std::max(0.0, random());
    const Vector3<double> axis = random.direction();
    slab.transform.axis = {axis.x, axis.y, axis.z}, slab.transform.degrees = random(0, 180);
    slab.transform.translate = {random(-0.3, 0.3), 0.9, random(-0.3, 0.3)};
    Keyframe start, end;
    end.time = std::max(0.9 / speed, 5 * scene.solver.dt);
    end.translate = {random(-0.3, 0.3), -0.9, random(-0.3, 0.3)};
    const bool turns = random() < 0;
    if (turns) end.axis = {0.6, 0, 0.8}, end.degrees = random(-180, 180);
    slab.motion = {start, end};
    scene.environment.push_back(slab);
    if (random() < 0 || turns) return;  // an object that rotates would come through the ground, and leave no gap
    EnvironmentSpec ground;
    ground.name = "ground", ground.shape = BoxShape{{3, 0.5, 3}, {{1, 1, 1}}};
    ground.transform.translate = {0, -0.85, 0}, ground.thickness = 0.004, ground.friction = 0.3;
    scene.environment.push_back(ground);
  }
  /// Layers fall on an object with restitution, whose bounce happens within the same substep.
  void bounce(Scene& scene, Random& random, double speed) {
    for (int k = 1; k <= 2; ++k) {
      BodySpec body = sheet(random, 0.8);
      body.transform.translate[1] = 0.04 * k;
      scene.bodies.push_back(body);
    }
    for (BodySpec& body : scene.bodies) body.pins.clear(), body.velocity = {0, -speed, 0};
    EnvironmentSpec ball, ground;
    ball.name = "ball", ball.shape = SphereShape{random(0.1, 0.25), 3};
    ball.transform.translate = {random(-0.2, 0.2), -0.3, random(-0.2, 0.2)};
    ground.name = "ground", ground.shape = BoxShape{{3, 0.5, 3}, {{1, 1, 1}}};
    ground.transform.translate = {0, -0.6, 0};
    for (EnvironmentSpec object : {ball, ground}) {
      object.thickness = 0.004, object.restitution = random(0.3, 1);
      scene.environment.push_back(object);
    }
  }

  const TemporaryFolder& folder_;
  int count_ = 0;
};

struct Outcome {
  int met = 0;                             // scenes in which bodies came into contact
  int substeps_kinematic_penetration = 0;  // scenes in which pins penetrated a body, which is reported
};

Outcome attack(int kind, unsigned first, unsigned scenes, int steps) {
  const TemporaryFolder folder;
  Attacks attacks(folder);
  Outcome outcome;
  for (unsigned seed = first; seed < first + scenes; ++seed) {
    const Attack made = attacks.make(kind, seed);
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + made.what);
    Simulation simulation(made.scene, {.threads = 1 + static_cast<int>(seed % 2)});
    const CrossingCount crossings(simulation.model().render_mesh);
    const std::vector<double>& w = simulation.model().w;
    const bool held = std::find(w.begin(), w.end(), 0) != w.end();
    int contacts = 0;
    for (int step = 0; step < steps; ++step) {
      simulation.step();
      const int now = crossings(simulation.positions());
      const Measures found = simulation.measure();
      contacts += found.self_contacts;
      if (!held) {
        EXPECT_EQ(found.crossings, 0) << "with edges of the environment, in step " << step;
      }
      if (now == 0) continue;
      EXPECT_TRUE(held) << now << " crossings in step " << step;
      EXPECT_GT(simulation.solver().facts().self->substeps_kinematic_penetration, 0)
          << now << " crossings in step " << step;
      ++outcome.substeps_kinematic_penetration;
      break;
    }
    outcome.met += contacts > 0;
  }
  return outcome;
}

class RandomCollisionsOf : public testing::TestWithParam<int> {};

// Penetrations occur where moving edges press cloth against pins.
TEST_P(RandomCollisionsOf, ManyScenesIntersectNothing) {
#if defined(NDEBUG)
  constexpr int scenes = 40;
#else
  constexpr int scenes = 12;  // minutes for the others
#endif
  const Outcome outcome = attack(GetParam(), 0, scenes, 20);
  EXPECT_GT(outcome.met, scenes / 2);
  EXPECT_LE(outcome.substeps_kinematic_penetration,
            std::max(2, scenes / 8));  // of a dozen scenes, two may be by chance
}

TEST_P(RandomCollisionsOf, DISABLED_FourHundredScenesIntersectNothing) {
  const Outcome outcome = attack(GetParam(), 1000, 400, 30);
  EXPECT_GT(outcome.met, 200);
  std::printf("%s: %d met, %d were driven through\n", kNames[GetParam()], outcome.met,
              outcome.substeps_kinematic_penetration);
}

INSTANTIATE_TEST_SUITE_P(Kinds, RandomCollisionsOf, testing::Range(0, kKinds), [](const auto& info) {
  std::string name = kNames[info.param];
  std::erase(name, ' ');
  return name;
});

}  // namespace
}  // namespace malha
