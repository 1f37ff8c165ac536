// SPDX-License-Identifier: Apache-2.0
#include "host/run/checkpoint.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>

#include "host/solver/solver.h"
#include "host/solver/state.h"
#include "tests/numbers.h"
#include "tests/refusal.h"
#include "tests/scene_builders.h"
#include "tests/support.h"

namespace malha {
namespace {

namespace fs = std::filesystem;

/// A scene with every part that a checkpoint contains: two bodies, contacts, compliance, damping.
Scene falling() {
  BodySpec sheet = body("sheet", GridShape{{1, 1}, {6, 6}}, {with_compliance("distance", 1e-6), constraint("bending")});
  sheet.transform.translate = {-0.5, 0.52, -0.5};
  sheet.damping = 0.01;
  Scene scene =
      scene_of({sheet, body("balloon", SphereShape{0.2, 1}, {constraint("distance"), constraint("pressure")})},
               {obstacle("ball", SphereShape{0.5, 2})});
  scene.bodies[1].transform.translate = {0, 0.9, 0};
  scene.environment[0].motion = {{0, {0, 0, 0}, {0, 1, 0}, 0}, {1, {0, 0, 0}, {0, 1, 0}, 90}};
  scene.environment[0].friction = 0.4;
  scene.gravity = {0, -9.81, 0};
  return scene;
}

struct CheckpointFile : testing::Test {
  fs::path folder = fs::temp_directory_path() / ("malha_checkpoint_test_" + std::to_string(::getpid()));
  std::string path = (folder / "checkpoint.malha").string();
  void SetUp() override { fs::create_directories(folder); }
  void TearDown() override { fs::remove_all(folder); }

