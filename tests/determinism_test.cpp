// The same scene gives the same bits on any number of threads, on either backend, and run after run.
#include <gtest/gtest.h>

#include "host/solver/solver.h"
#include "kernels/pack.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

/// `side` x `side` particles under every constraint and damping.
BodySpec cloth(int side) {
  BodySpec body;
  body.name = "cloth";
  body.shape = GridShape{{1.6, 1.6}, {side - 1, side - 1}};
  body.transform.translate = {-0.8, 0.62, -0.8};
  body.mass = 0.5;
  body.damping = 0.1;
  body.velocity = {0.3, -1, 0};
  body.pins = {NearestPin{{-0.8, 0.62, -0.8}}};
  body.constraints = {stiff("distance", {"edges"}), compliant("distance", 1e-6, {"shear"}),
                      stiff("distance_limit", {"edges"}, 1, 0.05), stiff("bending", {}, 0.1)};
  return body;
}

BodySpec balloon(const Vec3& at, int subdivisions) {
  BodySpec body;
  body.name = "balloon";
  body.shape = SphereShape{0.3, subdivisions};
  body.transform.translate = at;
  body.mass = 0.2;
  body.damping = 0.2;
  body.spin = {1, 5, 2};
  body.velocity = {0, -2, 0};
  body.constraints = {compliant("distance", 1e-3, {"edges"}), compliant("bending", 0.1),
                      compliant("pressure", 1e-4, {}, 1.2)};
  return body;
}

/// Over a turning and rising sphere and a bouncing floor, in the wind.
Scene everything(int side, int subdivisions, Precision precision) {
  Scene scene = scene_of({cloth(side), balloon({1.5, 0.32, 0}, subdivisions)}, kEarth, 1.0 / 60, 5, precision);
  scene.solver.iterations = 2;
  scene.wind = Wind{{1, 0, 0.5}, 1e-6};
  EnvironmentSpec globe;
  globe.name = "globe";
  globe.shape = SphereShape{0.5, 4};
  globe.friction = 0.5;
  Keyframe last;
  last.time = 1, last.translate = {0, 0.3, 0}, last.degrees = 360;
  globe.motion = {Keyframe{}, last};
  EnvironmentSpec floor;
  floor.name = "floor";
  floor.shape = GridShape{{8, 8}, {4, 4}};
  floor.transform.translate = {-4, 0, -4};
  floor.sides = Sides::TwoSided;
  floor.friction = 0.3, floor.restitution = 0.5;
  scene.environment = {globe, floor};
  return scene;
}

std::uint64_t hash_after(const Scene& scene, int steps, const SimulationOptions& options) {
  Simulation simulation(scene, options);
  for (int step = 0; step < steps; ++step) simulation.step();
  if (simulation.measure().contacts == 0) ADD_FAILURE() << "the scene has no contact to compare";
  return simulation.state_hash();
}

class Determinism : public testing::TestWithParam<Precision> {};

void expect_equal_bits(const Scene& scene, int steps) {
  const std::uint64_t serial = hash_after(scene, steps, {.threads = 1, .backend = Backend::Serial});
  EXPECT_EQ(serial, hash_after(scene, steps, {.threads = 1, .backend = Backend::Serial})) << "Serial, once more";
  for (const int threads : {1, 2, 3, 8})
    EXPECT_EQ(serial, hash_after(scene, steps, {.threads = threads})) << threads << " threads";
  EXPECT_EQ(serial, hash_after(scene, steps, {.threads = 3})) << "3 threads, once more";
}

TEST_P(Determinism, HoldsOnAnyNumberOfThreads) { expect_equal_bits(everything(24, 3, GetParam()), 30); }

// 40,000 particles: beyond the grains of particles and packs (kernels/compute.h), so that launches use their threads.
static_assert(200 * 200 > kParticleGrain && 200 * 200 / 2 / kLanes<float> > kPackGrain, "a larger cloth is needed");
TEST_P(Determinism, HoldsBeyondTheGrains) { expect_equal_bits(everything(200, 4, GetParam()), 2); }

