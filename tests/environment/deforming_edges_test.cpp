// SPDX-License-Identifier: Apache-2.0
// Contacts with edges of meshes that deform: ridges and nails that rise, bend and slide do not go through a cloth of
// coarser cells, by a count of the test's own of the edges that go through triangles.
#include <gtest/gtest.h>

#include <cmath>

#include "host/attachments/pose.h"
#include "host/mesh/topology.h"
#include "host/model/edge_triangle_intersection.h"
#include "host/model/model.h"
#include "host/model/tear.h"
#include "host/report/plan.h"
#include "host/solver/solver.h"
#include "tests/environment/edged_solids.h"
#include "tests/mesh/irregular_mesh.h"
#include "tests/refusal.h"
#include "tests/same_bits.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

/// A scene of one object that deforms, whose vertices follow a function of time, and a count of intersections.
class Deformed {
 public:
  Deformed(const Scene& scene, const EdgedSolids& solids, Deformation deformation, bool each_substep = false)
      : simulation_(scene, {.threads = 1, .interactive = each_substep}),
        points_(solids.points()),
        deformation_(std::move(deformation)),
        dt_(scene.solver.dt),
        h_(scene.solver.dt / scene.solver.substeps),
        each_substep_(each_substep) {}

  void step() {
    if (!each_substep_) {
      simulation_.set_vertices("object", at(simulation_.time() + dt_));
      return simulation_.step();
    }
    simulation_.set_vertices("object", at(simulation_.time() + (simulation_.steps() == 0 ? dt_ : h_)));
    simulation_.step([this](int, double time) { simulation_.set_vertices("object", at(time + h_)); });
  }
  Simulation& simulation() { return simulation_; }

  /// Edges of the one surface that go through triangles of the other.
  int crossings() const {
    const Mesh cloth = body_mesh(simulation_.model().render_mesh, 0);
    const Mesh& object = simulation_.model().environment[0].mesh;
    const std::vector<Vec3> x = simulation_.positions(), y = at(simulation_.time());
    return through(cloth, x, object, y) + through(object, y, cloth, x);
  }
  static int through(const Mesh& one, const std::vector<Vec3>& x, const Mesh& other, const std::vector<Vec3>& y) {
    int count = 0;
    for (const Triangle& s : triangles(one))
      for (int k = 0; k < 3; ++k)
        for (const Triangle& t : triangles(other))
          count += crosses(x[s[k]], x[s[(k + 1) % 3]], y[t[0]], y[t[1]], y[t[2]]) ? 1 : 0;
    return count;
  }
  double fastest() const {
    double most = 0;
    for (const Vec3& v : simulation_.velocities()) most = std::max(most, length(v));
    return most;
  }

 private:
  std::vector<Vec3> at(double time) const {
    std::vector<Vec3> all;
    for (const Vec3& x : points_) all.push_back(deformation_(x, time));
    return all;
  }
  Simulation simulation_;
  std::vector<Vec3> points_;
  Deformation deformation_;
  double dt_, h_;
  bool each_substep_;
};

int most_crossings(Scene scene, const EdgedSolids& solids, const Deformation& deformation, bool edges, int steps) {
  scene.environment[0].edges = edges;
  Deformed deformed(scene, solids, deformation);
  int most = 0;
  for (int step = 0; step < steps; ++step) {
    deformed.step();
    const int now = deformed.crossings();
    most = std::max(most, now);
    if (edges) {
      EXPECT_EQ(deformed.simulation().measure().crossings > 0, now > 0);
    }
  }
  return most;
}

/// A sheet of cells of 0.1 m with two opposite rows pinned, above a ridge of 0.4 m that lies between rows of particles.
Scene pinned_over_a_ridge(const EnvironmentSpec& object, int substeps) {
  BodySpec cloth = cloth_above(0);
  cloth.pins = {RowPin{false}, RowPin{true}};
  Scene scene = scene_of({cloth}, {0, 0, 0}, 1.0 / 60, substeps, Precision::Float);
  scene.environment = {object};
  return scene;
}

TEST(DeformingEdges, ARidgeThatRisesUnderAPinnedSheetLiftsItAtAnySpeed) {
  for (const double speed : {0.3, 3.0, 30.0, 300.0})
    for (const int substeps : {1, 4, 10}) {
      const TemporaryFolder folder;
      EdgedSolids solids;
      solids.ridge(0.03, 0.1, -0.2, 0, -0.17, 0.22);
      const Deformation rise = [&](const Vec3& x, double t) -> Vec3 {
        return {x[0], x[1] == 0 ? std::min(-0.03 + speed * t, 0.25) : x[1], x[2]};
      };
      Scene scene = pinned_over_a_ridge(solids.deforming_object(folder, rise), substeps);
      const int steps = 5 + static_cast<int>(std::min(60.0, 60 * 0.28 / speed));
      EXPECT_GT(most_crossings(scene, solids, rise, false, steps), 0) << speed << " m/s, " << substeps << " substeps";
      EXPECT_EQ(most_crossings(scene, solids, rise, true, steps), 0) << speed << " m/s, " << substeps << " substeps";
    }
}

