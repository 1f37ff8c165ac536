// SPDX-License-Identifier: Apache-2.0
// Fast contacts: no particle passes a surface, at any speed and wherever it meets it: faces, edges and vertices.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/environment/contact_bench.h"
#include "tests/scene_builders.h"

namespace malha {
namespace {

constexpr double kSpeeds[] = {1e-3, 0.1, 1, 10, 100, 1e3, 1e4};  // m/s

/// Targets of the particles on the plane y = 0: faces, and vertices and edges of a grid of 0.25 m about each target.
std::vector<Point> targets(Random& random) {
  std::vector<Point> all;
  for (int i = 0; i < 30; ++i) all.push_back({random(-0.45, 0.45), 0, random(-0.45, 0.45)});
  for (const double x : {-0.25, 0.0, 0.25})
    for (const double z : {-0.25, 0.0, 0.25}) {
      all.push_back({x, 0, z});
      all.push_back({x + 0.125, 0, z});
      all.push_back({x + 0.125, 0, z + 0.125});  // on a diagonal of the quad
    }
  return all;
}

/// Tests whether the segment from a to b goes through the square of 1 m about the axis at the height `top`.
bool leads_through(const Point& a, const Point& b, double top) {
  if ((a.y - top) * (b.y - top) > 0) return false;
  const Point at = a + (b - a) * ((top - a.y) / (b.y - a.y));
  return std::abs(at.x) < 0.5 && std::abs(at.z) < 0.5;
}

/// Shoots particles at the plane y = `top` from `side` (1: above) at `speed`, straight and slanted, and tests their
/// paths after every substep.
template <class Executor, class R>
void expect_stopped(const Executor& executor, const EnvironmentSpec& spec, double top, double side, double speed,
                    bool straight) {
  const double h = std::max(1.0 / 600, 1e-4 / speed), path = speed * h;
  Random random(static_cast<unsigned>(speed * 1000));
  std::vector<Point> x, v;
  for (const Point& target : targets(random)) {
    Point direction{0, -side, 0};
    if (!straight) direction = direction + Point{random(-0.5, 0.5), 0, random(-0.5, 0.5)};
    direction = direction * (1 / norm(direction));
    // The starts range from just outside the thickness to three substeps away, so that a substep ends in each phase of
    // the approach.
    const double away = 1.5 * spec.thickness + random(0, 3) * path;
    x.push_back(Point{target.x, top, target.z} - direction * away);
    v.push_back(direction * speed);
  }
  ContactBench<Executor, R> bench(executor, spec, x, v);
  const int substeps = static_cast<int>(std::ceil(1.5 * spec.thickness / path)) + 6;
  const double rounding = 8 * std::numeric_limits<R>::epsilon() * (1 + 3 * path);
  for (int s = 0; s < substeps; ++s) {
    bench.substep(h);
    for (int i = 0; i < bench.count(); ++i) {
      ASSERT_FALSE(leads_through(x[i], bench.x(i), top)) << "particle " << i << ", " << speed << " m/s, substep " << s;
      x[i] = bench.x(i);
    }
  }
  if (!straight) return;  // slanted particles may have slid over the edge
  for (int i = 0; i < bench.count(); ++i)
    EXPECT_NEAR((x[i].y - top) * side, spec.thickness, rounding) << "particle " << i << " at " << speed << " m/s";
}

template <class Executor, class R>
void expect_no_way_through(const Executor& executor) {
  const EnvironmentSpec plate = obstacle("plate", BoxShape{{1, 0.002, 1}, {{4, 1, 4}}});
  EnvironmentSpec sheet = obstacle("sheet", GridShape{{1, 1}, {4, 4}}, Sides::TwoSided);
  sheet.transform.translate = {-0.5, 0, -0.5};
  EnvironmentSpec front = sheet;
  front.sides = Sides::OneSided;
  for (const double speed : kSpeeds)
    for (const bool straight : {true, false}) {
      expect_stopped<Executor, R>(executor, plate, 0.001, 1, speed, straight);
      expect_stopped<Executor, R>(executor, plate, -0.001, -1, speed, straight);
      expect_stopped<Executor, R>(executor, sheet, 0, 1, speed, straight);
      expect_stopped<Executor, R>(executor, sheet, 0, -1, speed, straight);
      expect_stopped<Executor, R>(executor, front, 0, 1, speed, straight);
    }
}

TEST(Contact, LetsNothingThroughAtAnySpeedInFloat) { expect_no_way_through<Serial, float>({}); }
TEST(Contact, LetsNothingThroughAtAnySpeedInDouble) { expect_no_way_through<OpenMP, double>({2}); }

TEST(Contact, LetsNothingThroughAtTheVerticesOfACurvedSheet) {
  // A one-sided dome: rays of 160 m meet it exactly at its vertices.
  const EnvironmentSpec ball = obstacle("ball", SphereShape{1, 3}, Sides::OneSided);
  std::vector<Point> x, v;
  for (const Vec3& vertex : generate(ball.shape).points) {
    const Point out{vertex[0], vertex[1], vertex[2]};
    x.push_back(out * 80.0);
    v.push_back(out * -1e5);
  }
  ContactBench<Serial, double> bench({}, ball, x, v);
  bench.substep(1.6e-3);
  for (int i = 0; i < bench.count(); ++i) EXPECT_GT(norm(bench.x(i)), 0.99 + ball.thickness) << "vertex " << i;
}

}  // namespace
}  // namespace malha