TEST_P(Determinism, LetsEveryBitOfTheStateThrough) {
  const Scene scene = everything(24, 3, GetParam());
  Scene other = scene;
  other.bodies[0].velocity[2] = 1e-6;
  EXPECT_NE(hash_after(scene, 5, {.threads = 1}), hash_after(other, 5, {.threads = 1}));
}

/// The positions of one body out of a run, exactly.
std::vector<Vec3> part(const std::vector<Vec3>& all, std::size_t first, std::size_t count) {
  const auto begin = all.begin() + static_cast<std::ptrdiff_t>(first);
  return {begin, begin + static_cast<std::ptrdiff_t>(count)};
}

TEST_P(Determinism, MakesBodiesThatDoNotTouchIndependentOfEachOther) {
  const auto positions = [](std::vector<BodySpec> bodies) {
    Scene scene = everything(24, 3, GetParam());
    scene.bodies = std::move(bodies);
    return after(scene, 0.5, {.threads = 1}).positions();
  };
  const BodySpec left = cloth(24), right = balloon({1.5, 0.32, 0}, 3);
  const std::vector<Vec3> left_alone = positions({left}), right_alone = positions({right});
  const std::vector<Vec3> together = positions({left, right}), swapped = positions({right, left});
  EXPECT_EQ(part(together, 0, left_alone.size()), left_alone);
  EXPECT_EQ(part(together, left_alone.size(), right_alone.size()), right_alone);
  EXPECT_EQ(part(swapped, 0, right_alone.size()), right_alone);
  EXPECT_EQ(part(swapped, right_alone.size(), left_alone.size()), left_alone);
}

INSTANTIATE_TEST_SUITE_P(, Determinism, testing::Values(Precision::Float, Precision::Double), [](const auto& tested) {
  return std::string(tested.param == Precision::Float ? "Float" : "Double");
});

TEST(AnUnnamedPart, CostsNothing) {
  Scene scene = scene_of({particle({0, 0, 0})}, kEarth, 0.01, 1, Precision::Float);
  const Simulation bare(scene);
  EXPECT_EQ(bare.solver().facts().particle_bytes, 3u * 16u);  // x, v and p of one particle
  EXPECT_EQ(bare.solver().facts().constraint_bytes, 0u);
  EXPECT_EQ(bare.solver().facts().collision_bytes, 0u);
  EXPECT_TRUE(bare.solver().facts().sets.empty());
  EXPECT_EQ(bare.solver().facts().projections_per_step, 0);

  scene = everything(24, 3, Precision::Float);
  const std::size_t collision = Simulation(scene).solver().facts().collision_bytes;
  const std::size_t constraints = Simulation(scene).solver().facts().constraint_bytes;
  scene.environment.pop_back();
  EXPECT_LT(Simulation(scene).solver().facts().collision_bytes, collision);
  scene.environment.clear();
  EXPECT_EQ(Simulation(scene).solver().facts().collision_bytes, 0u);
  scene.bodies[0].constraints.pop_back();
  EXPECT_LT(Simulation(scene).solver().facts().constraint_bytes, constraints);
  for (BodySpec& body : scene.bodies) body.constraints.clear();
  EXPECT_EQ(Simulation(scene).solver().facts().constraint_bytes, 0u);
}

TEST(AnUnnamedPart, TakesNoTime) {
  Scene scene = scene_of({particle({0, 0, 0})}, kEarth, 0.01);
  const Simulation simulation = after(scene, 0.1);
  for (const Pass pass : {Pass::Damping, Pass::Collision, Pass::Projection, Pass::Pressure, Pass::Contact})
    EXPECT_EQ(simulation.solver().pass_seconds()[static_cast<std::size_t>(pass)], 0) << static_cast<int>(pass);
}

}  // namespace
}  // namespace malha
