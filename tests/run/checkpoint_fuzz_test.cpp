// SPDX-License-Identifier: Apache-2.0
// Forged checkpoints with a valid hash: they are refused or continued from, never a crash, and a refused one leaves the
// simulation unchanged.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

#include "host/environment/find_contact.h"
#include "host/run/checkpoint.h"
#include "host/self_collision/self_memory.h"
#include "malha/simulation.h"
#include "malha/text.h"
#include "tests/numbers.h"
#include "tests/refusal.h"
#include "tests/scene_builders.h"
#include "tests/support.h"

namespace malha {
namespace {

/// A scene whose state has every part: contacts with two meshes, sleep, and displacements that are truncated.
Scene crowded() {
  BodySpec sheet = body("sheet", GridShape{{1, 1}, {4, 4}}, {constraint("distance"), constraint("bending")});
  sheet.transform.translate = {-0.5, 0.52, -0.5};
  Scene scene = scene_of({sheet}, {obstacle("ball", SphereShape{0.5, 1}), obstacle("other", SphereShape{0.2, 1})});
  scene.environment[1].transform.translate = {0, -1, 0};
  scene.environment[0].edges = true;
  scene.gravity = {0, -9.81, 0};
  scene.self_collision = SelfCollision{};
  scene.self_collision->thickness = 0.01;
  scene.sleep = Sleep{};
  return scene;
}

/// A sheet and a rope that tear as they are pulled.
Scene pulled_apart() {
  const std::vector<Keyframe> away = {{0, {0, 0, 0}, {0, 1, 0}, 0}, {1, {0, 0, 12}, {0, 1, 0}, 0}};
  BodySpec sheet = body("sheet", GridShape{{1, 1}, {4, 4}}, {with_compliance("distance", 1e-3)});
  Pin end(RowPin{true});
  end.motion = away;
  sheet.pins = {RowPin{false}, end};
  sheet.tear = Tear{0.3};
  BodySpec firm = body("firm", GridShape{{1, 1}, {1, 1}}, {constraint("distance")});
  firm.transform.translate = {3, 0, 0};
  return scene_of({firm, sheet}, {obstacle("ball", SphereShape{0.1, 1})});
}

struct MadeUp {
  TemporaryFolder folder;
  Scene scene;
  Simulation simulation;
  Model model;
  std::string path = folder / "checkpoint", state;
  std::uint64_t there = 0;

