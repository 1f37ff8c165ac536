// SPDX-License-Identifier: Apache-2.0
// The same scene gives the same bits on any number of threads, on either backend, and run after run.
#include <gtest/gtest.h>

#include <atomic>
#include <utility>

#include "host/patch/sweep.h"
#include "host/solver/solver.h"
#include "kernels/parallel/compute.h"
#include "tests/parallel/blocks_solvers.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

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
                      compliant("pressure", 3e-6, {}, 1.2)};
  return body;
}

/// The cloth above a rotating and rising sphere and a bouncing floor, in the wind.
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

#if defined(TESTS_BLOCKS)
TEST_P(Determinism, HoldsOnBlocksOfThreads) {
  const Scene scene = everything(24, 3, GetParam());
  const std::uint64_t serial = hash_after(scene, 30, {.threads = 1, .backend = Backend::Serial});
  for (const auto& [threads, seed] : {std::pair(1, 1u), std::pair(32, 2u), std::pair(128, 3u)})
    EXPECT_EQ(hash_on_blocks(scene, 30, {threads, seed}), serial) << threads << " threads, order " << seed;
}
#endif

/// Sets the number of threads in every step, as AdaptiveThreadCount does.
TEST_P(Determinism, HoldsWhereEachStepRunsOnAnotherNumberOfThreads) {
  const Scene scene = everything(24, 3, GetParam());
  const std::uint64_t serial = hash_after(scene, 12, {.threads = 1, .backend = Backend::Serial});
  Simulation simulation(scene, {.threads = 3});
  for (int step = 0; step < 12; ++step) {
    max_threads = 1 + step % 3;
    simulation.step();
  }
  max_threads = kAllThreads;
  EXPECT_EQ(serial, simulation.state_hash());
}

// 40,000 particles: beyond the grain of particles (kernels/parallel/compute.h), so that launches use their threads.
static_assert(200 * 200 > kParticleGrain, "a larger cloth is needed");
TEST_P(Determinism, HoldsBeyondTheGrainSize) { expect_equal_bits(everything(200, 4, GetParam()), 2); }

/// A scene without environment and pressure: prediction, projection and state update are fused into the patch solves.
/// Particles are numbered as a grid, or in an order that has nothing to do with the mesh.
class FusedPatchSolves : public testing::TestWithParam<std::tuple<int, bool, Precision>> {
 protected:
  Scene scene() const {
    const auto [side, shuffled, precision] = GetParam();
    BodySpec body = cloth(side);
    body.damping = 0;
    if (shuffled) body.shape = MeshFile{folder_.write("cloth.obj", shuffled_grid(side))};
    Scene scene = scene_of({body}, kEarth, 1.0 / 60, 5, precision);
    scene.solver.iterations = 2;
    return scene;
  }

 private:
  /// Vertex i of the file is vertex i * step of the grid.
  static std::string shuffled_grid(int side) {
    const int n = side * side, step = 1009;  // a prime: every vertex once
    std::string text;
    std::vector<int> at(n);
    for (int i = 0; i < n; ++i) {
      const int vertex = static_cast<int>(std::int64_t{i} * step % n);
      at[vertex] = i + 1;
      text += "v " + std::to_string(1.6 / (side - 1) * (vertex % side)) + " 0 " +
              std::to_string(1.6 / (side - 1) * (vertex / side)) + "\n";
    }
    for (int row = 0; row + 1 < side; ++row)
      for (int i = row * side; i + 1 < (row + 1) * side; ++i)
        text += "f " + std::to_string(at[i]) + " " + std::to_string(at[i + side]) + " " +
                std::to_string(at[i + side + 1]) + " " + std::to_string(at[i + 1]) + "\n";
    return text;
  }

  TemporaryFolder folder_;
};

