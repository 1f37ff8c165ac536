// SPDX-License-Identifier: Apache-2.0
// Attachments to objects that deform: a particle follows the triangle that was closest at the start.
#include "host/attachments/surface_points.h"

#include <gtest/gtest.h>

#include <cmath>

#include "host/mesh/topology.h"
#include "host/report/plan.h"
#include "tests/refusal.h"
#include "tests/run_scenes.h"
#include "tests/same_bits.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

constexpr double kLength = 1, kWidth = 0.2;  // of the strip, m

/// The strip, which lies in the plane y = 0, bent to a curvature (1/m) about the z axis.
std::vector<Vec3> bent(const std::vector<Vec3>& flat, double curvature) {
  std::vector<Vec3> all;
  for (const Vec3& x : flat)
    all.push_back({std::sin(curvature * x[0]) / curvature, (1 - std::cos(curvature * x[0])) / curvature, x[2]});
  return all;
}

EnvironmentSpec strip() {
  EnvironmentSpec object;
  object.name = "strip", object.shape = GridShape{{kLength, kWidth}, {20, 4}};
  object.sides = Sides::TwoSided, object.thickness = 1e-3;
  object.animation = AnimationSpec{};
  object.animation->from_code = true;
  return object;
}

/// The place of x over a triangle: the weights of its second and third corner, and the height along its normal (m).
Vec3 place_over(const Triangle& t, const std::vector<Vec3>& points, const Vec3& x) {
  const auto vector = [](const Vec3& a) { return Vector3<double>{a[0], a[1], a[2]}; };
  const Vector3<double> a = vector(points[t[0]]), b = vector(points[t[1]]) - a, c = vector(points[t[2]]) - a;
  const Vector3<double> n = cross(b, c), d = vector(x) - a;
  const double n2 = dot(n, n);
  return {dot(cross(d, c), n) / n2, dot(cross(b, d), n) / n2, dot(d, n) / std::sqrt(n2)};
}

/// The triangle of the flat strip that has (x, z) inside.
Triangle triangle_under(const Mesh& mesh, double x, double z) {
  for (const Triangle& t : triangles(mesh)) {
    const auto side = [&](int k) {
      const Vec3 &a = mesh.points[t[k]], &b = mesh.points[t[(k + 1) % 3]];
      return (b[0] - a[0]) * (z - a[2]) - (b[2] - a[2]) * (x - a[0]);
    };
    const bool left = side(0) > 0;
    if ((side(1) > 0) == left && (side(2) > 0) == left) return t;
  }
  return {-1, -1, -1};
}

const Vec3 kPlace{0.333, 0.05, 0.077};  // of a particle above the strip, over the inside of a triangle

/// A particle attached to the strip, which bends in a second up to a curvature of 3 / m.
struct BendingStrip {
  explicit BendingStrip(std::optional<double> compliance, std::optional<double> release = {}) {
    BodySpec body = particle(kPlace);
    Attachment one;
    one.at = ListPin{{0}}, one.environment = "strip", one.compliance = compliance, one.release_time = release;
    body.attachments = {one};
    Scene scene = scene_of({body}, {0, 0, 0}, 0.01, 4);
    scene.environment = {strip()};
    simulation.emplace(scene, SimulationOptions{.threads = 1});
    flat = simulation->model().environment[0].mesh;
  }
  /// The vertices after this step.
  std::vector<Vec3> at(int step) const { return bent(flat.points, 0.03 * step); }
  void step() {
    simulation->set_vertices("strip", at(static_cast<int>(simulation->steps()) + 1));
    simulation->step();
  }
  Mesh flat;
  std::optional<Simulation> simulation;
};

void expect_place_in_triangle(const BendingStrip& run, double tolerance) {
  const Triangle t = triangle_under(run.flat, kPlace[0], kPlace[2]);
  ASSERT_GE(t[0], 0);
  const Vec3 start = place_over(t, run.flat.points, kPlace),
             now = place_over(t, run.at(static_cast<int>(run.simulation->steps())), run.simulation->positions()[0]);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(now[k], start[k], tolerance);
}

TEST(SurfacePoints, AParticleOnABendingStripKeepsItsPlaceInItsTriangle) {
  BendingStrip run(0);
  for (int step = 0; step < 100; ++step) {
    run.step();
    expect_place_in_triangle(run, 1e-12);
  }
  EXPECT_GT(length(run.simulation->positions()[0] - kPlace), 0.1) << "the strip has moved it";
}