/// Nails whose tips wave and rise, each by itself.
Deformation waving(double speed, double far) {
  return [=](const Vec3& x, double t) -> Vec3 {
    if (x[1] < -0.1) return x;  // the bases rest
    const double phase = 40 * x[0] + 70 * x[2], s = 2 * kPi * speed * t;
    return {x[0] + far * (std::sin(s + phase) - std::sin(phase)), x[1] + 0.5 * far * (1 - std::cos(1.3 * s)),
            x[2] + far * (std::cos(0.7 * s + phase) - std::cos(phase))};
  };
}

/// Edges of a body that go through triangles of another one.
int crossings_of_bodies(const Simulation& simulation, std::size_t one, std::size_t other) {
  const RenderMesh& all = simulation.model().render_mesh;
  const Mesh a = body_mesh(all, one), b = body_mesh(all, other);
  const std::vector<Vec3> x = simulation.positions();
  const auto of = [&](std::size_t body) {
    return std::vector<Vec3>(x.begin() + all.body_begin[body], x.begin() + all.body_begin[body + 1]);
  };
  return Deformed::through(a, of(one), b, of(other)) + Deformed::through(b, of(other), a, of(one));
}

// Where there is no place for two sheets, these cross the nails, which is counted, and not each other.
TEST(DeformingEdges, NailsThatRisePushNoSheetThroughAnother) {
  int pinched = 0;
  for (int k = 0; k < 6; ++k) {
    const TemporaryFolder folder;
    Random random(20 + k);
    EdgedSolids solids;
    for (double x = -0.4; x < 0.4; x += 0.12)
      for (double z = -0.4; z < 0.4; z += 0.12)
        solids.nail({x + random(-0.02, 0.02), -0.02, z + random(-0.02, 0.02)}, 0.2, 0.02, 4, random(0, 6));
    const double speed = random(0.5, 1.75);
    const Deformation rise = [=](const Vec3& x, double t) -> Vec3 {
      return {x[0], x[1] < -0.1 ? x[1] : x[1] + speed * std::min(t, 0.2) * (1 + 0.5 * std::sin(17 * x[0] + 11 * x[2])),
              x[2]};
    };
    EnvironmentSpec object = solids.deforming_object(folder, rise);
    object.thickness = 0.004, object.friction = 0.3;
    const auto sheet = [&](const char* name, double y) {
      BodySpec body = cloth_above(y, folder.write(std::string(name) + ".obj", irregular_obj(1, 1, 10, 10, 0.3, k)));
      body.name = name;
      return body;
    };
    Scene scene = scene_of({sheet("lower", 0.01), sheet("upper", 0.03)}, kEarth, 1.0 / 60, k % 2 == 0 ? 10 : 5,
                           k % 2 == 0 ? Precision::Float : Precision::Double);
    scene.environment = {object};
    scene.self_collision.emplace();
    scene.self_collision->thickness = 0.004, scene.self_collision->friction = 0.2;
    Deformed deformed(scene, solids, rise);
    for (int step = 0; step < 25; ++step) {
      deformed.step();
      ASSERT_EQ(crossings_of_bodies(deformed.simulation(), 0, 1), 0) << "case " << k << ", step " << step;
    }
    pinched += deformed.simulation().measure().max_pinched;
  }
  std::printf("particles without a place: %d\n", pinched);
}