TEST_P(FusedPatchSolves, HaveTheSameBitsOnAnyNumberOfThreads) {
#if !defined(NDEBUG)
  if (std::get<0>(GetParam()) > 46) GTEST_SKIP() << "ten seconds each without optimisation, and the same code";
#endif
  const auto hash = [](const Scene& scene, const SimulationOptions& options) {
    Simulation simulation(scene, options);
    for (int step = 0; step < 4; ++step) simulation.step();
    EXPECT_TRUE(simulation.solver().step_plan().fuses());
    EXPECT_EQ(simulation.solver().facts().patches.patches > 1, simulation.model().count() > 17 * 17);
    return simulation.state_hash();
  };
  Scene plain = scene(), windy = scene();
  windy.wind = Wind{{1, 0, 0.5}, 1e-4};  // one parallel region a substep instead of one a step
  windy.bodies[0].damping = 0.1;
  for (const Scene& one : {plain, windy}) {
    const std::uint64_t serial = hash(one, {.threads = 1, .backend = Backend::Serial});
    for (const int threads : {1, 2, 3, 8}) EXPECT_EQ(serial, hash(one, {.threads = threads})) << threads << " threads";
#if defined(TESTS_BLOCKS)
    EXPECT_EQ(serial, hash_on_blocks(one, 4, {32})) << "a block of 32 threads";
#endif
  }
}

std::string visited_name(const testing::TestParamInfo<std::tuple<int, bool, Precision>>& tested) {
  const auto [side, shuffled, precision] = tested.param;
  return std::to_string(side) + "Wide" + (shuffled ? "Shuffled" : "") +
         (precision == Precision::Float ? "Float" : "Double");
}

/// One patch, a few, and more.
INSTANTIATE_TEST_SUITE_P(, FusedPatchSolves,
                         testing::Combine(testing::Values(17, 46, 100), testing::Bool(),
                                          testing::Values(Precision::Float, Precision::Double)),
                         visited_name);

// 289 particles on 8 threads run as on one: there is no team to wait for.
TEST(ASweep, HasNoMoreThreadsThanThePatchesOfItsLargestColour) {
  for (const int side : {17, 46, 100}) {
    const Model model = build_model(scene_of({cloth(side)}, kEarth, 1.0 / 60));
    const Sweep<OpenMP, float> sweep(OpenMP{8}, model, 8);
    std::atomic<int> threads = 0;
    sweep.region([&](const auto&) { ++threads; });
    const int most = plan_patches(model).width();
    EXPECT_EQ(most == 1, side == 17) << side;
    EXPECT_GE(threads, 1) << side;
    EXPECT_LE(threads, std::min(most, 8)) << side;
  }
}

/// The error of a run whose body 'lost' leaves float's range: its spin throws two particles 2^124 m a substep, and the
/// sixteenth reaches 2^128, which float does not represent.
std::string divergence(std::vector<BodySpec> bodies, const SimulationOptions& options) {
  const Scene scene = scene_of(std::move(bodies), {}, 0x1p27, 2, Precision::Float);
  Simulation simulation(scene, options);
  EXPECT_TRUE(simulation.solver().step_plan().fuses());
  try {
    for (int step = 0; step < 20; ++step) simulation.step();
  } catch (const Diverged& error) {
    return error.what();
  }
  return "";
}

TEST(ADivergedPatchSolve, NamesStepParticleAndBodyAlikeOnAnyNumberOfThreads) {
  BodySpec lost, calm = cloth(46);
  lost.name = "lost", lost.mass = 1;
  lost.shape = LatticeShape{{-0x1p39, 0, 0}, {0x1p39, 0, 0}, {2, 1, 1}};
  lost.spin = {0, 0x1p59, 0};
  calm.name = "calm", calm.velocity = {}, calm.damping = 0;
  BodySpec calm_too = calm;
  calm_too.name = "calm too";
  const std::string expected =
      "step 8 (t = 939524096.000000 s): particle 0 of body 'lost' has no finite position any more";
  for (const std::vector<BodySpec>& bodies :
       {std::vector{lost}, std::vector{lost, calm}, std::vector{calm, lost, calm_too}}) {
    EXPECT_EQ(divergence(bodies, {.backend = Backend::Serial}), expected);
    for (const int threads : {1, 2, 3, 8}) EXPECT_EQ(divergence(bodies, {.threads = threads}), expected) << threads;
  }
}