TEST(SurfacePoints, ASoftAttachmentPullsToTheSamePlace) {
  BendingStrip run(1e-9);
  for (int step = 0; step < 100; ++step) run.step();
  expect_place_in_triangle(run, 1e-6);
}

TEST(SurfacePoints, AReleasedParticleGoesOnWithTheVelocityOfItsPlace) {
  BendingStrip run(0, 0.5);
  for (int step = 0; step < 50; ++step) run.step();
  const Vec3 then = run.simulation->positions()[0], v = run.simulation->velocities()[0];
  EXPECT_GT(length(v), 0.1);
  for (int step = 0; step < 5; ++step) run.step();  // upwards, away from the strip's concave side, nothing is hit
  const Vec3 now = run.simulation->positions()[0];
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(now[k], then[k] + 0.05 * v[k], 1e-9);
}

TEST(SurfacePoints, AnObjectThatTurnsAsAWholeTurnsThemRigidly) {
  EnvironmentMesh object{strip(), {}, {}};
  object.mesh = {{{0, 0, 0}, {1, 0, 0}, {0, 0, 1}}, {Quad{0, 2, 1, -1}}, {}, {}};
  object.spec.motion = {{0, {0, 0, 0}, {0, 0, 1}, 0}, {1, {0, 1, 0}, {0, 0, 1}, 90}};
  SurfacePoints points(object, {{0.25, 0.5, 0.25}, {-1, 0, 0}});
  const std::vector<Vector3<double>> at = points.at(1);
  EXPECT_NEAR(at[0].x, -0.5, 1e-12);
  EXPECT_NEAR(at[0].y, 1.25, 1e-12);
  EXPECT_NEAR(at[0].z, 0.25, 1e-12);
  EXPECT_NEAR(at[1].x, 0, 1e-12);
  EXPECT_NEAR(at[1].y, 0, 1e-12) << "a place beside the triangle turns, too";
}

/// A sheet whose upper row is tied to the shoulders of the walking figure.
Scene cape_of_the_figure() {
  BodySpec cape;
  cape.name = "cape", cape.mass = 0.2, cape.shape = GridShape{{0.3, 0.6}, {8, 16}};
  cape.transform = {.translate = {-0.15, 1.4, -0.25}, .axis = {1, 0, 0}, .degrees = 90, .scale = {1, 1, 1}};
  cape.constraints = {stiff("distance", {"edges", "shear"})};
  Attachment tied;
  tied.at = RowPin{}, tied.environment = "figure";
  Attachment soft = tied;
  soft.at = ListPin{{72, 80}}, soft.compliance = 1e-3, soft.release_time = 0.3;
  cape.attachments = {tied, soft};
  EnvironmentSpec figure;
  figure.name = "figure", figure.shape = MeshFile{MALHA_SOURCE_DIR "/scenes/meshes/figure.glb"};
  figure.thickness = 0.005;
  figure.animation = AnimationSpec{};
  figure.animation->clip = "walk", figure.animation->loop = true;
  Scene scene = scene_of({cape}, kEarth, 1.0 / 60, 5, Precision::Float);
  scene.environment = {figure};
  return scene;
}

INSTANTIATE_TEST_SUITE_P(AttachedToAFigure, SameBits,
                         testing::Values(SameBitsScene{"AttachedToAFigure",
                                                       [](const TemporaryFolder&) { return cape_of_the_figure(); },
                                                       40,
                                                       {7, 25},
                                                       [](const Simulation& simulation) {
                                                         EXPECT_TRUE(simulation.model().moved.at(0).target.deforms);
                                                         EXPECT_GT(length(simulation.velocities()[0]), 0.05);
                                                       }}));

TEST(SurfacePoints, ThePlanSaysWhatFollowsTriangles) {
  const Simulation simulation(cape_of_the_figure(), {.threads = 1});
  EXPECT_NE(plan(simulation).find("follows_triangles"), std::string::npos) << plan(simulation);
  const Json json = Json::parse(plan_json(simulation));
  EXPECT_EQ(json["deforming_objects"][0]["name"], "figure");
  EXPECT_GT(json["deforming_objects"][0]["triangles"], 1000);
}

}  // namespace
}  // namespace malha