TEST(DeformingEdges, NailsThatWaveHoldACloth) {
  Random random(7);
  for (int k = 0; k < 16; ++k) {
    const TemporaryFolder folder;
    EdgedSolids solids;
    const double spacing = 0.1 * 0.4 * std::pow(6, random(0, 1));
    for (double x = -0.4; x < 0.4; x += spacing)
      for (double z = -0.4; z < 0.4; z += spacing) {
        const Vec3 tip{x + random(-0.2, 0.2) * spacing, random(-0.05, 0), z + random(-0.2, 0.2) * spacing};
        const double wide = spacing * random(0.02, 0.2);
        if (random() < 0)
          solids.nail(tip, 0.2, wide, 3 + random.below(4), random(0, 6));
        else
          solids.box({tip[0], -0.2, tip[2]}, {tip[0] + wide, tip[1], tip[2] + wide});
      }
    const Deformation wave = waving(random(0.5, 4), 0.2 * spacing);
    EnvironmentSpec object = solids.deforming_object(folder, wave);
    object.thickness = random(0.002, 0.02), object.friction = random(0, 0.6);
    BodySpec cloth = cloth_above(0.05, k % 2 == 0 ? folder.write("c.obj", irregular_obj(1, 1, 10, 10, 0.3, k)) : "");
    cloth.velocity = {random(-2, 2), -std::pow(10, random(-1, 1)), random(-2, 2)};
    cloth.spin = {random(-3, 3), random(-3, 3), random(-3, 3)};
    constexpr int substeps[] = {1, 2, 5, 10, 20};
    Scene scene =
        scene_of({cloth}, kEarth, 1.0 / 60, substeps[k % 5], k % 4 < 2 ? Precision::Float : Precision::Double);
    scene.environment = {object};
    EXPECT_EQ(most_crossings(scene, solids, wave, true, 20), 0) << "case " << k;
  }
}

// A rod that moves and turns under a cloth. Of the deforming one the diagonals of flat sides touch too, so that they
// part by millimetres while the cloth slides.
TEST(DeformingEdges, ARigidMotionGivenAsADeformationDoesWhatTheRigidObjectDoes) {
  const TemporaryFolder folder;
  EdgedSolids solids;
  solids.box({-0.4, -0.2, 0.02}, {0.37, 0, 0.03});
  Keyframe start, end;
  end.time = 0.5, end.translate = {0.1, 0.2, -0.05}, end.axis = {0.2, 1, 0.3}, end.degrees = 40;
  const Deformation turn = [&](const Vec3& x, double t) -> Vec3 {
    const Vector3<double> at = to_world(pose_at({start, end}, t), {x[0], x[1], x[2]});
    return {at.x, at.y, at.z};
  };
  for (const Precision precision : {Precision::Float, Precision::Double}) {
    Scene scene = scene_of({cloth_above(0.02)}, kEarth, 1.0 / 60, 10, precision);
    scene.environment = {solids.deforming_object(folder, {})};
    Deformed deformed(scene, solids, turn, true);
    scene.environment[0].animation.reset(), scene.environment[0].motion = {start, end};
    Simulation rigid(scene, {.threads = 1});
    for (int step = 0; step < 30; ++step) {
      deformed.step(), rigid.step();
      EXPECT_EQ(deformed.crossings(), 0);
      if (step >= 15) continue;
      const std::vector<Vec3> x = rigid.positions(), y = deformed.simulation().positions();
      for (std::size_t i = 0; i < x.size(); ++i) EXPECT_LT(length(x[i] - y[i]), 0.005) << "step " << step;
    }
    EXPECT_GT(rigid.measure().edge_contacts, 10);
    EXPECT_GT(deformed.simulation().measure().edge_contacts, 10);
  }
}

// A strip hangs over a thin rod, which stretches along itself: friction takes the strip along, by mu times its weight,
// until it moves as the rod does under it.
TEST(DeformingEdges, FrictionCarriesAStripWithARodThatStretches) {
  const TemporaryFolder folder;
  EdgedSolids solids;
  solids.box({-0.5, -0.004, -0.002}, {0.5, 0, 0.002});
  const double rate = 1, mu = 0.3;  // of the strain, 1/s, from 1 s on, when the strip is at rest
  const Deformation stretch = [&](const Vec3& x, double t) -> Vec3 {
    return {x[0] + rate * std::max(0.0, t - 1) * (x[0] + 0.5), x[1], x[2]};
  };
  EnvironmentSpec object = solids.deforming_object(folder, stretch);
  object.friction = mu;
  BodySpec strip = cloth_above(0);
  strip.shape = GridShape{{0.2, 1.1}, {2, 11}};  // the rod lies under the middle of the sixth of eleven cells
  strip.transform.translate = {-0.1, 0.02, -0.55};
  strip.constraints = {stiff("distance", {"edges", "shear"})};
  strip.damping = 0.3;
  Scene scene = scene_of({strip}, kEarth, 1.0 / 60, 20);
  scene.environment = {object};
  Deformed deformed(scene, solids, stretch);
  const auto speed = [&] { return deformed.simulation().measure().momentum[0] / (0.2 * 0.2 * 1.1); };
  for (int step = 1; step <= 108; ++step) {
    deformed.step();
    if (step == 60) {
      EXPECT_NEAR(speed(), 0, 1e-3);
    }
    if (step == 64 || step == 68) {
      EXPECT_NEAR(speed(), mu * kG * (step / 60.0 - 1), 0.03 * mu * kG * (step / 60.0 - 1));
    }
  }
  // The rod passes under it by v^2 / (2 mu g) until then, with v the rod's speed there: v = rate (0.5 - v^2 / (2 mu
  // g)).
  const double slip = mu * kG / rate, v = -slip + std::sqrt(slip * slip + 2 * slip * rate * 0.5);
  EXPECT_NEAR(speed(), v, 0.01 * v);
}

