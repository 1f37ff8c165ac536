// SPDX-License-Identifier: Apache-2.0
#include "host/patch/patch_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "tests/scene_builders.h"
#include "tests/self_collision/tangles.h"

namespace malha {
namespace {

/// Checks every promise of a plan against the model, patch by patch in the order of the sweep.
class PlanChecker {
 public:
  PlanChecker(const Model& model, const PatchPlan& plan) : model_(model), plan_(plan), pinned_(pinned_of(model)) {}

  void check() {
    ASSERT_EQ(plan_.sets.size(), model_.sets.size());
    for (const ConstraintSet& set : model_.sets) seen_.emplace_back(set.count(), 0);
    slot_.assign(plan_.sets.size(), 0), index_.assign(plan_.sets.size(), 0), in_runs_.assign(plan_.sets.size(), 0);
    most_batches_.assign(plan_.sets.size(), 0);
    visits_.resize(model_.count());
    int segment = 0, batch = 0;
    for (int k = 0; k < static_cast<int>(plan_.patches.size()); ++k) {
      const Patch& patch = plan_.patches[k];
      EXPECT_EQ(patch.segment, segment);
      EXPECT_EQ(patch.batch, batch);
      segment += patch.segments, batch += patch.batches;
      check_segments(k);
      check_batches(k);
      if (testing::Test::HasFatalFailure()) return;
    }
    EXPECT_EQ(segment, static_cast<int>(plan_.segments.size()));
    EXPECT_EQ(batch, static_cast<int>(plan_.batches.size()));
    check_numbers();
    check_colours();
    check_visits();
    check_totals();
  }

 private:
  struct Visit {
    int patch;
    bool first, last;
  };

  /// Fills at_: the particle in each slot of the patch's memory.
  void check_segments(int k) {
    const Patch& patch = plan_.patches[k];
    ASSERT_LE(patch.slots, kMostSlots) << "what a LocalIndex can number";
    at_.assign(patch.slots, -1);
    std::set<int> particles;
    for (int s = patch.segment; s < patch.segment + patch.segments; ++s) {
      const Segment& segment = plan_.segments[s];
      ASSERT_GT(segment.count, 0);
      ASSERT_GE(segment.global, 0);
      ASSERT_LE(segment.global + segment.count, model_.count());
      ASSERT_GE(segment.local, 0);
      ASSERT_LE(segment.local + segment.count, patch.slots);
      for (int n = 0; n < segment.count; ++n) {
        const int i = segment.global + n;
        EXPECT_EQ(at_[segment.local + n], -1) << "two particles in one place";
        EXPECT_TRUE(particles.insert(i).second) << "particle " << i << " twice in patch " << k;
        EXPECT_EQ(segment.movable, !pinned_[i]) << "particle " << i;
        at_[segment.local + n] = i;
        visits_[i].push_back({k, segment.first_solve, segment.last_solve});
      }
    }
    std::map<int, int> origins;  // of each body
    for (int s = patch.segment; s < patch.segment + patch.segments; ++s)
      check_origin(plan_.segments[s], particles, origins);
    needed_.clear();
    present_ = std::move(particles);
  }

  /// The origin belongs to one connected body and is one of its particles, the same for all particles of the body in
  /// the patch.
  void check_origin(const Segment& segment, const std::set<int>& particles, std::map<int, int>& origins) const {
    EXPECT_TRUE(particles.count(segment.origin)) << "a stranger";
    const auto& islands = model_.patches.islands;
    const auto body_of = [&](int i) {
      return islands.empty() ? 0 : int(std::upper_bound(islands.begin(), islands.end(), i) - islands.begin()) - 1;
    };
    EXPECT_EQ(body_of(segment.global), segment.body);
    EXPECT_EQ(body_of(segment.global + segment.count - 1), segment.body);
    EXPECT_EQ(body_of(segment.origin), segment.body);
    EXPECT_EQ(origins.try_emplace(segment.body, segment.origin).first->second, segment.origin);
  }

