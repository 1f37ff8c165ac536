// SPDX-License-Identifier: Apache-2.0
// Promises of every method, tested of Desbrun's: the same bits everywhere, resumed runs, scenes that change nothing but
// the solver's type, and no cost of features that are not named.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "host/solver/solver.h"
#include "tests/filter/filter_reference.h"
#include "tests/parallel/blocks_solvers.h"
#include "tests/run_scenes.h"

namespace malha {
namespace {

struct DesbrunKind {
  Precision precision;
  FilterKind filter;
  std::optional<Storage> storage;
  int refinements;
  const char* name;
};
void PrintTo(const DesbrunKind& kind, std::ostream* out) { *out << kind.name; }

class DesbrunBits : public testing::TestWithParam<DesbrunKind> {
 protected:
  static void set(SolverSpec& solver) {
    solver.precision = GetParam().precision;
    solver.desbrun.filter = GetParam().filter, solver.desbrun.storage = GetParam().storage;
    solver.desbrun.refinement_iterations = GetParam().refinements;
  }
  /// A hung sheet large enough for several tasks and chunks, and a rotating ball on the ground, in the wind.
  static Scene everything() {
    BodySpec sheet = sprung_sheet(26, {ListPin{{0}}}), ball = sprung_sheet(3);
    sheet.transform.translate = {0, 0.5, 0};
    sheet.constraints.push_back(stiff("distance_limit", {"edges"}, 1, 0.02));
    ball.name = "ball", ball.shape = SphereShape{0.2, 3};
    ball.transform.translate = {-0.4, 0.19, 0.3}, ball.spin = {1, 5, 2}, ball.damping = 0.1;
    ball.constraints.push_back(compliant("pressure", 3e-5, {}, 1.1));
    Scene scene = desbrun_scene({sheet, ball}, 2000);
    scene.wind = Wind{{1, 0, 0.5}, 1e-5};
    EnvironmentSpec floor;
    floor.name = "floor";
    floor.shape = GridShape{{8, 8}, {4, 4}};
    floor.transform.translate = {-4, 0, -4};
    floor.sides = Sides::TwoSided, floor.friction = 0.3;
    scene.environment = {floor};
    set(scene.solver);
    return scene;
  }
  static std::uint64_t hash(const Scene& scene, const SimulationOptions& options) {
    Simulation simulation(scene, options);
    for (int step = 0; step < 4; ++step) simulation.step();
    EXPECT_GT(simulation.measure().contacts, 0);
    return simulation.state_hash();
  }
};

TEST_P(DesbrunBits, AreTheSameOnAnyNumberOfThreads) {
  const Scene scene = everything();
  const std::uint64_t serial = hash(scene, {.threads = 1, .backend = Backend::Serial});
  for (const int threads : {1, 2, 3}) EXPECT_EQ(hash(scene, {.threads = threads}), serial) << threads << " threads";
  Scene other = scene;
  other.bodies[1].velocity[2] = 1e-6;
  EXPECT_NE(hash(other, {.threads = 1}), serial) << "which every bit of the state goes into";
}

#if defined(TESTS_BLOCKS)
TEST_P(DesbrunBits, AreTheSameOnBlocksOfThreads) {
  const Scene scene = everything();
  const std::uint64_t serial = hash(scene, {.threads = 1});
  for (const int threads : {1, 32, 128})
    EXPECT_EQ(hash_on_blocks(scene, 4, {threads}), serial) << threads << " threads";
}
#endif

TEST_P(DesbrunBits, AreTheSameWithEveryInstructionSet) {
  const std::vector<std::string> sets = instruction_sets();
  if (sets.size() == 1) GTEST_SKIP() << "one set alone: " << sets[0];
  const Scene scene = everything();
  const std::uint64_t first = hash(scene, {.threads = 1, .instructions = sets[0]});
  for (const std::string& set : sets)
    for (const int threads : {1, 2}) EXPECT_EQ(hash(scene, {.threads = threads, .instructions = set}), first) << set;
}

TEST_P(DesbrunBits, AreThoseOfTheUninterruptedRunAfterAStop) {
  const TemporaryFolder folder;
  Json scene = swinging_sheet(true);
  scene["solver"] = {{"type", "desbrun"}, {"dt", 0.02}, {"substeps", 2}, {"iterations", 3}, {"spring_constant", 300}};
  scene["solver"]["precision"] = GetParam().precision == Precision::Float ? "float" : "double";
  if (GetParam().filter != FilterKind::Auto)
    scene["solver"]["filter"] = GetParam().filter == FilterKind::Dense ? "dense" : "sparse";
  if (GetParam().storage) scene["solver"]["storage"] = "int16";
  scene["solver"]["refinement_iterations"] = GetParam().refinements;
  const auto final_hash = [&](const std::string& out) {
    return Json::parse(bytes_of(folder / (out + "/report.json")))["state_hash"];
  };
  run_quietly(scene, {.out = (folder / "whole").string()});
  const std::string parts = (folder / "parts").string();
  run_quietly(scene, {.out = parts, .steps = 7});
  run_quietly(scene, {.out = parts, .steps = 25, .resume = true});
  run_quietly(scene, {.out = parts, .resume = true});
  EXPECT_EQ(final_hash("parts"), final_hash("whole"));
  // The filter is factored anew; with another step, mass or stiffness the run would be another.
  for (const char* key : {"/solver/spring_constant", "/solver/dt", "/bodies/0/mass"}) {
    Json other = scene;
    other[Json::json_pointer(key)] = 0.01;
    EXPECT_THROW(run_quietly(other, {.out = parts, .steps = 50, .resume = true}), InputError) << key;
  }
}

INSTANTIATE_TEST_SUITE_P(
    , DesbrunBits,
    testing::Values(DesbrunKind{Precision::Float, FilterKind::Dense, {}, 0, "FloatDense"},
                    DesbrunKind{Precision::Float, FilterKind::Sparse, {}, 0, "FloatSparse"},
                    DesbrunKind{Precision::Double, FilterKind::Dense, {}, 0, "DoubleDense"},
                    DesbrunKind{Precision::Double, FilterKind::Sparse, {}, 2, "DoubleSparseRefined"},
                    DesbrunKind{Precision::Float, FilterKind::Dense, Storage::Int16, 1, "FloatInt16Refined"}),
    [](const auto& tested) { return std::string(tested.param.name); });

/// On a large mesh launches use several threads, and the sparse filter has a root.
TEST(DesbrunBitsOfALargeSheet, AreTheSameOnAnyNumberOfThreads) {
  Scene scene = desbrun_scene({sprung_sheet(100, {RowPin{}})}, 1000, Precision::Float);
  const auto hash = [&](int threads) {
    Simulation simulation(scene, {.threads = threads});
    for (int step = 0; step < 3; ++step) simulation.step();
    return simulation.state_hash();
  };
  const std::uint64_t one = hash(1);
  EXPECT_EQ(hash(2), one);
  EXPECT_EQ(hash(3), one);
#if defined(TESTS_BLOCKS)
  EXPECT_EQ(hash_on_blocks(scene, 3, {32}), one);
#endif
}

/// The shipped scenes with the type of the solver replaced.
TEST(ShippedScenes, RunWithDesbrunWhereTheTypeIsAllThatChanges) {
  int scenes = 0;
  const std::string folder = MALHA_SOURCE_DIR "/scenes";
  for (const std::string& name : shipped_scenes()) {
    Json json = Json::parse(bytes_of(folder + "/" + name + ".json"));
    json["solver"]["type"] = "desbrun";
    json["solver"].erase("levels"), json["solver"].erase("bending");  // only PBD has them
    const Scene scene = parse_scene(json.dump(), name, folder);
    bool complete = true;
    for (const EnvironmentSpec& one : scene.environment)
      if (const auto* file = std::get_if<MeshFile>(&one.shape))
        complete = complete && std::filesystem::exists(file->path);
    if (!complete) continue;  // the scans are not in the repository; scenes_test.cpp says so
    const auto lets_go = [](const BodySpec& body) {
      return std::any_of(body.pins.begin(), body.pins.end(),
                         [](const Pin& pin) { return pin.release_time.has_value(); });
    };
    // scenes with pins that are released are refused, see moved_pins_test.cpp
    if (std::any_of(scene.bodies.begin(), scene.bodies.end(), lets_go)) continue;
    if (!scene.seams.empty()) continue;  // a pressure over seams is refused, see seams_test.cpp
    ++scenes;
    Simulation simulation(scene, {.threads = 1});
    for (int step = 0; step < 3; ++step) ASSERT_NO_THROW(simulation.step()) << name;
    for (const Vec3& x : simulation.positions()) ASSERT_TRUE(std::isfinite(length(x))) << name;
    EXPECT_LT(simulation.measure().speed_max, 500) << name << ": 200 m/s are the bullets'";
    if (name != "bullets" && name != "thin_wall") {
      EXPECT_LT(simulation.measure().speed_max, 20) << name;
    }
  }
  EXPECT_GT(scenes, 12);
}

Scene loose_particles() {
  Scene scene = desbrun_scene({particle({0, 1, 0}), particle({1, 1, 0})}, 1e4, Precision::Float);
  scene.bodies[1].name = "other";
  return scene;
}

TEST(DesbrunWithoutSprings, HasNoFilterAndFallsFreely) {
  Scene scene = loose_particles();
  const Simulation simulation = after(scene, 0.5);
  const SolverStats& facts = simulation.solver().facts();
  EXPECT_FALSE(facts.filter);
  EXPECT_FALSE(simulation.solver().filter_errors());
  EXPECT_EQ(facts.spring_bytes, 0u);
  EXPECT_EQ(facts.constraint_bytes, 0u);
  EXPECT_EQ(facts.free_bodies, 0);
  for (const Pass pass : {Pass::Forces, Pass::Filter, Pass::MomentumCorrection, Pass::Projection})
    EXPECT_EQ(simulation.solver().pass_seconds()[static_cast<std::size_t>(pass)], 0) << static_cast<int>(pass);
  scene.solver.type = "pbd";
  EXPECT_EQ(simulation.state_hash(), after(scene, 0.5).state_hash()) << "as PBD has it, to the bit";
  EXPECT_EQ(facts.particle_bytes, Simulation(scene).solver().facts().particle_bytes);
}

TEST(Desbrun, SaysWhatItKeeps) {
  BodySpec free = sprung_sheet(5), hung = sprung_sheet(6, {RowPin{}});
  free.name = "free";
  Scene scene = desbrun_scene({free, hung}, 1e4, Precision::Float);
  scene.solver.desbrun.filter = FilterKind::Sparse;
  const Simulation simulation(scene, {.threads = 1});
  const SolverStats& facts = simulation.solver().facts();
  ASSERT_TRUE(facts.filter);
  EXPECT_EQ(facts.filter->kind, "sparse");
  EXPECT_EQ(facts.filter->storage, "float");
  EXPECT_EQ(facts.filter->unknowns, 6 * 5 + 7 * 5);
  EXPECT_EQ(facts.filter->bodies, 2);
  EXPECT_GE(facts.filter->bytes, 4 * static_cast<std::size_t>(facts.filter->numbers));
  EXPECT_EQ(facts.free_bodies, 1);
  EXPECT_GT(facts.spring_bytes, 0u);
  EXPECT_TRUE(facts.sets.empty()) << "springs are not projected";
  EXPECT_EQ(facts.projections_per_step, 0);
  const auto errors = simulation.solver().filter_errors();
  ASSERT_TRUE(errors);
  EXPECT_GT(errors->noise, 1e-9);
  EXPECT_LT(errors->noise, 1e-6);
  EXPECT_LT(errors->elastic, 1e-5);
}

TEST(Desbrun, CountsAToleranceOfDistanceLimitsEvenWithoutSprings) {
  BodySpec sheet = sprung_sheet(5);
  sheet.constraints = {stiff("distance_limit", {"edges"}, 1, 0.1)};
  Scene scene = desbrun_scene({sheet}, 1e4, Precision::Float);
  const std::size_t without = Simulation(scene, {.threads = 1}).solver().facts().constraint_bytes;
  scene.solver.desbrun.tolerance = 0.01;
  const std::size_t with = Simulation(scene, {.threads = 1}).solver().facts().constraint_bytes;
  EXPECT_EQ(with - without, (5 * 5 + 6 * 4) * 12u) << "two ends and a length of each edge";
}

TEST(Desbrun, MeasuresStrainAndEnergyOfItsSprings) {
  BodySpec chain = hung_chain({0, 0, 0}, {2, 0, 0}, 1);
  chain.constraints = {stiff("distance", {"edges"}, 0.5, 0.75)};
  const Measures m = Simulation(desbrun_scene({chain}, 100), {.threads = 1}).measure();
  EXPECT_TRUE(m.has_strain);
  EXPECT_DOUBLE_EQ(m.strain_max, 0.5 / 1.5);
  EXPECT_DOUBLE_EQ(m.elastic, 50 * 0.5 * 0.5 / 2);
}

}  // namespace
}  // namespace malha