  explicit MadeUp(const Scene& of, int steps) : scene(of), simulation(of, {.threads = 1}), model(build_model(of)) {
    for (int s = 0; s < steps; ++s) simulation.step();
    simulation.save_checkpoint(path);
    state = read_checkpoint(path, scene_hash(model)).state;
    there = simulation.state_hash();
  }
  /// The refusal of this state; "" if it is accepted, in which case steps follow.
  std::string refusal(const std::string& bytes, std::int64_t frames = 0) {
    write_checkpoint(path, scene_hash(model), {bytes, frames});
    const std::string said = malha::refusal([&] { simulation.load_checkpoint(path); });
    if (!said.empty()) {
      EXPECT_EQ(said.find(path + ": "), 0u) << said;
      EXPECT_EQ(simulation.state_hash(), there) << said;
      return said;
    }
    try {
      for (int s = 0; s < 2; ++s) simulation.step();
      simulation.measure();
    } catch (const Diverged&) {
    }
    write_checkpoint(path, scene_hash(model), {state, 0});
    simulation.load_checkpoint(path);
    EXPECT_EQ(simulation.state_hash(), there);
    return "";
  }
  template <class T>
  T at(std::size_t byte) const {
    T value{};
    std::memcpy(&value, &state.at(byte + sizeof value - 1) - (sizeof value - 1), sizeof value);
    return value;
  }
  template <class T>
  std::string with(std::size_t at, T value) const {
    std::string changed = state;
    std::memcpy(&changed.at(at + sizeof value - 1) - (sizeof value - 1), &value, sizeof value);
    return changed;
  }
};

/// Offsets of the parts of a state of `crowded`: 25 particles, and a group of them at each of two meshes.
struct PlacesOfState {
  static constexpr std::size_t n = 25, lows = 8 + 6 * n * sizeof(float), counts = lows + 3 * n * sizeof(float),
                               boxes = counts + 16, places = boxes + 2 * sizeof(GroupBox);
  std::size_t pairs, near, rest;
  explicit PlacesOfState(const MadeUp& made) : pairs(made.at<std::int64_t>(counts + 8)) {
    EXPECT_EQ(made.at<std::int64_t>(counts), 2);
    std::size_t without = 0;
    for (const std::size_t mesh : {0, 1})
      without += made.at<GroupBox>(boxes + mesh * sizeof(GroupBox)).has_entries() ? n : 0;
    EXPECT_GT(without, 0u);
    near = places + without * sizeof(CacheEntry), rest = near + pairs * sizeof(PairRecord);
  }
};

constexpr std::int64_t kBeyond[] = {-2, 80, 1'000'000'000'000, std::numeric_limits<std::int64_t>::min()};

TEST(ForgedCheckpoint, OfATriangleThatTheMeshLacksIsRefused) {
  MadeUp made(crowded(), 5);
  const PlacesOfState of(made);
  const std::size_t n = of.n, seen = of.near, pairs = of.pairs;
  const std::size_t self = 11 * n * sizeof(float) + 24 + sizeof(SearchMemory) + 8, edges = 10 * n * sizeof(float) + 8;
  ASSERT_EQ(made.state.size(), of.rest + 16 + self + edges);
  ASSERT_GT(pairs, 0u);
  for (std::size_t k = 0; k < pairs; ++k)
    for (const std::int64_t triangle : kBeyond)
      EXPECT_TRUE(has(made.refusal(made.with(seen + k * sizeof(PairRecord) + offsetof(PairRecord, record) +
                                                 offsetof(ClosestPointRecord, triangle),
                                             triangle)),
                      "contacts: found triangle " + std::to_string(triangle) + "; allowed: -1 to 79"));
}

TEST(ForgedCheckpoint, OfPairsThatAreNotThereIsRefused) {
  MadeUp made(crowded(), 5);
  const PlacesOfState of(made);
  for (const std::int64_t many : {std::int64_t{-1}, std::int64_t{1}, std::numeric_limits<std::int64_t>::max()})
    EXPECT_TRUE(has(made.refusal(made.with(of.counts, many)), "contacts: found " + std::to_string(many)));
  for (const std::int64_t many : {std::int64_t{-1}, std::int64_t{51}, std::numeric_limits<std::int64_t>::max()})
    EXPECT_TRUE(has(made.refusal(made.with(of.counts + 8, many)), "contacts: found " + std::to_string(many)));
  EXPECT_TRUE(has(made.refusal(made.with(of.counts + 8, std::int64_t(of.pairs) - 1)), "state: found "));
  for (const std::int64_t pair : {std::int64_t{-1}, std::int64_t{50}, std::numeric_limits<std::int64_t>::min()})
    EXPECT_TRUE(has(made.refusal(made.with(of.near + (of.pairs - 1) * sizeof(PairRecord), pair)),
                    "contacts: found pair " + std::to_string(pair)));
}

TEST(ForgedCheckpoint, OfStepsThatWereNeverDoneIsRefused) {
  MadeUp made(crowded(), 5);
  const std::size_t rest = PlacesOfState(made).rest;
  for (const std::int64_t steps : {std::int64_t{-1}, std::numeric_limits<std::int64_t>::max()})
    EXPECT_TRUE(has(made.refusal(made.with(0, steps)), "steps: found " + std::to_string(steps)));
  for (const std::int64_t calm : {std::int64_t{-1}, std::int64_t{6}, std::numeric_limits<std::int64_t>::max()})
    EXPECT_TRUE(has(made.refusal(made.with(rest, calm)), "sleep: found " + std::to_string(calm) + " calm steps"));
  for (const std::int64_t since : {-2, 6})
    EXPECT_TRUE(has(made.refusal(made.with(rest + 8, since)), "sleep since step " + std::to_string(since)));
  EXPECT_TRUE(has(made.refusal(made.state, -1), "frames: found -1"));
  for (const std::int64_t serves : {-1, 2})
    EXPECT_TRUE(has(made.refusal(made.with(made.state.size() - 8, serves)), "search of edges that serves: found "));
}

TEST(ForgedCheckpoint, WithoutFiniteNumbersIsRefused) {
  MadeUp made(crowded(), 5);
  const PlacesOfState of(made);
  const std::size_t n = of.n, seen = of.near, rest = of.rest;
  for (const float bad : {NAN, INFINITY, -INFINITY, 1e30f}) {
    EXPECT_TRUE(has(made.refusal(made.with(8, bad)), "positions: found " + shown(bad) + " at particle 0"));
    EXPECT_TRUE(has(made.refusal(made.with(of.lows - 4, bad)), "velocities: found " + shown(bad) + " at particle 24"));
    EXPECT_TRUE(has(made.refusal(made.with(of.counts - 4, bad)), "remainders of positions: found " + shown(bad)));
    EXPECT_TRUE(has(made.refusal(made.with(rest + 16, bad)), "parted positions: found " + shown(bad)));
    const std::size_t ways = made.state.size() - 8 - 4 * n * sizeof(float), from = ways - 3 * n * sizeof(float);
    EXPECT_TRUE(has(made.refusal(made.with(from, bad)), "positions of a search of edges: found " + shown(bad)));
    EXPECT_TRUE(has(made.refusal(made.with(ways, bad)), "ways of a search of edges: found " + shown(bad)));
    const std::size_t distances = made.state.size() - 8 - n * sizeof(float);
    EXPECT_TRUE(has(made.refusal(made.with(distances, bad)), "contact distance: found " + shown(bad)));
    EXPECT_EQ(has(made.refusal(made.with(of.places, bad)), "contacts: found places that are no numbers"),
              !std::isfinite(bad));
    EXPECT_EQ(has(made.refusal(made.with(seen + offsetof(PairRecord, record), double(bad))),
                  "contacts: found places that are no numbers"),
              !std::isfinite(bad));
  }
}

TEST(ForgedCheckpoint, OfTearsThatCannotBeIsRefused) {
  MadeUp made(pulled_apart(), 15);
  std::uint64_t count = 0;
  std::memcpy(&count, made.state.data(), sizeof count);
  ASSERT_GT(made.simulation.tears(), 0);
  ASSERT_GT(count, 4u);
  for (const std::uint64_t many :
       {std::uint64_t{1} << 31, std::uint64_t{1} << 40, ~std::uint64_t{0}, made.state.size()})
    EXPECT_TRUE(has(made.refusal(made.with(0, many)), "tears: found " + std::to_string(many) + " numbers"));
  EXPECT_TRUE(has(made.refusal(made.with(0, count - 1)), "tears: found "));
  EXPECT_TRUE(has(made.refusal("1234567"), "state: found 7 bytes"));
  for (const int body : {-1, 0, 2, 1 << 30})
    EXPECT_TRUE(has(made.refusal(made.with(8, body)), "tears: found body " + std::to_string(body))) << "0 is firm";
  for (const int vertex : {-1, 25, 1 << 30})
    EXPECT_TRUE(has(made.refusal(made.with(12, vertex)), "tears: found vertex " + std::to_string(vertex)));
  for (const int faces : {-1, 1 << 30})
    EXPECT_TRUE(has(made.refusal(made.with(16, faces)), "tears: found a list that ends in a tear"));
  for (const int face : {-1, 16, 1 << 30})
    EXPECT_TRUE(has(made.refusal(made.with(20, face)), "tears: found face " + std::to_string(face)));
}

/// Flips bits, overwrites numbers, cuts out and duplicates pieces; counts `refused` and `taken`.
void expect_no_crash(MadeUp& made, int tries, unsigned seed) {
  Random random(seed);
  int refused = 0, taken = 0;
  const double numbers[] = {0, -1, 1, 2, 7, 25, 80, 1e9, -1e9, 1e30, -1e30, 1e-30, 1e300, NAN, INFINITY};
  for (int t = 0; t < tries; ++t) {
    std::string bytes = made.state;
    for (int changes = 1 + random.below(3); changes > 0 && !bytes.empty(); --changes) {
      const auto at = static_cast<std::size_t>(random.below(static_cast<int>(bytes.size())));
      const double number = numbers[random.below(std::size(numbers))];
      const auto put = [&](auto value) {
        const std::size_t place = at / 4 * 4;
        if (place + sizeof value <= bytes.size()) std::memcpy(&bytes[place], &value, sizeof value);
      };
      const auto whole = static_cast<std::int64_t>(std::fabs(number) < 1e18 ? number : 0x1p62);
      switch (random.below(8)) {
        case 0:
          bytes[at] = static_cast<char>(bytes[at] ^ 1 << random.below(8));
          break;
        case 1:
          put(static_cast<float>(number));
          break;
        case 2:
          put(number);
          break;
        case 3:
          put(static_cast<int>(whole % 2147483647));
          break;
        case 4:
          put(whole);
          break;
        case 5:
          put(std::int64_t{random.below(1 << 30)} << random.below(34));
          break;
        case 6:
          bytes.erase(at, static_cast<std::size_t>(random.below(9)));
          break;
        default:
          bytes.insert(at, bytes.substr(at, static_cast<std::size_t>(random.below(9))));
      }
    }
    (made.refusal(bytes).empty() ? taken : refused)++;
    if (testing::Test::HasFailure()) FAIL() << "try " << t << " of seed " << seed;
  }
  EXPECT_GT(refused, tries / 10) << "the changes are of those that matter";
  EXPECT_GT(taken, tries / 100);
}

TEST(ForgedCheckpoint, NeverCrashesWhateverIsInIt) {
  for (const Precision precision : {Precision::Float, Precision::Double}) {
    Scene crowd = crowded(), torn = pulled_apart();
    crowd.solver.precision = torn.solver.precision = precision;
    MadeUp of_crowd(crowd, 5), of_torn(torn, 15);
    expect_no_crash(of_crowd, 120, 1);
    expect_no_crash(of_torn, 120, 2);
  }
}

TEST(ForgedCheckpoint, DISABLED_NeverCrashesWhateverIsInItInManyTries) {
  for (const Precision precision : {Precision::Float, Precision::Double}) {
    Scene crowd = crowded(), torn = pulled_apart();
    crowd.solver.precision = torn.solver.precision = precision;
    MadeUp of_crowd(crowd, 5), of_torn(torn, 15);
    for (unsigned seed = 10; seed < 30; ++seed) {
      expect_no_crash(of_crowd, 500, seed);
      expect_no_crash(of_torn, 500, seed);
    }
  }
}

}  // namespace
}  // namespace malha