  void check_batches(int k) {
    const Patch& patch = plan_.patches[k];
    std::vector<int> batches(plan_.sets.size(), 0);
    int set = 0, held = 0, all = 0;
    for (int b = patch.batch; b < patch.batch + patch.batches; ++b) {
      const Batch& batch = plan_.batches[b];
      ASSERT_GE(batch.set, set) << "set by set, in the order of projection";
      ASSERT_LT(batch.set, static_cast<int>(plan_.sets.size()));
      set = batch.set;
      ++batches[set];
      ASSERT_EQ(batch.slot, slot_[set]) << "batches lie one after the other";
      ASSERT_EQ(batch.slot % kSlotPack, 0);
      ASSERT_GT(batch.count, 0);
      slot_[set] += padded(batch.count);
      ASSERT_LE(slot_[set], static_cast<int>(plan_.sets[set].constraint.size()));
      const std::vector<int> members = batch.run ? check_run(batch, patch) : check_gathered(batch);
      if (testing::Test::HasFatalFailure()) return;
      EXPECT_TRUE(independent(members, model_.sets[set].particles, model_.sets[set].arity, pinned_))
          << "batch " << b << " of set " << set;
      for (int n = batch.count; n < padded(batch.count); ++n)
        EXPECT_EQ(plan_.sets[set].constraint[batch.slot + n], -1) << "padding";
      for (const int c : members) ++seen_[set][c];
      (batch.run ? held : all) += static_cast<int>(members.size());
    }
    EXPECT_TRUE(held == 0 || patch.columns) << "runs in rows";
    for (std::size_t s = 0; s < batches.size(); ++s) most_batches_[s] = std::max(most_batches_[s], batches[s]);
    EXPECT_TRUE(std::includes(present_.begin(), present_.end(), needed_.begin(), needed_.end()));
  }

  /// Batches of runs: constraint i has the particles from[j] + i.
  std::vector<int> check_run(const Batch& batch, const Patch& patch) {
    const ConstraintSet& set = model_.sets[batch.set];
    std::vector<int> members;
    for (int n = 0; n < batch.count; ++n) {
      const int c = plan_.sets[batch.set].constraint[batch.slot + n];
      if (c < 0) continue;
      members.push_back(c);
      for (int j = 0; j < set.arity; ++j) expect_at(batch.from[j] + n, set.particles[c * set.arity + j]);
    }
    in_runs_[batch.set] += static_cast<int>(members.size());
    // A pack of any width reads and writes, padding included, slots that no other end of it has.
    for (int first = 0; first < batch.count; first += kSlotPack) {
      std::set<int> touched;
      for (int j = 0; j < set.arity; ++j) {
        EXPECT_LE(batch.from[j] + first + kSlotPack, patch.slots) << "beyond the patch's memory";
        for (int lane = 0; lane < kSlotPack; ++lane)
          EXPECT_TRUE(touched.insert(batch.from[j] + first + lane).second) << "two ends at one place";
      }
    }
    return members;
  }

  std::vector<int> check_gathered(const Batch& batch) {
    const ConstraintSet& set = model_.sets[batch.set];
    const SetPlan& plan = plan_.sets[batch.set];
    std::vector<int> members;
    EXPECT_EQ(batch.index, index_[batch.set]) << "indices lie one after the other";
    EXPECT_EQ(batch.index % kSlotPack, 0);
    index_[batch.set] += padded(batch.count);
    for (int n = 0; n < batch.count; ++n) {
      const int c = plan.constraint[batch.slot + n];
      EXPECT_GE(c, 0) << "a gap";
      members.push_back(c);
      const int* of = &set.particles[c * set.arity];
      EXPECT_EQ(std::any_of(of, of + set.arity, [&](int i) { return pinned_[i]; }), batch.pins);
      for (int j = 0; j < set.arity; ++j) expect_at(plan.index[j].at(batch.index + n), of[j]);
    }
    // Padding reads and writes slots of its own.
    std::set<int> touched;
    for (int n = batch.count; n < padded(batch.count); ++n)
      for (int j = 0; j < set.arity; ++j) {
        const int place = plan.index[j].at(batch.index + n);
        EXPECT_LT(place, static_cast<int>(at_.size())) << "beyond the patch's memory";
        EXPECT_TRUE(touched.insert(place).second) << "two lanes of a pack at one place";
        expect_at(place, -1);
      }
    return members;
  }