  /// Writes a checkpoint of this scene after some steps.
  void write(const Scene& scene, int steps = 3) const {
    const Model model = build_model(scene);
    const auto solver = make_solver(model, 0);
    for (int s = 0; s < steps; ++s) solver->step();
    write_checkpoint(path, scene_hash(model), {solver->save(), 7});
  }
  std::string bytes() const {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void put(const std::string& all) const { std::ofstream(path, std::ios::binary) << all; }

  /// The reason why this file cannot be read for this scene; empty if it can.
  std::string refusal(const Scene& scene) const { return refusal(build_model(scene)); }
  std::string refusal(const Model& model) const {
    return malha::refusal([&] { read_checkpoint(path, scene_hash(model)); });
  }
};

TEST_F(CheckpointFile, GivesBackTheStateAndTheFrames) {
  const Model model = build_model(falling());
  const auto solver = make_solver(model, 0);
  for (int s = 0; s < 3; ++s) solver->step();
  const std::string state = solver->save();
  write_checkpoint(path, scene_hash(model), {state, 42});
  const Checkpoint checkpoint = read_checkpoint(path, scene_hash(model));
  EXPECT_EQ(checkpoint.state, state);
  EXPECT_EQ(checkpoint.frames, 42);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 1) << "no temporary file is left";
}

TEST_F(CheckpointFile, ContinuesWithTheVerySameBitsOnAnyExecutor) {
  for (const Precision precision : {Precision::Float, Precision::Double}) {
    Scene scene = falling();
    scene.solver.precision = precision;
    const Model model = build_model(scene);
    const auto whole = make_solver(model, 0), first = make_solver(model, 2), second = make_solver(model, 3);
    for (int s = 0; s < 20; ++s) whole->step();
    for (int s = 0; s < 9; ++s) first->step();
    write_checkpoint(path, scene_hash(model), {first->save(), 0});
    second->step();  // the loaded state must replace that of this step
    second->restore(read_checkpoint(path, scene_hash(model)).state);
    EXPECT_EQ(second->steps(), 9);
    EXPECT_EQ(second->state_hash(), first->state_hash());
    for (int s = 9; s < 20; ++s) second->step();
    EXPECT_EQ(second->state_hash(), whole->state_hash());
    EXPECT_EQ(second->save(), whole->save());
    EXPECT_GT(whole->measure().contacts, 0) << "the example is one with contacts";
  }
}

TEST_F(CheckpointFile, IsReadForASceneThatDiffersInWhatStateDoesNotDependOn) {
  write(falling());
  Scene scene = falling();
  scene.name = "another";
  scene.file = "elsewhere.json";
  scene.duration = 99;
  scene.outputs.every = 5, scene.outputs.formats = {"ply"};
  scene.expect.max_speed = 1;
  EXPECT_EQ(refusal(scene), "");
}

TEST_F(CheckpointFile, OfAnotherSceneIsRefused) {
  write(falling());
  EXPECT_EQ(refusal(falling()), "");
  const std::vector<std::pair<const char*, std::function<void(Scene&)>>> changes = {
      {"dt", [](Scene& s) { s.solver.dt = 1.0 / 50; }},
      {"substeps", [](Scene& s) { s.solver.substeps = 11; }},
      {"iterations", [](Scene& s) { s.solver.iterations = 2; }},
      {"precision", [](Scene& s) { s.solver.precision = Precision::Double; }},
      {"gravity",
       [](Scene& s) {
         s.gravity = {0, -9.8, 0};
       }},
      {"wind",
       [](Scene& s) {
         s.wind = Wind{{1, 0, 0}, 0.1};
       }},
      {"mass", [](Scene& s) { s.bodies[0].mass = 2; }},
      {"pins", [](Scene& s) { s.bodies[0].pins = {ListPin{{0}}}; }},
      {"damping", [](Scene& s) { s.bodies[0].damping = 0.02; }},
      {"compliance", [](Scene& s) { s.bodies[0].constraints[0].compliance = 1e-5; }},
      {"size",
       [](Scene& s) {
         s.bodies[0].transform.scale = {2, 2, 2};
       }},
      {"a body less", [](Scene& s) { s.bodies.pop_back(); }},
      {"no environment", [](Scene& s) { s.environment.clear(); }},
      {"thickness", [](Scene& s) { s.environment[0].thickness = 0.01; }},
      {"motion", [](Scene& s) { s.environment[0].motion[1].degrees = 91; }},
      {"sides", [](Scene& s) { s.environment[0].sides = Sides::OneSided; }},
  };
  for (const auto& [what, change] : changes) {
    Scene scene = falling();
    change(scene);
    EXPECT_EQ(refusal(scene), path +
                                  ": found a checkpoint of another scene; allowed: one of this scene with the same "
                                  "bodies, pins, solver, environment, and gravity and wind at the start")
        << what;
  }
}

TEST_F(CheckpointFile, OfAnotherMeshUnderTheSameNameIsRefused) {
  const std::string mesh = (folder / "mesh.obj").string();
  const auto scene_with = [&](const std::string& text) {
    std::ofstream(mesh) << text;
    Scene scene = falling();
    scene.bodies[1].shape = MeshFile{mesh};
    scene.bodies[1].constraints = {constraint("distance")};
    return scene;
  };
  const std::string points = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n", one = "f 1 2 3\nf 1 3 4\n",
                    other = "f 1 2 4\nf 2 3 4\n";
  write(scene_with(points + one));
  EXPECT_EQ(refusal(scene_with(points + one)), "");
  EXPECT_NE(refusal(scene_with("v 0 0 0.5\nv 1 0 0\nv 1 1 0\nv 0 1 0\n" + one)), "") << "another point";
  EXPECT_NE(refusal(scene_with(points + other)), "") << "the same points joined otherwise";

  const auto sheet_with = [&](const std::string& text) {
    Scene scene = scene_with(text);
    scene.environment = {obstacle("wall", MeshFile{mesh}, Sides::TwoSided)};
    scene.bodies.pop_back();
    return scene;
  };
  write(sheet_with(points + one));
  EXPECT_EQ(refusal(sheet_with(points + one)), "");
  EXPECT_NE(refusal(sheet_with(points + other)), "") << "an environment mesh joined otherwise";
}

/// Pressure alone: no other constraint depends on how the points are connected.
TEST_F(CheckpointFile, OfAnotherSurfaceUnderPressureIsRefused) {
  const std::string mesh = (folder / "box.obj").string();
  const auto box = [&](const std::string& top) {
    std::ofstream(mesh) << "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
                           "f 1 4 3 2\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"
                        << top;
    Scene scene = falling();
    scene.bodies[1].shape = MeshFile{mesh};
    scene.bodies[1].constraints = {constraint("pressure")};
    return scene;
  };
  const std::string one = "f 5 6 7\nf 5 7 8\n", other = "f 5 6 8\nf 6 7 8\n";
  write(box(one));
  EXPECT_EQ(refusal(box(one)), "");
  EXPECT_NE(refusal(box(other)), "");
}

TEST_F(CheckpointFile, ThatIsMissingIsRefused) {
  EXPECT_NE(refusal(falling()).find(path + ": cannot read: "), std::string::npos) << refusal(falling());
}

TEST_F(CheckpointFile, ThatIsNoCheckpointIsRefused) {
  const std::string message = path + ": byte 0: found no checkpoint; allowed: a file that malha run wrote";
  for (const char* text : {"", "m", "malha checkpoint", "{\"name\": \"scene\"}"}) {
    put(text);
    EXPECT_EQ(refusal(falling()), message) << text;
  }
  put("malha checkpoint 1\nand what follows it, of any length");
  EXPECT_TRUE(has(refusal(falling()), "found 'malha checkpoint 1', of another version of malha; allowed: 'malha"))
      << refusal(falling());
}

TEST_F(CheckpointFile, WithADamagedByteIsRefusedWhereverItIs) {
  write(falling());
  const Model model = build_model(falling());
  const std::string good = bytes();
  Random random(1);
  std::vector<std::size_t> places{0, 5, 18, 19, 27, 35, 43, good.size() - 1};
  for (int i = 0; i < 50; ++i) places.push_back(static_cast<std::size_t>(random.below(static_cast<int>(good.size()))));
  for (const std::size_t place : places) {
    std::string bad = good;
    bad[place] = static_cast<char>(bad[place] ^ 1 << random.below(8));
    put(bad);
    EXPECT_NE(refusal(model), "") << "byte " << place;
  }
  put(good);
  EXPECT_EQ(refusal(model), "");
}

TEST_F(CheckpointFile, ThatIsTruncatedOrTooLongIsRefused) {
  write(falling());
  const Model model = build_model(falling());
  const std::string good = bytes();
  for (const std::size_t size : {std::size_t{0}, std::size_t{10}, std::size_t{19}, std::size_t{30}, std::size_t{43},
                                 good.size() / 2, good.size() - 1}) {
    put(good.substr(0, size));
    EXPECT_NE(refusal(model), "") << size << " bytes";
  }
  put(good + "x");
  EXPECT_NE(refusal(model), "");
}

TEST_F(CheckpointFile, ThatCannotBeWrittenIsAnErrorAndLeavesTheOldOne) {
  write(falling());
  const std::string before = bytes();
  const Model model = build_model(falling());
  EXPECT_THROW(write_checkpoint((folder / "no" / "such" / "folder").string(), scene_hash(model), {"state", 0}),
               std::runtime_error);
  EXPECT_EQ(bytes(), before);
}

constexpr GroupBox kEach{{}, {}, GroupBox::kPerParticle};

TEST(State, OfAnotherSizeIsRefused) {
  State<float> state;
  state.steps = 5;
  state.x.resize(3), state.v.resize(3), state.low.resize(3),
      state.proximity = {{kEach}, std::vector<CacheEntry>(3), {{0, {}}, {2, {}}}};
  const std::string bytes = save_state(state);
  EXPECT_EQ(load_state<float>(bytes, {3, 1}, {80}).steps, 5);
  EXPECT_THROW(load_state<float>(bytes, {4, 1}), InputError);
  EXPECT_THROW(load_state<float>(bytes, {3, 0}), InputError);
  EXPECT_THROW(load_state<double>(bytes, {3, 1}), InputError);
  EXPECT_THROW(load_state<float>(bytes.substr(1), {3, 1}), InputError);
  EXPECT_THROW(load_state<float>("", {3, 1}), InputError);
}

TEST(State, WithABoxThatIsNotFiniteIsRefused) {
  State<float> state;
  state.x.resize(70), state.v.resize(70), state.low.resize(70);  // two words
  const auto load = [&](const GroupBox& box) {
    state.proximity = {{box, kEach}, std::vector<CacheEntry>(6), {}};
    return load_state<float>(save_state(state), {70, 1}, {80}).proximity.boxes[0].half.y;
  };
  EXPECT_EQ(load({{0, 0, 0}, {1, 2, 3}, 9}), 2);
  for (const float bad : {NAN, INFINITY}) {
    EXPECT_THROW(load({{bad, 0, 0}, {1, 2, 3}, 9}), InputError);
    EXPECT_THROW(load({{0, 0, 0}, {1, bad, 3}, 9}), InputError);
  }
  EXPECT_THROW(load({{0, 0, 0}, {1, -2, 3}, 9}), InputError);
  EXPECT_THROW(load({{0, 0, 0}, {1, 2, 3}, NAN}), InputError);
  EXPECT_THROW(load(kEach), InputError) << "70 places";
}

TEST(State, HashesPositionsAndVelocitiesInTheUsersOrder) {
  State<float> state;
  state.x = {{1, 2, 3}, {4, 5, 6}}, state.v = {{0, 0, 1}, {0, 0, 2}};
  const std::uint64_t hash = hash_state(state, {0, 1});
  std::swap(state.x[0], state.x[1]), std::swap(state.v[0], state.v[1]);
  EXPECT_EQ(hash_state(state, {1, 0}), hash) << "another order of the solver is the same state";
  EXPECT_NE(hash_state(state, {0, 1}), hash);
  state.steps = 7, state.proximity = {{kEach}, std::vector<CacheEntry>(2), {{0, {}}, {1, {}}}};
  EXPECT_EQ(hash_state(state, {1, 0}), hash) << "of the motion alone";
  state.v[0][2] = -state.v[0][2];
  EXPECT_NE(hash_state(state, {1, 0}), hash);
  state.v[0][2] = -state.v[0][2];
  state.x[1][0] = std::nextafter(1.0f, 2.0f);
  EXPECT_NE(hash_state(state, {1, 0}), hash) << "a last digit";
}

}  // namespace
}  // namespace malha
