// SPDX-License-Identifier: Apache-2.0
// Warnings before the first step, by check, plan and run alike: solids that intersect themselves, and bodies that
// intersect objects. Also the warning of intersections after a run, which does not depend on its outputs.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "host/mesh/generate.h"
#include "host/mesh/topology.h"
#include "host/model/model.h"
#include "host/report/warnings.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

/// Two balls as one surface, with this distance of their centres.
MeshDataShape two_balls(double apart) {
  const Mesh ball = generate(SphereShape{0.5, 1});
  MeshDataShape both;
  for (const double at : {0.0, apart}) {
    const int first = static_cast<int>(both.points.size());
    for (const Vec3& x : ball.points) both.points.push_back({x[0] + at, x[1] + 0.1 * at, x[2] + 0.07 * at});
    for (const Triangle& t : triangles(ball)) both.faces.push_back({t[0] + first, t[1] + first, t[2] + first, -1});
  }
  return both;
}

long double volume_sign(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  long double u[3], v[3], w[3];
  for (int k = 0; k < 3; ++k) u[k] = b[k], u[k] -= a[k], v[k] = c[k], v[k] -= a[k], w[k] = d[k], w[k] -= a[k];
  return u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2]) + u[2] * (v[0] * w[1] - v[1] * w[0]);
}

/// Tests every edge against every triangle, by signs of volumes.
int edges_through_triangles(const MeshDataShape& mesh) {
  std::set<Edge> edges;
  for (const Quad& t : mesh.faces)
    for (int k = 0; k < 3; ++k) edges.insert({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
  int count = 0;
  const std::vector<Vec3>& x = mesh.points;
  for (const auto& [p, q] : edges)
    for (const Quad& t : mesh.faces) {
      if (p == t[0] || p == t[1] || p == t[2] || q == t[0] || q == t[1] || q == t[2]) continue;
      if (volume_sign(x[t[0]], x[t[1]], x[t[2]], x[p]) * volume_sign(x[t[0]], x[t[1]], x[t[2]], x[q]) >= 0) continue;
      const bool a = volume_sign(x[p], x[q], x[t[0]], x[t[1]]) > 0, b = volume_sign(x[p], x[q], x[t[1]], x[t[2]]) > 0;
      count += a == b && b == (volume_sign(x[p], x[q], x[t[2]], x[t[0]]) > 0);
    }
  return count;
}

Scene above_balls(double apart) {
  BodySpec sheet;
  sheet.name = "sheet", sheet.shape = GridShape{{1, 1}, {4, 4}}, sheet.mass = 1;
  sheet.constraints = {stiff("distance", {"edges"})}, sheet.transform.translate = {0, 2, 0};
  Scene scene = scene_of({sheet}, kEarth, 1.0 / 60, 4);
  EnvironmentSpec balls;
  balls.name = "balls", balls.shape = two_balls(apart);
  scene.environment = {balls};
  return scene;
}

TEST(SelfCrossingSolid, IsReportedWithNumberAndPositions) {
  const Scene scene = above_balls(0.6);
  const int count = edges_through_triangles(std::get<MeshDataShape>(scene.environment[0].shape));
  ASSERT_GT(count, 10);
  const Simulation simulation(scene, {.threads = 1});
  std::string said;
  for (const std::string& line : warnings(simulation.model()))
    if (has(line, "'balls'")) said += line;
  EXPECT_TRUE(has(said, " " + std::to_string(count) + " edges")) << said;
  // The balls intersect in the plane half way, at most sqrt(.5^2 - .3^2) and an edge from the axis.
  std::size_t at = said.find("near (");
  ASSERT_NE(at, std::string::npos) << said;
  double x = 0, y = 0, z = 0;
  ASSERT_EQ(std::sscanf(said.c_str() + at, "near (%lf, %lf, %lf)", &x, &y, &z), 3) << said;
  EXPECT_NEAR(x, 0.3, 0.3) << said;
  EXPECT_LT(std::hypot(y, z), 0.7) << said;
}

TEST(SelfCrossingSolid, IsNotWhatLiesBesideItself) {
  for (const double apart : {1.2, 0.0001}) {
    const Scene scene = above_balls(apart);
    ASSERT_EQ(edges_through_triangles(std::get<MeshDataShape>(scene.environment[0].shape)) > 0, apart < 1);
    const Simulation simulation(scene, {.threads = 1});
    EXPECT_EQ(simulation.model().notes.empty(), apart > 1);
  }
}

/// A sheet that keyframes move through a pinned one and out of it again, within a second.
const char* const kDrawnThrough = R"({"name": "through", "duration": 1, "solver": {"type": "pbd", "dt": 0.01},
  "self_collision": {"thickness": 0.005}, "bodies": [
   {"name": "level", "shape": {"grid": {"size": [1, 1], "cells": [4, 4]}}, "mass": 1,
    "constraints": [{"type": "distance"}], "pins": [{"box": {"min": [-1, -1, 0.1], "max": [2, 1, 2]}}]},
   {"name": "upright", "shape": {"grid": {"size": [0.4, 0.4], "cells": [4, 4]}}, "mass": 1,
    "transform": {"rotate": {"axis": [1, 0, 0], "degrees": 90}, "translate": [0.31, 0.7, 0.53]},
    "constraints": [{"type": "distance"}], "pins": [{"box": {"min": [-1, -1, -1], "max": [2, 0.65, 2]}, "motion":
     [{"time": 0}, {"time": 0.4, "translate": [0, -0.6, 0]}, {"time": 0.8}, {"time": 1}]}]}]})";

