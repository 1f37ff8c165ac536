// SPDX-License-Identifier: Apache-2.0
// Long-range attachments: they limit the distance from a pin, and act on nothing within it.

#include "kernels/attachments/long_range.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "host/model/model.h"
#include "host/solver/solver.h"
#include "tests/constraints/mixed_sheet.h"
#include "tests/mesh/point_list.h"
#include "tests/on_host.h"
#include "tests/refusal.h"
#include "tests/same_bits.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

ConstraintSpec long_range(double limit = 0) { return stiff("long_range", {}, 1, limit); }

/// A chain of 100 links hung from above, straight at rest, that one projection a substep cannot hold.
Scene chain(bool held, const std::string& solver = "pbd", double limit = 0) {
  BodySpec body = hung_chain({0, 0, 0}, {0, -2, 0}, 100, 0.01);
  body.constraints = {stiff("distance", {"edges"})};
  if (held) body.constraints.push_back(long_range(limit));
  Scene scene = scene_of({body}, kEarth, 1.0 / 60, 2);
  scene.solver.type = solver, scene.solver.levels = 0;  // Levels would prevent the stretch too.
  scene.solver.desbrun.spring_constant = 300;
  return scene;
}

/// A cloth of 1 x 4 m hung by a short side or by two corners.
Scene cloth(bool held, bool corners, Precision precision = Precision::Double) {
  BodySpec body;
  body.name = "cloth";
  body.shape = GridShape{{1, 4}, {12, 48}};
  body.transform.axis = {1, 0, 0}, body.transform.degrees = 60;
  body.mass = 0.8;
  body.constraints = {stiff("distance", {"edges", "shear"})};
  if (held) body.constraints.push_back(long_range(0.02));
  body.pins = {RowPin{}};
  if (corners) body.pins = {ListPin{{0, 12}}};
  return scene_of({body}, kEarth, 1.0 / 60, 2, precision);
}

/// The largest excess of a particle's distance from one of its pins over its tether length, relative to that length.
double excess(const Scene& scene, const Simulation& simulation) {
  const Model model = build_model(scene);  // the simulation has released the set-up data of its own model
  const LongRangeSet& set = model.long_range;
  const std::vector<Vec3> x = simulation.positions();
  double most = 0;
  for (int item = 0; item < set.items(); ++item)
    for (int k = set.begin[item]; k < set.begin[item + 1]; ++k) {
      const Vec3 d = x[model.user_index[set.particle[item]]] - x[model.user_index[set.anchor[k]]];
      most = std::max(most, length(d) / set.max_distance[k] - 1);
    }
  return most;
}

/// A straight chain that hangs at rest already stays there: every particle is at the end of its tether, so that every
/// link has its rest length.
TEST(LongRange, HoldsAHangingChainAtItsLength) {
  EXPECT_GT(after(chain(false), 2).measure().strain_max, 0.5);
  const Simulation held = after(chain(true), 2);
  EXPECT_LT(held.measure().strain_max, 1e-12);  // rounding
  EXPECT_NEAR(held.positions()[100][1], -2, 1e-12);
}

TEST(LongRange, AllowsAChainToStretchByItsLimit) {
  const Scene scene = chain(true, "pbd", 0.05);
  const Simulation held = after(scene, 2);
  EXPECT_LT(excess(scene, held), 1e-12);
  EXPECT_NEAR(held.positions()[100][1], -2.1, 0.001) << "stretched as far as that";
}

TEST(LongRange, HoldsWhatTheFilterLeavesStretched) {
  EXPECT_GT(after(chain(false, "desbrun"), 2).measure().strain_max, 0.5);
  const Simulation held = after(chain(true, "desbrun"), 2);
  EXPECT_LT(held.measure().strain_max, 1e-12);
}

TEST(LongRange, HoldsALongClothWithTwoProjectionsAStep) {
  for (const bool corners : {false, true}) {
    Scene free = cloth(false, corners), scene = cloth(true, corners);
    free.solver.levels = scene.solver.levels = 0;  // Levels would prevent the stretch without attachments.
    const Simulation loose = after(free, 3), held = after(scene, 3);
    std::printf(
        "a cloth of 4 m by %s: farther from its pins than its reach by %.1f %% without and %.1f %% with; edges up "
        "to %.1f %% too long\n",
        corners ? "two corners" : "a side", 100 * excess(scene, loose), 100 * (excess(scene, held) + 0.02),
        100 * held.measure().strain_max);
    EXPECT_GT(excess(scene, loose), 0.15);
    EXPECT_LT(excess(scene, held), 1e-12) << "rounding, to both corners";
    EXPECT_GT(loose.measure().strain_rms, 0.08);
    EXPECT_LT(held.measure().strain_rms, 0.03);
    EXPECT_LT(held.measure().strain_max, 0.15) << "of single edges, whose ends are both within their reach";
  }
}

