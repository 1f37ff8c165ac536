// SPDX-License-Identifier: Apache-2.0
// Figures of scenes/accuracy.md on contact: layers that slide, layers that creep, and edges of the environment.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>

#include "host/environment/edge_crossings.h"
#include "host/model/model.h"
#include "host/solver/solver.h"
#include "tests/mesh/irregular_sheet.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

/// Layers of 0.4 x 0.3 m, stacked, the lowest on a fixed slope of 20 degrees.
struct LayersOnASlope {
  const char* method = "pbd";
  int across = 6, along = 5, layers = 1;  // cells; particles are one more each way
  int substeps = 10, iterations = 1;
  double friction = 0.35;
  bool grid = false;  // layers of squares, as the slope's, instead of irregular triangles
  static constexpr double kAngle = 20 * kPi / 180, kApart = 0.02;
  static constexpr int kSlope = 13 * 13;  // particles, the first ones

  Scene scene(const TemporaryFolder& folder) const {
    BodySpec slope;
    slope.name = "slope", slope.shape = GridShape{{1, 1}, {12, 12}}, slope.mass = 0.2;
    slope.transform = {{0, 0, 0}, {0, 0, 1}, -20, {3, 1, 1}};
    slope.constraints = {stiff("distance", {"edges", "shear"}), stiff("bending", {}, 0.05)};
    ListPin all;
    for (int i = 1; i < kSlope; ++i) all.particles.push_back(i);  // a body needs a movable particle
    slope.pins = {all};
    std::vector<BodySpec> bodies{slope};
    const double c = std::cos(kAngle), s = std::sin(kAngle);
    for (int k = 1; k <= layers; ++k) {
      BodySpec layer = slope;
      Random random(2 + k);
      const std::string name = "layer" + std::to_string(k);
      layer.name = name, layer.pins.clear();
      layer.shape = GridShape{{0.4, 0.3}, {across, along}};
      if (!grid) layer.shape = MeshFile{folder.write(name + ".obj", irregular_sheet(0.4, 0.3, across, along, random))};
      layer.transform = {{0.5 * c + k * kApart * s, -0.5 * s + k * kApart * c, 0.37}, {0, 0, 1}, -20};
      layer.constraints = {stiff("distance", {"edges"}), stiff("bending", {}, 0.05)};
      bodies.push_back(layer);
    }
    Scene scene = scene_of(bodies, kEarth, 1.0 / 60, substeps);
    scene.self_collision = SelfCollision{kApart, friction, {}};
    scene.solver.type = method, scene.solver.iterations = iterations;
    return scene;
  }
  /// The position of the middle of each layer along the slope, m.
  std::vector<double> middles(const Simulation& simulation) const {
    const std::vector<Vec3> x = simulation.positions();
    const std::size_t each = (x.size() - kSlope) / layers;
    std::vector<double> of(layers);
    for (std::size_t i = kSlope; i < x.size(); ++i)
      of[(i - kSlope) / each] += (x[i][0] * std::cos(kAngle) - x[i][1] * std::sin(kAngle)) / double(each);
    return of;
  }
  /// The distance that the highest layer slides in 0.8 s, over that of Coulomb's law in steps of symplectic Euler.
  double slid() const {
    constexpr double t = 0.8;
    const TemporaryFolder folder;
    const Scene in = scene(folder);
    Simulation simulation(in, {.threads = 1});
    const double from = middles(simulation).back();
    run_for(simulation, in, t);
    EXPECT_EQ(simulation.measure().crossings, 0);
    const double a = kG * (std::sin(kAngle) - friction * std::cos(kAngle)), h = in.solver.dt / substeps;
    return (middles(simulation).back() - from) / (a * t * (t + h) / 2);
  }
};

/// The smallest and the largest value of `slid` over both methods and layers of these sizes.
struct SlidRange {
  double least = 1e9, most = -1e9;
  /// The largest relative error of the distance.
  double error() const { return std::max(1 - least, most - 1); }
};
SlidRange slid_range(LayersOnASlope of, const std::vector<std::array<int, 2>>& cells,
                     const std::vector<int>& substeps) {
  SlidRange range;
  for (const char* method : {"pbd", "desbrun"})
    for (const auto& [across, along] : cells)
      for (const int n : substeps)
        for (const bool grid : {false, true}) {
          of.method = method, of.across = across, of.along = along, of.substeps = n, of.grid = grid;
          const double slid = of.slid();
          range = {std::min(range.least, slid), std::max(range.most, slid)};
        }
  return range;
}

