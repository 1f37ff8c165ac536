// The window's camera, and what lies under the cursor.
#include <gtest/gtest.h>

#include <cmath>

#include "host/picture/view.h"
#include "host/simulation.h"
#include "tests/numbers.h"
#include "tools/view/pick.h"
#include "tools/view/side.h"

namespace malha {
namespace {

using view::OrbitCamera;
using view::Place;
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
  std::vector<Place> points;
  for (int k = 0; k < 50; ++k) points.push_back({float(5 + random()), float(3 * random()), float(random() - 7)});
  points.push_back({NAN, 0, 0});
  for (int side = 0; side < 20; ++side) {
    OrbitCamera camera;
    camera.orbit(6 * random(), 2 * random());
    const Viewport port{0, 0, 200 + 60 * side, 500};
    camera.frame(points, port.aspect());
    for (std::size_t k = 0; k + 1 < points.size(); ++k) {
      const Eigen::Vector3d at = camera.on_screen(port, {points[k][0], points[k][1], points[k][2]});
      EXPECT_TRUE(at.z() > 0 && port.holds(at.x(), at.y()));
    }
  }
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
    const Place& at = frame->x[*particle];
    const Eigen::Vector3d screen = camera.on_screen(kPort, {at[0], at[1], at[2]});
    // Edges are 0.15 m, 31 pixels here; the farthest that a corner can be from a place in its face.
    EXPECT_LT(std::hypot(screen.x() - x, screen.y() - y), 25);
  }
  EXPECT_FALSE(view::pick(*frame, camera, kPort, kPort.left + 5, kPort.top + 5));
}

TEST(ViewPick, AStrokeCrossesTheEdgesBetweenItsSides) {
  const auto frame = ball_frame();
  const OrbitCamera camera({{0, 0, 4}, {0, 0, 0}, 40});
  const double middle = kPort.left + 0.5 * kPort.width + 3;
  // Downwards over the whole ball: to its left, as it goes, lies what is right on the screen.
  const auto edges = view::crossed(*frame, camera, kPort, {middle, 0}, {middle, 700});
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
  // Half of the way crosses those that lie there.
  EXPECT_LT(view::crossed(*frame, camera, kPort, {middle, 0}, {middle, 320}).size(), expected);
}

}  // namespace
}  // namespace malha
