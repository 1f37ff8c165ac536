// SPDX-License-Identifier: Apache-2.0
// The default camera of pictures: it frames the bodies, and nothing hides them.
#include "host/output/choose_camera.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "host/mesh/vectors.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

Camera camera_of(const Scene& scene) { return choose_camera(build_model(scene), PictureSpec{}); }

/// The position of a point in a camera's picture of 16 : 9, from -1 to 1 to the right and up; far outside for points
/// behind the camera.
std::array<double, 2> place_in_picture(const Camera& camera, const Vec3& point) {
  const auto unit = [](const Vec3& a) { return Vec3{a[0] / norm(a), a[1] / norm(a), a[2] / norm(a)}; };
  const Vec3 f = unit(minus(camera.target, camera.eye)), r = unit(cross(f, {0, 1, 0})), u = cross(r, f);
  const Vec3 d = minus(point, camera.eye);
  const double half = std::tan(camera.fov_degrees * kPi / 360), along = dot(d, f);
  if (!(along > 0)) return {100, 100};
  return {dot(d, r) / (along * half * 16 / 9), dot(d, u) / (along * half)};
}
double outermost(const Camera& camera, const std::vector<Vec3>& points) {
  double most = 0;
  for (const Vec3& point : points)
    for (const double at : place_in_picture(camera, point)) most = std::max(most, std::abs(at));
  return most;
}

/// Tests whether the segment between two points intersects the box [low, high].
bool meets_box(const Vec3& from, const Vec3& to, const Vec3& low, const Vec3& high) {
  double begin = 0, end = 1;
  for (int k = 0; k < 3; ++k) {
    const double d = to[k] - from[k], a = (low[k] - from[k]) / d, b = (high[k] - from[k]) / d;
    begin = std::max(begin, std::min(a, b)), end = std::min(end, std::max(a, b));
  }
  return begin < end;
}

TEST(TheDefaultCamera, FramesAPillowThatIsBlownUp) {
  BodySpec pillow;
  pillow.name = "pillow", pillow.mass = 0.2;
  pillow.shape = BoxShape{{1, 0.02, 1}, {{16, 1, 16}}};
  pillow.constraints = {compliant("distance", 1e-2, {"edges"}), stiff("pressure", {}, 1, 20)};
  const Scene scene = scene_of({pillow}, {}, 1.0 / 60, 20);
  const Camera camera = camera_of(scene);
  EXPECT_LT(outermost(camera, after(scene, 0.5).positions()), 1);
}

TEST(TheDefaultCamera, FramesWhatFallsToTheGroundThatIsTooLargeForThePicture) {
  BodySpec ball;
  ball.name = "ball", ball.mass = 1, ball.shape = SphereShape{0.5, 2}, ball.transform.translate = {0, 2, 0};
  ball.constraints = {stiff("distance", {"edges"}), stiff("pressure")};
  Scene scene = scene_of({ball}, kEarth, 1.0 / 60, 20);
  EnvironmentSpec ground;
  ground.name = "ground", ground.shape = GridShape{{40, 40}, {1, 1}}, ground.sides = Sides::TwoSided;
  ground.transform.translate = {-20, 0, -20};
  scene.environment = {ground};
  const Camera camera = camera_of(scene);
  EXPECT_LT(outermost(camera, build_model(scene).render_mesh.points), 1) << "where it starts";
  EXPECT_LT(outermost(camera, after(scene, 1).positions()), 1) << "where it lies";
}

TEST(TheDefaultCamera, LooksBetweenPlatesThatWouldHideABalloon) {
  BodySpec ball;
  ball.name = "balloon", ball.mass = 1, ball.shape = SphereShape{0.45, 2};
  ball.constraints = {stiff("distance", {"edges"}), stiff("pressure")};
  Scene scene = scene_of({ball}, {}, 1.0 / 60, 10);
  EnvironmentSpec plate;
  plate.shape = BoxShape{{1.6, 0.1, 1.6}, {{1, 1, 1}}};
  for (const double y : {-0.55, 0.55}) {
    plate.name = y < 0 ? "lower" : "upper", plate.transform.translate = {0, y, 0};
    scene.environment.push_back(plate);
  }
  const Camera camera = camera_of(scene);
  const std::vector<Vec3> points = build_model(scene).render_mesh.points;
  int hidden = 0;
  for (const Vec3& point : points)
    for (const double y : {-0.55, 0.55})
      hidden += meets_box(point, camera.eye, {-0.8, y - 0.05, -0.8}, {0.8, y + 0.05, 0.8});
  EXPECT_LT(hidden, 0.4 * static_cast<double>(points.size()));
  EXPECT_LT(outermost(camera, points), 1);
}

TEST(TheDefaultCamera, LooksFromTheFrontTheRightAndAboveWhereNothingHides) {
  BodySpec ball;
  ball.name = "ball", ball.mass = 1, ball.shape = SphereShape{0.5, 2};
  ball.constraints = {stiff("distance", {"edges"})};
  const Camera camera = camera_of(scene_of({ball}, kEarth, 1.0 / 60));
  const Vec3 way = minus(camera.target, camera.eye);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(way[k] / norm(way), kViewDirection[k] / norm(kViewDirection), 1e-6);
}

}  // namespace
}  // namespace malha