  void expect_at(int place, int particle) {
    ASSERT_LT(place, static_cast<int>(at_.size()));
    EXPECT_EQ(at_[place], particle);
    if (particle >= 0) needed_.insert(particle);
  }

  static int padded(int count) { return (count + kSlotPack - 1) / kSlotPack * kSlotPack; }

  int colour_of(int patch) const {
    return static_cast<int>(std::upper_bound(plan_.colour_begin.begin(), plan_.colour_begin.end(), patch) -
                            plan_.colour_begin.begin()) -
           1;
  }

  /// The colours cover the patches, and within a colour no two share a movable particle. Each is one of the model's
  /// patches, and solves all of its particles.
  void check_numbers() {
    ASSERT_EQ(plan_.number.size(), plan_.patches.size());
    EXPECT_EQ(std::set<int>(plan_.number.begin(), plan_.number.end()).size(), plan_.number.size());
    for (std::size_t k = 0; k < plan_.number.size(); ++k) {
      ASSERT_LT(plan_.number[k], model_.patches.count());
      for (int i = model_.patches.begin[plan_.number[k]]; i < model_.patches.begin[plan_.number[k] + 1]; ++i)
        EXPECT_TRUE(std::any_of(visits_[i].begin(), visits_[i].end(),
                                [k](const Visit& visit) { return visit.patch == static_cast<int>(k); }))
            << "particle " << i << " in patch " << k;
    }
  }

  void check_colours() {
    ASSERT_GE(plan_.colour_begin.size(), 2u);
    EXPECT_EQ(plan_.colour_begin.front(), 0);
    EXPECT_EQ(plan_.colour_begin.back(), static_cast<int>(plan_.patches.size()));
    EXPECT_TRUE(std::is_sorted(plan_.colour_begin.begin(), plan_.colour_begin.end()));
    int width = 0;
    for (int colour = 0; colour < plan_.colours(); ++colour)
      width = std::max(width, plan_.colour_begin[colour + 1] - plan_.colour_begin[colour]);
    EXPECT_EQ(plan_.width(), width);
    for (int i = 0; i < model_.count(); ++i) {
      if (pinned_[i]) continue;
      std::set<int> colours;
      for (const Visit& visit : visits_[i])
        EXPECT_TRUE(colours.insert(colour_of(visit.patch)).second) << "particle " << i;
    }
  }

  /// Every particle is solved; in a sweep there and back, no other patch solves a movable one before the visit marked
  /// `first`, and none after the one marked `last`.
  void check_visits() {
    // The sweep goes through all colours but the last there and back, and then through the last.
    const int end = plan_.colours() - 1;
    std::vector<int> first(end + 1, -1), last(end + 1, -1);  // the times at which the sweep comes to a colour
    int when = 0;
    const auto come_to = [&](int colour) {
      if (first[colour] < 0) first[colour] = when;
      last[colour] = when++;
    };
    for (int colour = 0; colour < end; ++colour) come_to(colour);
    for (int colour = end - 1; colour >= 0; --colour) come_to(colour);
    come_to(end);
    int shared = 0;
    for (int i = 0; i < model_.count(); ++i) {
      ASSERT_FALSE(visits_[i].empty()) << "particle " << i << " is never visited";
      if (pinned_[i]) continue;
      shared += visits_[i].size() > 1;
      for (const Visit& visit : visits_[i]) {
        bool is_first = true, is_last = true;
        for (const Visit& other : visits_[i]) {
          is_first = is_first && first[colour_of(visit.patch)] <= first[colour_of(other.patch)];
          is_last = is_last && last[colour_of(visit.patch)] >= last[colour_of(other.patch)];
        }
        EXPECT_EQ(visit.first, is_first) << "particle " << i << ", patch " << visit.patch;
        EXPECT_EQ(visit.last, is_last) << "particle " << i << ", patch " << visit.patch;
      }
    }
    EXPECT_EQ(plan_.shared, shared);
  }

