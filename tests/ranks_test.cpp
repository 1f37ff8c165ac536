// What malha plan --ranks counts is what patches on several machines would exchange.
#include "host/report/ranks.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "host/report/plan.h"
#include "host/solver/solver.h"
#include "tests/irregular_mesh.h"
#include "tests/irregular_sheet.h"
#include "tests/mixed_sheet.h"
#include "tests/on_host.h"
#include "tests/refusal.h"
#include "tests/run_scenes.h"
#include "tests/scene_builders.h"
#include "tests/support.h"
#include "tests/tangles.h"

namespace malha {
namespace {

/// Bytes and particles that travel before each visit of a substep to a phase, between which ranks.
struct Travels {
  std::vector<std::int64_t> bytes, particles, messages;
  int border = 0;
};

/// Every number of every particle is known to some ranks: to that which wrote it, and to those which it was sent to
/// since. Whoever else reads it gets it sent by the rank that visited the particle before. What a patch visits is told
/// from the model and its constraints, not from the segments of the plan.
class WritersOfRanks {
 public:
  /// `predicts`: visits predict and update, otherwise passes of their own do, of each particle where it was last.
  WritersOfRanks(const Model& model, const PatchPlan& plan, const std::vector<int>& rank_of, const StepShape& shape,
                 bool predicts)
      : model_(model), plan_(plan), rank_of_(rank_of), shape_(shape), predicts_(predicts), at_(model.count(), -1) {
    for (int k = 0; k < static_cast<int>(plan.patches.size()); ++k) visited_.push_back(visited(k));
    // There and back, with the turn in the last phase but one, and then the last phase.
    const int last = plan.phases() - 1;
    for (int phase = 0; phase < last; ++phase) order_.push_back(phase);
    for (int phase = last - 2; phase >= 0; --phase) order_.push_back(phase);
    order_.push_back(last);
    for (std::vector<std::set<int>>* number : {&start_, &speed_, &way_}) number->resize(model.count());
  }

  Travels of_a_substep() {
    std::vector<std::set<int>> ranks(model_.count());
    for (std::size_t k = 0; k < visited_.size(); ++k)
      for (const int i : visited_[k]) ranks[i].insert(rank_of_[k]);
    Travels travels;
    for (const int substep : {0, 1}) {  // what the first one starts from is nowhere yet
      (void)substep;
      travels = Travels{};
      for (const auto& of : ranks) travels.border += of.size() > 1;
      travels.bytes = travels.particles = travels.messages = std::vector<std::int64_t>(order_.size(), 0);
      if (!predicts_)
        for (int i = 0; i < model_.count(); ++i) way_[i] = {at_[i]};
      for (int iteration = 0; iteration < shape_.iterations; ++iteration) sweep(iteration, travels);
      for (int i = 0; i < model_.count(); ++i) start_[i] = speed_[i] = {at_[i]};
    }
    return travels;
  }

 private:
  std::set<int> visited(int k) const {
    std::set<int> all;
    const auto add = [&](int i) {
      if (model_.w[i] > 0) all.insert(i);
    };
    for (int i = model_.patches.begin[plan_.number[k]]; i < model_.patches.begin[plan_.number[k] + 1]; ++i) add(i);
    for (int b = plan_.patches[k].batch; b < plan_.patches[k].batch + plan_.patches[k].batches; ++b) {
      const Batch& batch = plan_.batches[b];
      const ConstraintSet& set = model_.sets[batch.set];
      for (int n = 0; n < batch.count; ++n)
        if (const int c = plan_.sets[batch.set].constraint[batch.slot + n]; c >= 0)
          for (int j = 0; j < set.arity; ++j) add(set.particles[c * set.arity + j]);
    }
    return all;
  }

  void sweep(int iteration, Travels& travels) {
    std::vector<int> left(model_.count(), 0);
    for (const int phase : order_) each_of(phase, [&](int, int i) { ++left[i]; });
    std::vector<bool> seen(model_.count(), false);
    for (std::size_t n = 0; n < order_.size(); ++n) {
      std::set<std::pair<int, int>> pairs;
      each_of(order_[n], [&](int k, int i) {
        const int here = rank_of_[k];
        bool travelled = false;
        const auto read = [&](std::vector<std::set<int>>& number, int numbers) {
          if (at_[i] < 0 || !number[i].insert(here).second) return;
          travels.bytes[n] += numbers * shape_.number_bytes, travelled = true;
          pairs.insert({at_[i], here});
        };
        const bool predict = predicts_ && iteration == 0 && !seen[i];
        const bool update = predicts_ && iteration + 1 == shape_.iterations && --left[i] == 0;
        read(start_, shape_.number_bytes == 4 ? 6 : 3);  // a float has what rounding lost beside it
        predict ? read(speed_, 3) : read(way_, 3);
        if (update) read(speed_, 3);
        travels.particles[n] += travelled;
        way_[i] = {here}, at_[i] = here, seen[i] = true;
      });
      travels.messages[n] += static_cast<std::int64_t>(pairs.size());
    }
  }
  template <class Work>
  void each_of(int phase, const Work& work) const {
    for (int k = plan_.phase_begin[phase]; k < plan_.phase_begin[phase + 1]; ++k)
      for (const int i : visited_[k]) work(k, i);
  }