// Two bars of one mesh close on a sheet until they pass through each other, and open again. They move at up to half a
// metre per second.
TEST(DeformingEdges, BarsThatCloseOnASheetDoNotThrowItAndLetItGo) {
  const TemporaryFolder folder;
  EdgedSolids solids;
  solids.box({-0.3, -0.1, 0.03}, {0.3, -0.05, 0.05}), solids.box({-0.3, 0.05, 0.033}, {0.3, 0.1, 0.06});
  const Deformation close = [](const Vec3& x, double t) -> Vec3 {
    const double way = 0.08 * std::sin(2 * kPi * std::min(t, 0.5));
    return {x[0], x[1] + (x[1] < 0 ? way : -way), x[2]};
  };
  BodySpec cloth = cloth_above(0);
  cloth.pins = {RowPin{false}, RowPin{true}};
  Scene scene = scene_of({cloth}, kEarth, 1.0 / 60, 10, Precision::Float);
  scene.environment = {solids.deforming_object(folder, close)};
  Deformed deformed(scene, solids, close);
  for (int step = 0; step < 90; ++step) {
    deformed.step();
    EXPECT_LT(deformed.fastest(), 4) << "step " << step;
  }
  EXPECT_GT(deformed.simulation().measure().max_pinched, 0);
  EXPECT_EQ(deformed.crossings(), 0);
}

/// Frames of a ridge that waves, and a cloth that falls on it.
Scene cloth_on_a_waving_ridge(const TemporaryFolder& folder) {
  EdgedSolids solids;
  for (double x = -0.3; x < 0.35; x += 0.13) solids.ridge(x, 0.02, -0.2, 0, -0.4, 0.4);
  const Deformation wave = waving(1.5, 0.03);
  EnvironmentSpec object = solids.deforming_object(folder, wave);
  for (int frame = 0; frame < 8; ++frame)
    folder.write("frame" + std::to_string(frame) + ".obj", solids.obj(wave, 0.04 * frame));
  object.animation->from_code = false;
  object.animation->frames = (folder / "frame*.obj").string(), object.animation->frames_per_second = 25;
  BodySpec cloth = cloth_above(0.03);
  cloth.shape = GridShape{{1, 1}, {24, 24}}, cloth.velocity = {0, -2, 0};
  Scene scene = scene_of({cloth}, kEarth, 1.0 / 60, 3, Precision::Float);
  scene.environment = {object};
  return scene;
}

INSTANTIATE_TEST_SUITE_P(DeformingEdges, SameBits,
                         testing::Values(SameBitsScene{
                             "OfRidgesThatWave",
                             cloth_on_a_waving_ridge,
                             8,
                             {2, 5},
                             [](const Simulation& simulation) { EXPECT_GT(simulation.measure().edge_contacts, 10); }}),
                         name_of_scene);

TEST(DeformingEdges, OfAllThatTheMeshHasAreFound) {
  const TemporaryFolder folder;
  EdgedSolids solids;
  solids.ridge(0, 0.1, -0.2, 0, -0.2, 0.2);
  const Simulation simulation(pinned_over_a_ridge(solids.deforming_object(folder, {}), 1), {.threads = 1});
  // A prism of 8 triangles has 12 edges, of which 3 are diagonals of flat sides, and 6 corners.
  EXPECT_TRUE(has(plan(simulation), "environment_edges:\n  edges: 12\n  corners: 6\n")) << plan(simulation);
}

TEST(DeformingEdges, RefuseABodyThatTheyCrossAtTheStart) {
  const TemporaryFolder folder;
  EdgedSolids solids;
  solids.ridge(0.03, 0.1, -0.2, 0.01, -0.17, 0.22);
  const std::string message =
      refusal([&] { Simulation(pinned_over_a_ridge(solids.deforming_object(folder, {}), 1), {.threads = 1}); });
  EXPECT_TRUE(has(message, "/environment/0/edges")) << message;
  EXPECT_TRUE(has(message, "crosses at the start")) << message;
}

}  // namespace
}  // namespace malha