TEST_P(Determinism, HashesEveryBitOfTheState) {
  const Scene scene = everything(24, 3, GetParam());
  Scene other = scene;
  other.bodies[0].velocity[2] = 1e-6;
  EXPECT_NE(hash_after(scene, 5, {.threads = 1}), hash_after(other, 5, {.threads = 1}));
}

/// The positions of one body of a run, exactly.
std::vector<Vec3> part(const std::vector<Vec3>& all, std::size_t first, std::size_t count) {
  const auto begin = all.begin() + static_cast<std::ptrdiff_t>(first);
  return {begin, begin + static_cast<std::ptrdiff_t>(count)};
}

/// The positions after half a second of a cloth and a balloon that do not touch, each alone, together, and swapped.
struct Apart {
  std::vector<Vec3> left, right, together, swapped;
};
Apart apart(Precision precision, int levels) {
  const auto positions = [&](std::vector<BodySpec> bodies) {
    Scene scene = everything(24, 3, precision);
    scene.bodies = std::move(bodies), scene.solver.levels = levels;
    return after(scene, 0.5, {.threads = 1}).positions();
  };
  const BodySpec left = cloth(24), right = balloon({1.5, 0.32, 0}, 3);
  return {positions({left}), positions({right}), positions({left, right}), positions({right, left})};
}

TEST_P(Determinism, MakesBodiesThatDoNotTouchIndependentOfEachOther) {
  const auto [left, right, together, swapped] = apart(GetParam(), 0);
  EXPECT_EQ(part(together, 0, left.size()), left);
  EXPECT_EQ(part(together, left.size(), right.size()), right);
  EXPECT_EQ(part(swapped, 0, right.size()), right);
  EXPECT_EQ(part(swapped, right.size(), left.size()), left);
}

// A level's sums are over all bodies at once: their rounding depends on where a body begins. A hanging cloth amplifies
// it by no more than a thousand in half a second.
TEST(Levels, OfBodiesThatDoNotTouchAreIndependentUpToRounding) {
  const auto [left, right, together, swapped] = apart(Precision::Double, kAutoLevels);
  const auto farthest = [](const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
    double most = 0;
    for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, length(a[i] - b[i]));
    return most;
  };
  EXPECT_LT(farthest(part(together, 0, left.size()), left), 1e-12);
  EXPECT_LT(farthest(part(swapped, right.size(), left.size()), left), 1e-12);
  EXPECT_LT(farthest(part(swapped, 0, right.size()), right), 1e-12);
}

INSTANTIATE_TEST_SUITE_P(, Determinism, testing::Values(Precision::Float, Precision::Double), [](const auto& tested) {
  return std::string(tested.param == Precision::Float ? "Float" : "Double");
});

TEST(AnUnusedFeature, CostsNothing) {
  Scene scene = scene_of({particle({0, 0, 0})}, kEarth, 0.01, 1, Precision::Float);
  const Simulation bare(scene);
  // x, its rounding error, v, and the displacement: twelve numbers, each in two rows of 16 (a load of a whole pack
  // stays inside); w, and 16 to spare.
  EXPECT_EQ(bare.solver().facts().particle_bytes, 12u * 2u * 64u + 17u * 4u);
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

TEST(AnUnusedFeature, TakesNoTime) {
  Scene scene = scene_of({particle({0, 0, 0})}, kEarth, 0.01);
  const Simulation simulation = after(scene, 0.1);
  for (const Pass pass :
       {Pass::Damping, Pass::Prediction, Pass::Collision, Pass::Projection, Pass::Pressure, Pass::Contact, Pass::State})
    EXPECT_EQ(simulation.solver().pass_seconds()[static_cast<std::size_t>(pass)], 0) << static_cast<int>(pass);
}

}  // namespace
}  // namespace malha