/// Where one tether alone is exceeded, the projection goes straight towards its pin: along the line between them where
/// the substep began, unless that is far. Where both are exceeded, it leads to a position within both. `way`: the
/// particle's displacement since the substep began, m.
template <class R>
void expect_within_both(R rounding, double way) {
  Random random(7);
  int both = 0, along_the_start = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    PointList<R> p, d(3), low(3);
    const Vector3<double> far = random.in_cube(), near = random.in_cube(), start = random.in_cube(2);
    const Vector3<double> gone = random.in_cube(1) * way;
    for (const Vector3<double>& x : {far, near, start - gone}) p.push_back(x);
    d.set(2, rounded<R>(start - to_double(p[2])));
    const double apart = norm(far - near), r = apart * random(0.1, 1);
    const R reach[] = {R(apart * random(1.02, 1.5) - r), R(r)};
    const int particle[] = {2}, begin[] = {0, 2}, anchor[] = {0, 1};
    const R w[] = {0, 0, 1};
    const auto beyond = [&](const Vector3<double>& x, int k) { return norm(x - to_double(p[k])) - double(reach[k]); };
    const double from_far = beyond(start, 0), from_near = beyond(start, 1);
    const Displaced<R> all{p.points(), d.points(), low.points()};
    const LimitTethers<R> limit{{w, particle, begin, anchor, reach}, all};
    limit(0);
    const Vector3<double> x = to_double(p[2]) + to_double(d[2]);
    EXPECT_LT(beyond(x, 0), rounding) << trial;
    EXPECT_LT(beyond(x, 1), rounding) << trial;
    if (from_far > 0) {
      // Projected along that line, it would come to the sphere about the pin, if the line enters it.
      const Vector3<double> at_first = far - (start - gone), now = far - start;
      const double cosine = dot(at_first, now) / (norm(at_first) * norm(now));
      const Vector3<double> along = at_first * (1 / norm(at_first)), closest = now - along * dot(along, now);
      const double room = double(reach[0]) * double(reach[0]) - dot(closest, closest);
      const double further = dot(along, now) - std::sqrt(std::max(room, 0.0)),
                   most = kMaxStartCorrection * double(reach[0]);
      const bool by_start = cosine > 0 && room > 0 && further <= most;
      if (std::abs(further - most) < 1e-5 || std::abs(room) < 1e-4) continue;  // rounding decides between the two
      const Vector3<double> alone = by_start ? start + along * further : start + now * (from_far / norm(now));
      if (beyond(alone, 1) < -rounding) {
        EXPECT_LT(norm(x - alone), rounding) << trial;
        along_the_start += by_start;
      }
    }
    both += from_far > 0 && from_near > 0;
  }
  EXPECT_GT(both, 500);
  EXPECT_GT(along_the_start, 5);
}

TEST(LongRange, TakesAParticleToAPlaceWithinReachOfBothPins) {
  for (const double way : {0.0, 0.1, 0.5}) {
    expect_within_both<double>(1e-13, way);
    expect_within_both<float>(3e-6f, way);  // circles of spheres that nearly touch: some roundings of 2 m
  }
}

/// A cloth of mixed triangles on two pins, with `limit` 0, is thrown about: no particle gets farther from either pin
/// than its tether.
TEST(LongRange, IsExactToBothOfTwoPins) {
  const TemporaryFolder folder;
  const int cells = 10;
  const std::string file = folder.write("sheet.obj", obj_of(mixed_sheet(cells, true, 4)));
  for (const Precision precision : {Precision::Double, Precision::Float}) {
    Scene scene = cloth(true, true, precision);
    BodySpec& body = scene.bodies[0];
    body.shape = MeshFile{file};
    body.pins = {ListPin{{0, 5 * (cells + 1) + cells}}};
    body.constraints = {stiff("distance", {"edges"}), long_range(0)};
    body.velocity = {3, 0, 1};
    Simulation simulation(scene, {.threads = 1});
    double most = 0;
    for (int step = 0; step < 30; ++step) simulation.step(), most = std::max(most, excess(scene, simulation));
    EXPECT_LT(most, precision == Precision::Double ? 1e-12 : 1e-5);  // rounding, relative to tethers of 0.05 m and more
    EXPECT_GT(most, 0.0) << "taut somewhere";
  }
}