  void check_totals() {
    int most = 0, columns = 0;
    for (const Patch& patch : plan_.patches) most = std::max(most, patch.slots), columns += patch.columns;
    EXPECT_EQ(plan_.most_slots, most);
    EXPECT_EQ(plan_.columns, columns);
    for (std::size_t s = 0; s < plan_.sets.size(); ++s) {
      const SetPlan& set = plan_.sets[s];
      EXPECT_EQ(std::count(seen_[s].begin(), seen_[s].end(), 1), static_cast<long>(seen_[s].size()))
          << "each constraint once";
      EXPECT_EQ(slot_[s], static_cast<int>(set.constraint.size()));
      for (int j = 0; j < kMostParticles; ++j)
        EXPECT_EQ(static_cast<int>(set.index[j].size()), j < model_.sets[s].arity ? index_[s] : 0);
      EXPECT_EQ(set.in_runs, in_runs_[s]);
      EXPECT_EQ(set.most_batches, most_batches_[s]);
    }
  }

  const Model& model_;
  const PatchPlan& plan_;
  const std::vector<bool> pinned_;
  std::vector<std::vector<int>> seen_;       // of each set: how often each constraint occurred
  std::vector<int> slot_, index_, in_runs_;  // of each set
  std::vector<int> most_batches_;            // of each set
  std::vector<std::vector<Visit>> visits_;   // of each particle, in the order of the patches
  std::vector<int> at_;                      // of one patch: the particle in each slot, or -1
  std::set<int> needed_, present_;           // of one patch
};

PatchPlan expect_sound_plan(const Model& model) {
  const PatchPlan plan = plan_patches(model);
  PlanChecker(model, plan).check();
  return plan;
}

int constraints(const Model& model) {
  int sum = 0;
  for (const ConstraintSet& set : model.sets) sum += set.count();
  return sum;
}
int in_runs(const PatchPlan& plan) {
  int sum = 0;
  for (const SetPlan& set : plan.sets) sum += set.in_runs;
  return sum;
}

/// A sheet with edges, shear and hinges.
BodySpec sheet(const std::string& name, int nx, int nz, std::vector<Pin> pins = {}) {
  ConstraintSpec lengths = constraint("distance");
  lengths.elements = {"edges", "shear"};
  BodySpec spec = body(name, GridShape{{1, 1}, {nx, nz}}, {lengths, constraint("bending")});
  spec.pins = std::move(pins);
  return spec;
}

TEST(PlanPatches, OfTanglesIsSound) {
  Random random(1);
  for (const int cuts : {0, 1, 7, 40})
    for (const int reach : {25, 600}) {
      const std::vector<ConstraintSet> sets{set_of(2, tangle(1200, 2, 600, random, reach)),
                                            set_of(4, tangle(500, 4, 600, random, reach)),
                                            set_of(2, tangle(3, 2, 600, random, reach))};
      const PatchPlan plan = expect_sound_plan(model_of(
          sets, some_pinned(600, random), random, cuts == 0 ? std::vector<int>{} : random_cuts(cuts, 600, random)));
      if (cuts > 0) {
        EXPECT_EQ(static_cast<int>(plan.patches.size()), cuts + 1);
        EXPECT_GT(plan.colours(), 1);
        EXPECT_GT(plan.shared, 0);
      }
    }
}

TEST(PlanPatches, OfTanglesWithLaddersInThemIsSound) {
  // Ladders with a random shift, so that patches are laid out for runs, with pins and loose constraints among them.
  Random random(2);
  int columns = 0;
  for (int trial = 0; trial < 10; ++trial) {
    std::vector<ConstraintSet> sets;
    for (const int arity : {2, 4}) {
      std::vector<int> particles;
      for (int ladder = 0; ladder < 12; ++ladder) {
        const int from = random.below(400);
        for (int rung = 0; rung < 40; ++rung) {
          const int apart = arity == 2 && random.below(10) == 0 ? 140 : 45;  // some rungs lead elsewhere
          for (int j = 0; j < arity; ++j) particles.push_back(from + rung + apart * j);
        }
      }
      sets.push_back(set_of(arity, particles));
    }
    const PatchPlan plan = expect_sound_plan(
        model_of(sets, some_pinned(600, random), random, trial % 2 ? random_cuts(4, 600, random) : std::vector<int>{}));
    columns += plan.columns;
  }
  EXPECT_GT(columns, 0) << "there were runs to check";
}

TEST(PlanPatches, OfSheetsIsSoundAndMostlyRuns) {
  // In a sheet with rows of r, a row of a class has r / 2 particles; runs lose only the few constraints of the seams.
  for (const auto& [nx, nz] : {std::pair(1, 1), std::pair(1, 30), std::pair(6, 9), std::pair(16, 16), std::pair(45, 45),
                               std::pair(46, 46), std::pair(99, 40), std::pair(40, 99)})
    for (const bool pinned : {false, true}) {
      std::vector<Pin> pins;
      if (pinned) pins = {ListPin{{0, nx}}};
      const Model model = build_model(scene_of({sheet("sheet", nx, nz, pins)}));
      const PatchPlan plan = expect_sound_plan(model);
      if (nx < 16) continue;
      EXPECT_EQ(plan.columns, static_cast<int>(plan.patches.size())) << nx << " x " << nz;
      EXPECT_GT(in_runs(plan), 0.95 * constraints(model)) << nx << " x " << nz;
    }
}

TEST(PlanPatches, OfAStripedSheetAlternatesBetweenTwoColours) {
  const PatchPlan plan = expect_sound_plan(build_model(scene_of({sheet("sheet", 45, 200)})));
  EXPECT_GT(plan.patches.size(), 4u);
  EXPECT_EQ(plan.colours(), 2) << "a strip meets the one before and the one after";
  EXPECT_GE(2 * plan.width(), static_cast<int>(plan.patches.size()));
}

TEST(PlanPatches, OfManySmallBodiesIsSound) {
  std::vector<BodySpec> bodies;
  for (int b = 0; b < 150; ++b) {
    const std::string name = "body" + std::to_string(b);
    if (b % 3 == 0) bodies.push_back(body(name, ChainShape{{0, 0, 0}, {1, 1, 0}, 1 + b % 7}, {constraint("distance")}));
    if (b % 3 == 1) bodies.push_back(sheet(name, 1 + b % 4, 2, {ListPin{{0}}}));
    if (b % 3 == 2) bodies.push_back(body(name, LatticeShape{{0, 0, 0}, {1, 1, 1}, {1 + b % 3, 2, 1}}));
  }
  const PatchPlan plan = expect_sound_plan(build_model(scene_of(bodies)));
  EXPECT_GT(plan.patches.size(), 1u);
}

TEST(PlanPatches, OfASphereIsSound) {
  BodySpec ball = body("ball", SphereShape{0.5, 4}, {constraint("distance"), constraint("bending")});
  const PatchPlan plan = expect_sound_plan(build_model(scene_of({ball})));
  EXPECT_GT(plan.patches.size(), 1u);
  EXPECT_GT(plan.colours(), 1);
}

TEST(PlanPatches, VisitsParticlesWithoutConstraintsOnce) {
  const PatchPlan cloud =
      expect_sound_plan(build_model(scene_of({body("lattice", LatticeShape{{0, 0, 0}, {1, 1, 1}, {9, 9, 20}})})));
  EXPECT_GT(cloud.patches.size(), 1u);
  EXPECT_EQ(cloud.colours(), 1);
  EXPECT_EQ(cloud.shared, 0);
  EXPECT_EQ(cloud.segments.size(), cloud.patches.size()) << "which read and write whole packs of them";
  EXPECT_EQ(expect_sound_plan(build_model(scene_of({body("one", LatticeShape{{0, 0, 0}, {0, 0, 0}, {1, 1, 1}})})))
                .patches.size(),
            1u);
}

/// Leaves are numbered before their hub, so that each leaf's patch owns its constraint.
std::vector<int> star_with_its_hub_last(int edges) {
  std::vector<int> particles = star(edges);
  for (int& i : particles) i = edges - i;
  return particles;
}

TEST(PlanPatches, SharesPinnedParticlesAmongThePatchesOfAColour) {
  Random random(3);
  std::vector<bool> pinned(3001, false);
  pinned[3000] = true;
  const PatchPlan plan = expect_sound_plan(
      model_of({set_of(2, star_with_its_hub_last(3000))}, pinned, random, random_cuts(9, 3001, random)));
  EXPECT_EQ(plan.patches.size(), 10u);
  EXPECT_EQ(plan.colours(), 1) << "all patches read the hub, none waits for another";
  EXPECT_EQ(plan.shared, 0);
  EXPECT_EQ(plan.sets[0].most_batches, 1) << "one colour a patch, all with pins";
}

TEST(PlanPatches, VisitsThePatchesAroundAFreeHubOneAfterTheOther) {
  Random random(4);
  const PatchPlan plan = expect_sound_plan(
      model_of({set_of(2, star_with_its_hub_last(2000))}, std::vector<bool>(2001), random, {0, 500, 900, 1300, 2001}));
  EXPECT_EQ(plan.colours(), 4);
  EXPECT_EQ(plan.shared, 1);
}

TEST(PlanPatches, TakesAStarWithMoreLeavesThanALocalIndexCanNumber) {
  Random random(6);
  std::vector<bool> pinned(100001, false);
  pinned[0] = true;
  expect_sound_plan(model_of({set_of(2, star(100000))}, pinned, random));
}

TEST(PlanPatches, DependsOnTheModelAlone) {
  Random random(5);
  const Model model =
      model_of({set_of(2, tangle(9000, 2, 4000, random, 40)), set_of(4, tangle(4000, 4, 4000, random, 40))},
               some_pinned(4000, random), random, random_cuts(20, 4000, random));
  const int threads = omp_get_max_threads();
  const PatchPlan one = plan_patches(model);
  for (const int other : {1, 2, 5}) {
    omp_set_num_threads(other);
    const PatchPlan two = plan_patches(model);
    EXPECT_EQ(two.colour_begin, one.colour_begin);
    for (std::size_t s = 0; s < one.sets.size(); ++s) {
      EXPECT_EQ(two.sets[s].constraint, one.sets[s].constraint) << other << " threads";
      for (int j = 0; j < kMostParticles; ++j) EXPECT_EQ(two.sets[s].index[j], one.sets[s].index[j]);
    }
  }
  omp_set_num_threads(threads);
}

TEST(PlanPatches, StatesItsBytes) {
  const PatchPlan plan = plan_patches(build_model(scene_of({sheet("sheet", 45, 45)})));
  EXPECT_EQ(plan.bytes(), plan.patches.size() * sizeof(Patch) + plan.segments.size() * sizeof(Segment) +
                              plan.batches.size() * sizeof(Batch));
}

}  // namespace
}  // namespace malha