  const Model& model_;
  const PatchPlan& plan_;
  const std::vector<int>& rank_of_;
  StepShape shape_;
  bool predicts_;
  std::vector<std::set<int>> visited_;              // movable ones
  std::vector<int> order_;                          // phases
  std::vector<int> at_;                             // the rank that visited it last; -1: none yet
  std::vector<std::set<int>> start_, speed_, way_;  // ranks that know them
};

void expect_as_recounted(const Model& model, const std::vector<int>& rank_of, int ranks, const std::string& of) {
  const PatchPlan plan = plan_patches(model);
  const RankCounts counts = count_ranks(model, plan, rank_of, ranks, 1);
  for (const bool predicts : {true, false})
    for (const int iterations : {1, 2, 3}) {
      const StepShape shape{.iterations = iterations, .number_bytes = iterations == 2 ? 8 : 4};
      const Travels travels = WritersOfRanks(model, plan, rank_of, shape, predicts).of_a_substep();
      EXPECT_EQ(counts.border, travels.border) << of;
      ASSERT_EQ(counts.visits.size(), travels.bytes.size()) << of;
      for (std::size_t n = 0; n < counts.visits.size(); ++n) {
        EXPECT_EQ(visit_bytes(counts.visits[n], shape), travels.bytes[n]) << of << ", visit " << n;
        EXPECT_EQ(counts.visits[n].travelling() * iterations, travels.particles[n]) << of;
        EXPECT_EQ(visit_messages(counts.visits[n], shape), travels.messages[n]) << of;
      }
    }
}

/// Meshes that are no grids, of some patches each.
std::vector<Model> irregular_models() {
  const TemporaryFolder folder;
  Random random(5);
  ConstraintSpec lengths = constraint("distance");
  std::vector<Model> all;
  BodySpec one = body("sheet", MeshFile{folder.write("one.obj", irregular_sheet(1, 2, 60, 110, random))},
                      {lengths, constraint("bending")});
  one.pins = {ListPin{{0, 60}}};
  all.push_back(build_model(scene_of({one})));
  BodySpec two = body("mixed", MeshFile{folder.write("two.obj", obj_of(mixed_sheet(50, true, 3)))}, {lengths});
  BodySpec three = body("other", MeshFile{folder.write("three.obj", irregular_obj(1, 1, 40, 70, 0.3, 7))}, {lengths});
  all.push_back(build_model(scene_of({two, three})));
  const Model tangled =
      model_of({set_of(2, tangle(4000, 2, 3000, random, 300)), set_of(4, tangle(900, 4, 3000, random, 90))},
               some_pinned(3000, random), random, random_cuts(30, 3000, random));
  all.push_back(tangled);
  return all;
}

std::int64_t bytes_sent_by(const RankCounts& counts, const StepShape& shape) {
  std::int64_t sum = 0;
  for (const RankVisit& visit : counts.visits) sum += visit_bytes(visit, shape);
  return sum;
}

TEST(Ranks, ExchangeWhatOneReadsAndAnotherWroteLast) {
  Random random(11);
  for (const Model& model : irregular_models()) {
    const PatchPlan plan = plan_patches(model);
    const int patches = static_cast<int>(plan.patches.size());
    ASSERT_GT(patches, 5);
    for (const int ranks : {2, 3, 5}) {
      std::vector<int> by_chance(patches);
      for (int& rank : by_chance) rank = random.below(ranks);
      expect_as_recounted(model, by_chance, ranks, "by chance");
      expect_as_recounted(model, deal_ranks(model, plan, ranks, 1).rank_of, ranks, "dealt");
    }
    std::vector<int> each(patches);
    std::iota(each.begin(), each.end(), 0);
    expect_as_recounted(model, each, patches, "a patch each");
  }
}

TEST(Ranks, ExchangeNothingWhereThereIsOne) {
  for (const Model& model : irregular_models()) {
    const RankCounts counts = deal_ranks(model, plan_patches(model), 1, 2);
    EXPECT_EQ(counts.border, 0);
    for (const RankVisit& visit : counts.visits) EXPECT_TRUE(visit.flows.empty());
    EXPECT_EQ(counts.imbalance(), 1);
    EXPECT_EQ(step_seconds(counts, {.projection_ns = 1}, {.reductions = 9}).latency, 0);
  }
}

TEST(Ranks, ExchangeNothingBetweenBodiesThatDoNotTouch) {
  const TemporaryFolder folder;
  Random random(6);
  std::vector<BodySpec> bodies;
  for (const char* name : {"a", "b"})
    bodies.push_back(body(name,
                          MeshFile{folder.write(std::string(name) + ".obj", irregular_sheet(1, 2, 50, 90, random))},
                          {constraint("distance"), constraint("bending")}));
  const Model model = build_model(scene_of(bodies));
  const PatchPlan plan = plan_patches(model);
  const RankCounts counts = deal_ranks(model, plan, 2, 1);
  EXPECT_GT(plan.shared, 0) << "patches of one body do share";
  EXPECT_EQ(counts.border, 0);
  EXPECT_EQ(bytes_sent_by(counts, {}), 0);
  EXPECT_LT(counts.imbalance(), 1.1) << "one body each";
}

TEST(Ranks, HaveTheProjectionsAndTheParticlesOfThePlanTogether) {
  for (const Model& model : irregular_models()) {
    const PatchPlan plan = plan_patches(model);
    std::int64_t constraints = 0;
    for (const ConstraintSet& set : model.sets) constraints += set.count();
    for (const int ranks : {1, 2, 5}) {
      const RankCounts counts = deal_ranks(model, plan, ranks, 2);
      std::int64_t projections = 0, patches_there = 0, patches_back = 0, particles = 0;
      for (const RankVisit& visit : counts.visits)
        for (int rank = 0; rank < ranks; ++rank) {
          projections += visit.projections[rank];
          patches_there += visit.visit.there * visit.patches[rank];
          patches_back += visit.visit.back * visit.patches[rank];
          EXPECT_GE(visit.busy[rank], visit.projections[rank]) << "threads that wait for the one with the most";
        }
      for (const int one : counts.particles) particles += one;
      EXPECT_EQ(projections, 2 * constraints) << "there and back";
      EXPECT_EQ(patches_there, static_cast<int>(plan.patches.size()));
      EXPECT_EQ(patches_back, static_cast<int>(plan.patches.size()));
      EXPECT_EQ(particles, std::count_if(model.w.begin(), model.w.end(), [](double w) { return w > 0; }));
    }
  }
}

TEST(Ranks, AreDealtTheSameWayEveryTime) {
  for (const Model& model : irregular_models()) {
    const PatchPlan plan = plan_patches(model, 2);
    const std::vector<int> once = deal_ranks(model, plan, 4, 2).rank_of;
    std::srand(99);
    EXPECT_EQ(deal_ranks(model, plan_patches(model), 4, 2).rank_of, once);
  }
}

TEST(Ranks, AreFasterAndSendLessThanThoseDealtByChance) {
  Random random(12);
  for (const Model& model : irregular_models()) {
    const PatchPlan plan = plan_patches(model);
    const int patches = static_cast<int>(plan.patches.size());
    for (int ranks = 2; ranks <= patches; ranks += 3) {
      testing::internal::CaptureStdout();
      const RankCounts dealt = deal_ranks(model, plan, ranks, 1);
      EXPECT_EQ(testing::internal::GetCapturedStdout(), "") << "what METIS says where it gives up";
      const RankMachines machines{.projection_ns = 1};
      for (int trial = 0; trial < 5; ++trial) {
        std::vector<int> by_chance(patches);
        for (int& rank : by_chance) rank = random.below(ranks);
        const RankCounts chance = count_ranks(model, plan, by_chance, ranks, 1);
        EXPECT_LE(step_seconds(dealt, machines, {}).sum(), step_seconds(chance, machines, {}).sum()) << ranks;
        EXPECT_TRUE(ranks > 2 || bytes_sent_by(dealt, {}) < bytes_sent_by(chance, {}));
      }
    }
  }
}

/// Two ranks: 100 and 60 projections, then 0 and 40; 5 particles go there and 7 back, and with all 7 and with 2 where
/// they were.
RankCounts by_hand_dealt() {
  RankCounts counts;
  counts.ranks = 2, counts.particles = {30, 20};
  counts.visits = {{{0, true, true}, {1, 1}, {100, 60}, {100, 80}, {{1, 0, 7, 7}}},
                   {{1, true, true}, {0, 1}, {0, 40}, {0, 80}, {{0, 1, 5, 2}}}};
  return counts;
}

TEST(Ranks, TakeTheTimeOfTheSlowestInEachPhase) {
  const RankMachines machines{.gbit = 8e-3, .latency_us = 3, .threads = 2, .projection_ns = 10, .particle_ns = 4};
  // 1e6 bytes/s: three floats take 12 us. Rank 0 waits for 7 ways and 7 places in the first visit, rank 1 for 5 and 2
  // in the second; a place is two times three floats.
  const RankSeconds once = step_seconds(by_hand_dealt(), machines, {.substeps = 1, .iterations = 1});
  EXPECT_NEAR(once.work, 100 * 10e-9 + 80 * 10e-9 + 30 * 4e-9, 1e-15);
  EXPECT_NEAR(once.latency, 2 * 3e-6, 1e-15);
  EXPECT_NEAR(once.bytes, (7 + 2 * 7 + 5 + 2 * 2) * 12e-6, 1e-15);
  const StepShape shape{.substeps = 5, .iterations = 3, .number_bytes = 8, .reductions = 4};
  const RankSeconds step = step_seconds(by_hand_dealt(), machines, shape);
  EXPECT_NEAR(step.work, 5 * (3 * 180 * 10e-9 + 30 * 4e-9), 1e-15);
  EXPECT_NEAR(step.latency, 5 * 3 * 2 * 3e-6 + 4 * 3e-6, 1e-15);
  EXPECT_NEAR(step.bytes, 5 * (3 * 12 + 7 + 2) * 24e-6, 1e-12);
  EXPECT_EQ(visit_bytes(by_hand_dealt().visits[1], shape), (3 * 5 + 2) * 24);
  EXPECT_NEAR(visit_seconds(by_hand_dealt().visits[1], machines, shape), 3 * (80 * 10e-9 + 3e-6) + (3 * 5 + 2) * 24e-6,
              1e-12);
  EXPECT_NEAR(by_hand_dealt().imbalance(), (100 + 40) / (80.0 + 20), 1e-12);
}

TEST(Ranks, PayFromTheSizeOnAtWhichTheyAreFaster) {
  const RankSeconds now{.work = 0.6e-3, .latency = 0.2e-3, .bytes = 0.1e-3};
  for (const double growth : {0.0, 0.5, 2.0 / 3})
    for (const double patches : {0.0, 0.3e-3})
      for (const auto& [ranks, faster] : {std::pair(2, 1.0), std::pair(16, 1.0), std::pair(16, 8.0)}) {
        const RankScaling scaling{.particles = 5000, .growth = growth, .alone = 1e-3, .patches = patches};
        const auto alone = [](double size) { return 1e-3 * size / 5000; };
        const auto together = [&, of = ranks](double size) {
          return std::max(alone(size) / of, patches) + now.latency + now.bytes * std::pow(size / 5000, growth);
        };
        const double size = particles_that_pay(scaling, now, ranks, faster);
        EXPECT_NEAR(faster * together(size), alone(size), 1e-9 * alone(size)) << ranks << " " << faster;
        EXPECT_GT(faster * together(0.9 * size), alone(0.9 * size));
      }
  EXPECT_TRUE(std::isinf(particles_that_pay({5000, 0.5, 1e-3, 0}, now, 4, 4)));
  EXPECT_EQ(particles_that_pay({5000, 0.5, 1e-3, 0}, {}, 4, 2), 1) << "nothing to wait for";
}

Json sheet_for_ranks(int cells) {
  Json scene = swinging_sheet(false);
  scene["bodies"][0]["shape"]["grid"]["cells"] = {cells, cells};
  return scene;
}

TEST(Ranks, OfAStepAreMeasuredWhereNothingIsGiven) {
  if (!scenes_run_on_host()) GTEST_SKIP() << "passes are timed on the host alone";
  Simulation simulation(parsed(sheet_for_ranks(60)), {.threads = 1});
  const RankTable table = plan_ranks(simulation, {.ranks = 3});
  EXPECT_GT(table.steps, 2);
  EXPECT_GT(table.machines.projection_ns, 0);
  ASSERT_EQ(table.rows.size(), 3u) << "1, 2 and 3";
  EXPECT_EQ(table.rows[2].counts.ranks, 3);
  EXPECT_EQ(table.not_counted, (std::vector<std::string>{"damping", "levels"}));
  EXPECT_LE(table.rows[0].seconds.sum() * 1e3, table.step_ms * 1.1) << "what one machine was measured to need";
  EXPECT_EQ(table.shape.reductions, 1 + 3) << "one for lost particles, and one a substep for damping";
}

TEST(Ranks, WhoseSpeedIsGivenTakeNoStepAndSayTheSameEveryTime) {
  const RankOptions options{.ranks = 4, .projection_ns = 2, .particle_ns = 1};
  std::string once;
  for (int time = 0; time < 2; ++time) {
    Simulation simulation(parsed(sheet_for_ranks(60)), {.threads = 1});
    const std::string text = list_ranks(plan_ranks(simulation, options));
    EXPECT_EQ(simulation.steps(), 0);
    EXPECT_TRUE(time == 0 || text == once);
    once = text;
  }
  EXPECT_TRUE(has(once, "of 1 thread each, with 100 Gbit/s and 2 us a message")) << once;
  EXPECT_TRUE(has(once, "2 ranks are faster than 1 from")) << once;
}

TEST(Ranks, AreTheSameInJson) {
  const TemporaryFolder folder;
  folder.write("scene.json", sheet_for_ranks(60).dump());
  const Ended ended = malha_command({"plan", "scene.json", "--json", "--ranks", "3", "--projection-ns", "2",
                                     "--particle-ns", "1", "--threads", "1", "--latency", "0"},
                                    folder / ".");
  ASSERT_EQ(ended.status, 0) << ended.err;
  const Json json = Json::parse(ended.out);
  EXPECT_EQ(json["particles"], 61 * 61);
  ASSERT_EQ(json["ranks"]["rows"].size(), 3u);
  Simulation simulation(parsed(sheet_for_ranks(60)), {.threads = 1});
  const RankTable table = plan_ranks(simulation, {.ranks = 3, .latency_us = 0, .projection_ns = 2, .particle_ns = 1});
  for (std::size_t n = 0; n < 3; ++n) {
    const Json& row = json["ranks"]["rows"][n];
    EXPECT_EQ(row["border_particles"], table.rows[n].counts.border);
    EXPECT_DOUBLE_EQ(row["step_ms"], table.rows[n].seconds.sum() * 1e3);
    EXPECT_EQ(row["latency_ms"], 0);
    std::int64_t bytes = 0;
    for (const Json& visit : row["visits_of_a_substep"]) bytes += visit["bytes"].get<std::int64_t>();
    EXPECT_EQ(bytes, bytes_sent_by(table.rows[n].counts, table.shape));
    EXPECT_EQ(bytes > 0, n > 0);
  }
  EXPECT_FALSE(Json::parse(plan_json(simulation)).contains("ranks"));
}

TEST(Ranks, AreNotForDesbrunsMethodNorForMoreThanThePatches) {
  Json scene = sheet_for_ranks(6);
  const Simulation small(parsed(scene), {.threads = 1});
  EXPECT_EQ(refusal([&] { require_ranks(small, 2); }),
            "malha plan: --ranks: found 2; allowed: 1 to 1, the scene's patches: a rank has whole ones");
  require_ranks(small, 1);
  const Simulation filtered(load_shipped("desbrun_sheet"), {.threads = 1});
  EXPECT_TRUE(has(refusal([&] { require_ranks(filtered, 1); }),
                  "malha plan: --ranks: found the solver \"desbrun\"; allowed: pbd; "));
}

TEST(Ranks, AreRefusedInOneLineWhereTheyCannotBeMeant) {
  const TemporaryFolder folder;
  folder.write("scene.json", sheet_for_ranks(60).dump());
  const auto answer = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"plan", "scene.json"});
    const Ended ended = malha_command(words, folder / ".");
    EXPECT_EQ(ended.status, 2);
    EXPECT_EQ(ended.out, "");
    return ended.err;
  };
  const std::string help = "; see malha plan --help\n";
  EXPECT_EQ(answer({"--ranks", "0"}),
            "malha plan: --ranks: found \"0\"; allowed: a whole number from 1 to 1048576" + help);
  EXPECT_EQ(answer({"--ranks", "2", "--bandwidth", "0"}),
            "malha plan: --bandwidth: found \"0\"; allowed: a number > 0 (Gbit/s)" + help);
  EXPECT_EQ(answer({"--ranks", "2", "--latency", "-1"}),
            "malha plan: --latency: found \"-1\"; allowed: a number >= 0 (us)" + help);
  EXPECT_EQ(answer({"--ranks", "2", "--projection-ns", "nan"}),
            "malha plan: --projection-ns: found \"nan\"; allowed: a number > 0 (ns)" + help);
  EXPECT_EQ(answer({"--latency", "2"}), "malha plan: --latency requires --ranks" + help);
  EXPECT_TRUE(has(answer({"--ranks", "1000"}), "malha plan: --ranks: found 1000; allowed: 1 to "));
}

}  // namespace
}  // namespace malha