// The bounds are twice the measured errors: contact forces of a substep are not uniform, and at 0.35 of 0.364 an error
// of 1 % in friction is one of 25 % in the distance.
TEST(Figures, DISABLED_SlidingLayers) {
  const std::vector<std::array<int, 2>> usual{{3, 2}, {6, 5}, {9, 7}, {14, 12}}, tiny{{2, 2}};
  const LayersOnASlope one;
  LayersOnASlope iterated = one, two = one, smooth = one;
  iterated.iterations = 4, two.layers = 2, smooth.friction = 0;
  const auto row = [](const char* what, const SlidRange& range, double bound) {
    std::printf("%-72s %.2f to %.2f times as far as by Coulomb's law\n", what, range.least, range.most);
    EXPECT_LT(range.error(), bound) << what;
  };
  row("one layer of 12 to 195 particles, 20 and 40 substeps", slid_range(one, usual, {20, 40}), 0.1);
  row("the same, 5 to 10 substeps", slid_range(one, usual, {5, 7, 10}), 0.2);
  row("the same, 5 substeps of 4 iterations", slid_range(iterated, usual, {5}), 0.1);
  row("the same, 1 or 2 substeps", slid_range(one, usual, {1, 2}), 0.6);
  row("one layer of 9 particles, 1 or 2 substeps", slid_range(one, tiny, {1, 2}), 1.6);
  row("the upper of two layers, 10 substeps", slid_range(two, usual, {10}), 3);
  row("the upper of two layers, 40 substeps", slid_range(two, usual, {40}), 0.5);
  two.iterations = 10;
  row("the upper of two layers, 10 substeps of 10 iterations", slid_range(two, usual, {10}), 0.5);
  row("without friction, 1 substep", slid_range(smooth, usual, {1}), 0.5);
  row("without friction, 2 to 10 substeps", slid_range(smooth, usual, {2, 5, 10}), 0.04);
}

/// The largest displacement in one of 100 steps of the particles from `first` on, m.
double creep(Simulation& simulation, std::size_t first, std::size_t end) {
  std::vector<Vec3> before = simulation.positions();
  double most = 0;
  for (int step = 0; step < 100; ++step) {
    simulation.step();
    const std::vector<Vec3> now = simulation.positions();
    for (std::size_t i = first; i < std::min(end, now.size()); ++i) most = std::max(most, length(now[i] - before[i]));
    before = now;
  }
  return most;
}

// They should be at rest: a creep of a fifth of the thickness a step would be no rest at all.
TEST(Figures, DISABLED_CreepOfTwoLayersOnASlopeThatShouldHoldThem) {
  LayersOnASlope layers;
  layers.layers = 2, layers.friction = 0.5;
  const TemporaryFolder folder;
  const Scene scene = layers.scene(folder);
  Simulation simulation = after(scene, 2);
  const double lower = creep(simulation, 169, 169 + 42), upper = creep(simulation, 169 + 42, 169 + 84);
  std::printf("the lower layer moves by up to %.1e m a step, the upper one by %.1e m\n", lower, upper);
  EXPECT_LT(std::max(lower, upper), 0.2 * LayersOnASlope::kApart);
}

// A particle that creeps through the thickness of 8 mm in a second would move by 1.3e-4 m a step. With one iteration
// half of the sheets stay below that, with four all of them stay below twice as much.
TEST(Figures, DISABLED_CreepOfTheFoldedSheet) {
  for (const int iterations : {1, 4}) {
    std::vector<double> moves;
    for (int tilt = 80; tilt <= 87; ++tilt) {
      Scene scene = load_shipped("folded_sheet");
      scene.sleep.reset();
      scene.bodies[0].transform.degrees = tilt, scene.solver.iterations = iterations;
      Simulation simulation = after(scene, 10);
      moves.push_back(creep(simulation, 0, simulation.positions().size()));
    }
    std::sort(moves.begin(), moves.end());
    std::printf("%d iterations, tilts of 80 to 87 degrees: %.1e to %.1e m a step, half of them below %.1e\n",
                iterations, moves.front(), moves.back(), (moves[3] + moves[4]) / 2);
    EXPECT_LT((moves[3] + moves[4]) / 2, 8e-3 / 60);
    if (iterations > 1) {
      EXPECT_LT(moves.back(), 2 * 8e-3 / 60);
    }
  }
}

/// The drape over the bunny without self-collision, for 1.5 s.
struct EdgedDrape {
  std::int64_t most_crossings = 0;  // after any step, counted alike with and without its edges
  double seconds = 0;               // of the processor, in steps
  EdgedDrape(int substeps, bool edges) {
    Scene scene = load_shipped("drape_bunny");
    scene.self_collision.reset(), scene.expect = {};
    scene.solver.substeps = substeps;
    scene.environment[0].edges = true;
    const Model counted_with = build_model(scene);
    scene.environment[0].edges = edges;
    Simulation simulation(scene, {.threads = 1});
    for (int step = 0; step < 90; ++step) {
      const std::clock_t start = std::clock();
      simulation.step();
      seconds += double(std::clock() - start) / CLOCKS_PER_SEC;
      const std::vector<Vec3> user = simulation.positions();
      std::vector<Vec3> x(user.size());
      for (std::size_t i = 0; i < x.size(); ++i) x[i] = user[counted_with.user_index[i]];
      most_crossings = std::max(most_crossings, count_edge_crossings(counted_with, x, simulation.solver().time()));
    }
  }
};

TEST(Figures, DISABLED_EdgesOfTheDrape) {
  for (const int substeps : {10, 30}) {
    const EdgedDrape without(substeps, false), with(substeps, true);
    std::printf("%d substeps: up to %lld crossings without edges, %lld with them, in %.1f times the time\n", substeps,
                static_cast<long long>(without.most_crossings), static_cast<long long>(with.most_crossings),
                with.seconds / without.seconds);
    EXPECT_EQ(with.most_crossings, 0) << "the promise of edges";
    EXPECT_EQ(without.most_crossings > 0, substeps == 10) << "a drop of 0.5 mm a substep at most, or of 1.6";
  }
}

}  // namespace
}  // namespace malha