TEST(WarningOfIntersections, IsTheSameWhateverIsWritten) {
  const TemporaryFolder folder;
  folder.write("through.json", kDrawnThrough);
  std::vector<std::string> said;
  for (const std::vector<std::string>& outputs :
       {std::vector<std::string>{"--every", "0"}, {"--every", "1", "--format", "pc2"}, {"--every", "7"}}) {
    std::vector<std::string> words{"run", "through.json", "--quiet", "--no-picture", "--threads", "1"};
    words.insert(words.end(), outputs.begin(), outputs.end());
    said.push_back(malha_command(words, folder / "").err);
  }
  EXPECT_TRUE(has(said[0], "collision: ")) << said[0];
  EXPECT_TRUE(has(said[0], "crossing")) << said[0];
  EXPECT_EQ(said[1], said[0]);
  EXPECT_EQ(said[2], said[0]);
}

/// `body` intersects the box at the start.
std::string crossed_object(const std::string& edges) {
  return R"({"name": "crossed", "duration": 1, "solver": {"type": "pbd"},
  "environment": [{"name": "post", "shape": {"box": {"size": [0.05, 1, 0.05], "cells": [1, 1, 1]}}, "edges": )" +
         edges + R"(, "transform": {"translate": [0.37, 0, 0.38]}}],
  "bodies": [{"name": "sheet", "shape": {"grid": {"size": [1, 1], "cells": [4, 4]}}, "mass": 1,
              "constraints": [{"type": "distance"}]}]})";
}

TEST(Check, RefusesWhatRunAndPlanRefuse) {
  const TemporaryFolder folder;
  folder.write("crossed.json", crossed_object("true"));
  folder.write("fine.json", crossed_object("false"));
  std::string singular = crossed_object("false");
  singular.replace(singular.find(R"("pbd")"), 5, R"("desbrun", "dt": 1e6, "spring_constant": 1e12)");
  folder.write("singular.json", singular);
  for (const char* const scene : {"crossed.json", "singular.json"}) {
    const Ended check = malha_command({"check", scene}, folder / ""),
                plan = malha_command({"plan", scene}, folder / ""),
                run = malha_command({"run", scene, "--steps", "1", "--quiet"}, folder / "");
    EXPECT_NE(plan.status, 0) << scene;
    EXPECT_EQ(check.status, plan.status) << scene;
    EXPECT_EQ(check.status, run.status) << scene;
    EXPECT_EQ(check.err, plan.err);
    EXPECT_EQ(check.err, run.err);
    EXPECT_EQ(check.out, "");
  }
  EXPECT_EQ(malha_command({"check", "fine.json"}, folder / "").status, 0);
}

}  // namespace
}  // namespace malha
