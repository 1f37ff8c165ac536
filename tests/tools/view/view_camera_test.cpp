// SPDX-License-Identifier: Apache-2.0
// The window's camera, and picking under the cursor.
#include <gtest/gtest.h>

#include <cmath>

#include "host/render/view.h"
#include "malha/simulation.h"
#include "tests/numbers.h"
#include "tools/view/pick.h"
#include "tools/view/side.h"

namespace malha {
namespace {

using view::OrbitCamera;
using view::Point3f;
using view::Viewport;

const Viewport kPort{100, 20, 800, 600};

TEST(ViewCamera, SeesWhatThePicturesCameraSees) {
  const Camera camera{{2, 1.5, -3}, {0.2, 0.4, 0.1}, 35};
  const OrbitCamera orbit(camera);
  const Lens lens(camera, kPort.width, kPort.height);
  Random random(3);
  for (int k = 0; k < 100; ++k) {
    const float x = float(random(0, kPort.width)), y = float(random(0, kPort.height));
    const Eigen::Vector3f of_picture = lens.direction(x, y);
    const Eigen::Vector3d here = orbit.ray(kPort, kPort.left + x, kPort.top + y).direction;
    EXPECT_LT((here - of_picture.cast<double>()).norm(), 1e-5) << "float";
  }
}

TEST(ViewCamera, DrawsAPointWhereItLies) {
  const OrbitCamera camera({{3, 2, 3}, {0, 0, 0}, 40});
  const Eigen::Matrix4d whole = camera.projection(kPort.aspect()) * camera.view();
  Random random(5);
  for (int k = 0; k < 100; ++k) {
    const Eigen::Vector3d point(random(), random(), random());
    const Eigen::Vector3d at = camera.on_screen(kPort, point);
    const Eigen::Vector4d clip = whole * Eigen::Vector4d(point.x(), point.y(), point.z(), 1);
    EXPECT_NEAR(at.x(), kPort.left + kPort.width * (0.5 + 0.5 * clip.x() / clip.w()), 1e-6);
    EXPECT_NEAR(at.y(), kPort.top + kPort.height * (0.5 - 0.5 * clip.y() / clip.w()), 1e-6);
    EXPECT_LT((camera.at(kPort, at.x(), at.y(), at.z()) - point).norm(), 1e-9);
  }
}

TEST(ViewCamera, FramesAllPointsFromAnySide) {
  Random random(9);
  std::vector<Point3f> points;
  for (int k = 0; k < 50; ++k) points.push_back({float(5 + random()), float(3 * random()), float(random() - 7)});
  points.push_back({NAN, 0, 0});
  for (int side = 0; side < 20; ++side) {
    OrbitCamera camera;
    camera.orbit(6 * random(), 2 * random());
    const Viewport port{0, 0, 200 + 60 * side, 500};
    camera.frame(points, port.aspect());
    for (std::size_t k = 0; k + 1 < points.size(); ++k) {
      const Eigen::Vector3d at = camera.on_screen(port, {points[k][0], points[k][1], points[k][2]});
      EXPECT_TRUE(at.z() > 0 && port.contains(at.x(), at.y()));
    }
  }
}

TEST(ViewCamera, SeesTheWholeWidthOfThePictureInANarrowPort) {
  const Camera camera{{2, 1.5, -3}, {0.2, 0.4, 0.1}, 35};
  const Lens lens(camera, 1600, 900);
  for (const int width : {300, 800, 1600}) {
    const Viewport port{50, 0, width, 700};
    const OrbitCamera orbit(camera, 16.0 / 9.0, port.aspect());
    double leftmost = 1e9, rightmost = -1e9;
    for (const float x : {0.0f, 1600.0f})
      for (const float y : {0.0f, 900.0f}) {
        const Eigen::Vector3d at = orbit.on_screen(port, (lens.eye + 3 * lens.direction(x, y)).cast<double>());
        leftmost = std::min(leftmost, at.x()), rightmost = std::max(rightmost, at.x());
        EXPECT_TRUE(at.y() > -0.01 && at.y() < port.height + 0.01) << width << ": " << at.y();
      }
    EXPECT_GT(leftmost, port.left - 0.01);
    EXPECT_LT(rightmost, port.left + port.width + 0.01);
    EXPECT_NEAR((leftmost + rightmost) / 2, port.left + port.width / 2.0, 0.01);
  }
}

/// A square beside a ball of half its size, both over a wide ground.
Scene beside_a_ball(double x) {
  Scene scene;
  scene.name = "beside", scene.duration = 1;
  BodySpec body;
  body.name = "square", body.shape = GridShape{}, body.mass = 1, body.transform.translate = {x, 1, 0};
  scene.bodies = {body};
  EnvironmentSpec ball, ground;
  ball.name = "ball", ball.shape = SphereShape{0.25, 2}, ball.transform.translate = {x + 2.5, 0.5, 0};
  ball.motion.resize(1), ball.motion[0].translate = {0, 0.5, 0};  // at the start of the run
  ground.name = "ground", ground.shape = BoxShape{{100, 1, 100}, {{1, 1, 1}}},
  ground.transform.translate = {0, -1.5, 0};
  scene.environment = {ball, ground};
  return scene;
}

TEST(ViewCamera, ShowsTheBodiesOfBothSidesAndWhatTheyMayTouch) {
  view::Side one(beside_a_ball(0), {.threads = 1}), other(beside_a_ball(-3), {.threads = 1});
  const std::vector<std::shared_ptr<const view::Frame>> both{one.frame(false), other.frame(false)};
  OrbitCamera camera;
  camera.frame(view::points_to_frame(both), kPort.aspect());
  const auto shows = [&](double x, double y, double z) {
    const Eigen::Vector3d at = camera.on_screen(kPort, {x, y, z});
    return at.z() > 0 && kPort.contains(at.x(), at.y());
  };
  for (const auto& frame : both)
    for (const Point3f& x : frame->x) EXPECT_TRUE(shows(x[0], x[1], x[2]));
  for (const double ball : {2.5, -0.5})
    for (const double side : {-0.25, 0.25}) EXPECT_TRUE(shows(ball + side, 1, 0) && shows(ball, 1 + side, 0));
  EXPECT_TRUE(shows(0.5, -1, 0.5)) << "the ground below the square";
  EXPECT_LT(camera.distance(), 30) << "m, and not all of the ground";
}

TEST(ViewCamera, PanKeepsTheGraspedPointUnderTheCursor) {
  OrbitCamera camera({{0, 0, 5}, {0, 0, 0}, 40});
  const Eigen::Vector3d point = camera.at(kPort, 300, 200, camera.distance());
  camera.pan(90.0 / kPort.height, -30.0 / kPort.height);
  const Eigen::Vector3d at = camera.on_screen(kPort, point);
  EXPECT_NEAR(at.x(), 390, 1e-6);
  EXPECT_NEAR(at.y(), 230, 1e-6);
}

std::shared_ptr<const view::Frame> ball_frame() {
  Scene scene;
  scene.name = "ball";
  BodySpec body;
  body.name = "ball", body.shape = SphereShape{1, 3}, body.mass = 1;
  scene.bodies = {body};
  return view::Side(scene, {}).frame(false);
}

TEST(ViewPick, TakesTheFrontOfABallAndNothingBesideIt) {
  const auto frame = ball_frame();
  const OrbitCamera camera({{0, 0, 4}, {0, 0, 0}, 40});
  Random random(11);
  for (int k = 0; k < 100; ++k) {
    const double x = random(0.5 * kPort.width - 100, 0.5 * kPort.width + 100) + kPort.left;
    const double y = random(0.5 * kPort.height - 100, 0.5 * kPort.height + 100) + kPort.top;
    const std::optional<int> particle = view::pick(*frame, camera, kPort, x, y);
    ASSERT_TRUE(particle);
    EXPECT_GT(frame->x[*particle][2], 0) << "the side that is seen";
    const Point3f& at = frame->x[*particle];
    const Eigen::Vector3d screen = camera.on_screen(kPort, {at[0], at[1], at[2]});
    // Edges are 0.15 m, 31 pixels here; that is the largest distance of a point in a face from a corner.
    EXPECT_LT(std::hypot(screen.x() - x, screen.y() - y), 25);
  }
  EXPECT_FALSE(view::pick(*frame, camera, kPort, kPort.left + 5, kPort.top + 5));
}

TEST(ViewPick, AStrokeCrossesTheEdgesBetweenItsSides) {
  const auto frame = ball_frame();
  const OrbitCamera camera({{0, 0, 4}, {0, 0, 0}, 40});
  const double middle = kPort.left + 0.5 * kPort.width + 3;
  // The stroke goes downwards over the whole ball.
  const auto edges = view::edges_crossed(*frame, camera, kPort, {middle, 0}, {middle, 700});
  std::size_t expected = 0;
  const auto right = [&](int i) {
    return camera.on_screen(kPort, {frame->x[i][0], frame->x[i][1], frame->x[i][2]}).x() > middle;
  };
  for (const auto& [a, b] : frame->body->edges) expected += right(int(a)) != right(int(b));
  ASSERT_GT(expected, 20u);
  EXPECT_EQ(edges.size(), expected);
  for (const auto& [left_of_it, right_of_it] : edges) {
    EXPECT_TRUE(right(left_of_it));
    EXPECT_FALSE(right(right_of_it));
  }
  // Half of the stroke crosses those that lie there.
  EXPECT_LT(view::edges_crossed(*frame, camera, kPort, {middle, 0}, {middle, 320}).size(), expected);
}

}  // namespace
}  // namespace malha