/// The pins are drawn apart until no position is within the tethers of both.
TEST(LongRange, HoldsTheNearestPinWhereTwoContradictEachOther) {
  BodySpec body = hung_chain({0, 0, 0}, {2, 0, 0}, 20, 0.01);
  body.pins = {ListPin{{0, 20}}};
  body.constraints = {stiff("distance", {"edges"}), long_range()};
  const Scene scene = scene_of({body}, kEarth, 1.0 / 60, 2);
  Simulation simulation(scene, {.threads = 1});
  for (int step = 1; step <= 30; ++step) {
    simulation.move_pin(20, {2 + 0.02 * step, 0, 0});
    simulation.step();
  }
  const std::vector<Vec3> x = simulation.positions();
  for (int i = 1; i < 20; ++i) {
    const double at = i < 10 ? 0.1 * i : 2.6 - 0.1 * (20 - i);
    if (i == 10) continue;  // it is equally far from both pins
    EXPECT_NEAR(length(x[i] - Vec3{at, 0, 0}), 0, 1e-12) << i;
  }
}

/// A tether that is slack changes nothing: every particle stays where plain PBD puts it, bit by bit.
TEST(LongRange, DoesNothingWhereItIsSlack) {
  Scene free = chain(false), held = chain(true, "pbd", 0.5);
  for (Scene* scene : {&free, &held}) {
    scene->bodies[0].velocity = {0.3, 0.5, 0.1};
    scene->solver.substeps = 40;
  }
  Simulation a(free, {.threads = 1}), b(held, {.threads = 1});
  for (int step = 0; step < 10; ++step) a.step(), b.step();
  EXPECT_EQ(a.state_hash(), b.state_hash());
}

TEST(LongRange, FollowsPinsThatMove) {
  const Scene scene = chain(true);
  Simulation simulation(scene, {.threads = 1});
  for (int step = 1; step <= 60; ++step) {
    simulation.move_pin(0, {0.02 * step, 0, 0});
    simulation.step();
    EXPECT_LT(excess(scene, simulation), 1e-12) << step;
  }
}

TEST(LongRange, HangsOnTheNearestPinOfEveryGroup) {
  const Model row = build_model(cloth(true, false)), corners = build_model(cloth(true, true));
  EXPECT_EQ(row.long_range.items(), 12 * 48 + 48);
  EXPECT_EQ(row.long_range.anchor.size(), std::size_t(row.long_range.items()));
  EXPECT_EQ(corners.long_range.items(), 13 * 49 - 2);
  EXPECT_EQ(corners.long_range.anchor.size(), 2 * std::size_t(corners.long_range.items()));
}

TEST(LongRange, IsRefusedWithoutPins) {
  Scene scene = chain(true);
  scene.file = "s.json";
  const auto refused = [&](const std::string& found, int constraint = 1) {
    EXPECT_EQ(refusal([&] { build_model(scene); }), "s.json: /bodies/0/constraints/" + std::to_string(constraint) +
                                                        ": found " + found +
                                                        "; allowed: long-range attachments on a body with pins "
                                                        "without \"release_time\"");
  };
  ASSERT_EQ(refusal([&] { build_model(scene); }), "");
  for (Pin& pin : scene.bodies[0].pins) pin.release_time = 1;
  refused("no pin but those with a \"release_time\"");
  scene.bodies[0].pins.clear();
  refused("no pin");
  // Loose particles are not connected, so that a pin holds only itself: particle 0 is pinned for good, then particle 1
  // until its release.
  BodySpec& body = scene.bodies[0];
  body.shape = LatticeShape{{0, 0, 0}, {1, 0, 0}, {2, 1, 1}}, body.constraints = {stiff("long_range", {}, 1, 0)};
  body.pins = {ListPin{{0}}};
  refused("no particle that is connected with a pin", 0);
  body.pins.emplace_back(ListPin{{1}}).release_time = 1;
  refused("no particle that is connected with a pin but those with a \"release_time\"", 0);
}

TEST(LongRange, IsAPassOfItsOwn) {
  if (!scenes_run_on_host()) GTEST_SKIP() << "passes are timed on the host alone";
  Simulation simulation(chain(true), {.threads = 1});
  simulation.step();
  EXPECT_GT(simulation.solver().pass_seconds()[int(Pass::LongRange)], 0);
  EXPECT_EQ(simulation.solver().facts().attachments, 100);
}

INSTANTIATE_TEST_SUITE_P(
    LongRange, SameBits,
    testing::Values(SameBitsScene{"Float", [](const auto&) { return cloth(true, true, Precision::Float); }, 30, {12}},
                    SameBitsScene{
                        "Double", [](const auto&) { return cloth(true, true, Precision::Double); }, 30, {12}}),
    name_of_scene);

}  // namespace
}  // namespace malha
