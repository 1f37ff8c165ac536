// SPDX-License-Identifier: Apache-2.0
#include "host/render/picture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "host/render/stage.h"

namespace malha {
namespace {

using P = std::array<float, 3>;
constexpr double kPi = std::numbers::pi;
constexpr float kNoNumber = std::numeric_limits<float>::quiet_NaN();
const P kRed{0.9f, 0.1f, 0.1f}, kBlue{0.1f, 0.1f, 0.9f};

/// A sphere of quads between meridians and parallels, triangles at the poles.
Drawing sphere(P centre, float radius, int rings, P colour = kRed) {
  Drawing drawing;
  drawing.colour = colour;
  const int around = 2 * rings;
  for (int j = 0; j <= rings; ++j) {
    for (int i = 0; i < around; ++i) {
      const double t = kPi * j / rings, f = kPi * i / rings;
      drawing.points.push_back({centre[0] + radius * float(std::sin(t) * std::cos(f)),
                                centre[1] + radius * float(std::cos(t)),
                                centre[2] + radius * float(std::sin(t) * std::sin(f))});
    }
  }
  const auto at = [&](int j, int i) { return j * around + (j == 0 || j == rings ? 0 : i % around); };  // one at a pole
  for (int j = 0; j < rings; ++j) {
    for (int i = 0; i < around; ++i) {
      if (j > 0) drawing.triangles.push_back({at(j, i), at(j, i + 1), at(j + 1, i + 1)});
      if (j + 1 < rings) drawing.triangles.push_back({at(j, i), at(j + 1, i + 1), at(j + 1, i)});
    }
  }
  return drawing;
}

/// A square of side 2 `half` in the plane z = `z`, one quad, seen from +z counter-clockwise.
Drawing square(float half, float z, P colour) {
  Drawing drawing;
  drawing.points = {{-half, -half, z}, {half, -half, z}, {half, half, z}, {-half, half, z}};
  add_faces(drawing, std::vector<Quad>{{0, 1, 2, 3}});
  drawing.wire = false;
  drawing.colour = colour;
  return drawing;
}

Camera from_front(double distance) { return {{0, 0, distance}, {0, 0, 0}, 40}; }

std::array<int, 3> pixel(const Image& image, int x, int y) {
  const unsigned char* p = &image.pixels[std::size_t{3} * (y * static_cast<std::size_t>(image.width) + x)];
  return {p[0], p[1], p[2]};
}

int brightness(const Image& image, int x, int y) {
  const auto p = pixel(image, x, y);
  return p[0] + p[1] + p[2];
}

/// Colours keep their hue in light and shadow, and the background is grey.
bool is_red(const Image& image, int x, int y) {
  const auto p = pixel(image, x, y);
  return 2 * p[0] > 3 * p[2];
}

bool is_blue(const Image& image, int x, int y) {
  const auto p = pixel(image, x, y);
  return 2 * p[2] > 3 * p[0];
}

int red_pixels(const Image& image) {
  int count = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) count += is_red(image, x, y);
  }
  return count;
}

TEST(Picture, SilhouetteOfASphereHasTheAreaOfItsProjection) {
  const double radius = 0.6, distance = 3, height = 300;
  const auto image = render(std::vector{sphere({0, 0, 0}, float(radius), 60)}, from_front(distance), 400, 300, 2);
  // A sphere is seen under the half angle asin(R / d); on the image plane at distance 1 it is a disc.
  const double disc = std::tan(std::asin(radius / distance)), pixel_side = 2 * std::tan(20 * kPi / 180) / height;
  const double expected = kPi * disc * disc / (pixel_side * pixel_side);
  // 60 rings lie at most 1 - cos(pi / 120) = 0.03 % inside the sphere; the rest of the error is at the outline, whose
  // pixels each count whole or not at all: on average half a pixel too much or too little, all around.
  const double outline = 2 * kPi * disc / pixel_side;
  EXPECT_NEAR(red_pixels(image), expected, 0.5 * outline);
  EXPECT_TRUE(is_red(image, 200, 150));
  EXPECT_FALSE(is_red(image, 5, 5));
}

TEST(Picture, NearestDrawingWinsInAnyOrder) {
  const auto near = square(0.3f, 0.5f, kRed), far = square(0.6f, 0, kBlue);
  for (const auto& drawings : {std::vector{near, far}, std::vector{far, near}}) {
    const auto image = render(drawings, from_front(3), 160, 120, 1);
    EXPECT_TRUE(is_red(image, 80, 60));
    EXPECT_TRUE(is_blue(image, 54, 60));
    EXPECT_FALSE(is_red(image, 2, 60) || is_blue(image, 2, 60));
  }
}

TEST(Picture, BothSidesOfASheetAreSeen) {
  const auto sheet = square(1, 0, kRed);
  EXPECT_TRUE(is_red(render(std::vector{sheet}, {{0, 0, 3}, {0, 0, 0}, 40}, 80, 60, 1), 40, 30));
  EXPECT_TRUE(is_red(render(std::vector{sheet}, {{0, 0, -3}, {0, 0, 0}, 40}, 80, 60, 1), 40, 30));
}

TEST(Picture, SameBitsOnAnyNumberOfThreads) {
  auto rods = square(1, -1, kBlue);
  rods.points.insert(rods.points.end(), {{-1, 1, 0.5f}, {0, 0.8f, 0.5f}, {1, 1, 0.5f}, {0.8f, -0.8f, 0.5f}});
  rods.lines = {{4, 5}, {5, 6}};
  rods.loose = true;
  const std::vector drawings{sphere({0, 0, 0}, 0.7f, 12), rods};
  const auto one = render(drawings, from_front(4), 160, 120, 1);
  for (const int threads : {2, 3, 8}) EXPECT_EQ(render(drawings, from_front(4), 160, 120, threads).pixels, one.pixels);
}

TEST(Picture, IsNoneAfterItIsStopped) {
  const std::vector drawings{sphere({0, 0, 0}, 1, 20)};
  std::atomic<bool> stop{false};
  EXPECT_EQ(render(drawings, from_front(4), 40, 30, 2, &stop).pixels,
            render(drawings, from_front(4), 40, 30, 2).pixels);
  stop = true;
  EXPECT_TRUE(render(drawings, from_front(4), 40, 30, 2, &stop).pixels.empty());
}

TEST(Picture, ABallCastsAShadowOnTheFloorAwayFromTheLight) {
  Drawing floor;
  floor.points = {{-5, 0, -5}, {-5, 0, 5}, {5, 0, 5}, {5, 0, -5}};
  floor.triangles = {{0, 1, 2}, {0, 2, 3}};
  const Camera above{{0, 8, 0.01}, {0, 0, 0}, 40};
  const auto ball = sphere({0, 1, 0}, 0.5f, 30);
  const auto with = render(std::vector{floor, ball}, above, 200, 200, 2);
  const auto without = render(std::vector{floor}, above, 200, 200, 2);
  int left = 0, right = 0;  // floor pixels that the ball darkens, on either side; the light comes from the left
  for (int y = 0; y < 200; ++y) {
    for (int x = 0; x < 200; ++x) {
      const bool darker = !is_red(with, x, y) && brightness(with, x, y) < 0.8 * brightness(without, x, y);
      (x < 100 ? left : right) += darker;
    }
  }
  EXPECT_GT(right, 100);
  EXPECT_GT(right, 3 * left);
}

TEST(Picture, WiresShowTheEdgesOfQuadsButNotTheirDiagonals) {
  auto sheet = square(1, 0, {0.7f, 0.7f, 0.7f});
  const auto plain = render(std::vector{sheet}, from_front(2), 200, 200, 1);
  sheet.wire = true;
  const auto wired = render(std::vector{sheet}, from_front(2), 200, 200, 1);
  EXPECT_EQ(pixel(wired, 100, 100), pixel(plain, 100, 100));  // the diagonal passes through the middle
  sheet.hidden.clear();                                       // shows the diagonal
  const auto all = render(std::vector{sheet}, from_front(2), 200, 200, 1);
  EXPECT_LT(brightness(all, 100, 100), 0.9 * brightness(plain, 100, 100));

  Drawing two;  // two quads that share the edge x = 0
  two.points = {{-1, -1, 0}, {0, -1, 0}, {1, -1, 0}, {-1, 1, 0}, {0, 1, 0}, {1, 1, 0}};
  add_faces(two, std::vector<Quad>{{0, 1, 4, 3}, {1, 2, 5, 4}});
  EXPECT_TRUE(two.wire);
  two.colour = sheet.colour;
  const auto halves = render(std::vector{two}, from_front(2), 200, 200, 1);
  EXPECT_LT(brightness(halves, 100, 100), 0.9 * brightness(plain, 100, 100));
  EXPECT_EQ(pixel(halves, 120, 100), pixel(plain, 120, 100));
}

TEST(Picture, RodsAndBallsAreDrawn) {
  Drawing drawing;
  drawing.colour = kRed;
  drawing.points = {{-0.5f, 0, 0}, {0.5f, 0, 0}, {0, 0.5f, 0}};
  drawing.lines = {{0, 1}};
  auto image = render(std::vector{drawing}, from_front(2), 400, 400, 1);
  const int rod = red_pixels(image);
  EXPECT_TRUE(is_red(image, 200, 200) || is_red(image, 200, 199));
  drawing.loose = true;
  image = render(std::vector{drawing}, from_front(2), 400, 400, 1);
  EXPECT_GT(red_pixels(image), rod + 4);  // the point above, and only it: the rod's ends are in use
  const int above = 200 - static_cast<int>(std::lround(0.5 / 2 / (2 * std::tan(20 * kPi / 180) / 400)));
  EXPECT_TRUE(is_red(image, 200, above));
}

TEST(Picture, NothingAndDegenerateDrawingsLeaveTheBackground) {
  const auto empty = render({}, from_front(3), 64, 48, 2);
  ASSERT_EQ(empty.pixels.size(), 64u * 48 * 3);
  Drawing bad;
  bad.loose = true;
  bad.wire = true;
  bad.points = {{0, 0, 0}, {0, 0, 0},         {1, 0, 0},
                {2, 0, 0}, {kNoNumber, 0, 0}, {0, std::numeric_limits<float>::infinity(), 0}};
  bad.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 0, 0}, {0, 2, 4}, {2, 3, 5}};  // no area, or not finite
  bad.lines = {{4, 5}, {0, 4}};
  EXPECT_EQ(render(std::vector{bad, Drawing{}}, from_front(3), 64, 48, 2).pixels, empty.pixels);
  for (int x = 1; x < 64; ++x) EXPECT_EQ(pixel(empty, x, 10), pixel(empty, 0, 10));  // a gradient from top to bottom
  EXPECT_NE(pixel(empty, 0, 0), pixel(empty, 0, 47));
  EXPECT_THROW(render({}, from_front(3), 0, 48, 1), std::invalid_argument);
}

TEST(Picture, ADegenerateTriangleDoesNotDisturbItsNeighbours) {
  auto sheet = square(1, 0, kRed);
  const auto before = render(std::vector{sheet}, from_front(3), 80, 60, 1);
  sheet.points.push_back({kNoNumber, 0, 0});
  sheet.triangles.insert(sheet.triangles.end(), {{0, 1, 1}, {0, 1, 4}});
  EXPECT_EQ(render(std::vector{sheet}, from_front(3), 80, 60, 1).pixels, before.pixels);
}

TEST(Picture, CornerNormalsAreSmoothOnASphereAndSharpOnABox) {
  const auto ball = sphere({0, 0, 0}, 1, 40);
  const auto smooth = corner_normals(ball.points, ball.triangles);
  float worst = 1;  // cosine of the angle to the radius
  for (std::size_t c = 0; c < smooth.size(); ++c) {
    const Vec radial(ball.points[ball.triangles[c / 3][c % 3]].data());
    worst = std::min(worst, std::fabs(smooth[c].dot(radial)));
  }
  EXPECT_GT(worst, std::cos(0.005));  // a facet's own normal is off by about pi / 80 = 0.04 at its corners
  Drawing box;
  for (int k = 0; k < 8; ++k) box.points.push_back({float(k & 1), float(k >> 1 & 1), float(k >> 2 & 1)});
  add_faces(box, std::vector<Quad>{{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}});
  const auto sharp = corner_normals(box.points, box.triangles);
  for (std::size_t c = 0; c < sharp.size(); ++c) {
    const int axis = std::array{2, 2, 1, 1, 0, 0}[c / 6];
    const float sign = std::array{-1.0f, 1.0f, -1.0f, 1.0f, -1.0f, 1.0f}[c / 6];
    EXPECT_NEAR(sharp[c][axis], sign, 1e-6f) << c;
  }
}

TEST(FrameAll, ContainsEveryPointAndFillsThePicture) {
  const std::vector<std::vector<P>> clouds{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}},
                                           {{-5, 0, -5}, {5, 0, 5}, {5, 0, -5}, {-5, 0, 5}},
                                           {{1000, 2000, -500}, {1000.5f, 2000, -500}, {1000, 2000.25f, -499}},
                                           {{0, 0, 0}, {0, -10, 0}},
                                           {{1e-3f, 0, 0}, {0, 2e-3f, 0}}};
  for (const double aspect : {0.5, 1.0, 16.0 / 9}) {
    for (const auto& points : clouds) {
      const Camera camera = frame_all(points, aspect);
      // An independent pinhole projection: coordinates along the view, and to its right and up, over the half sizes of
      // the picture.
      Vec3 f{}, r{}, u{};
      double length = 0;
      for (int k = 0; k < 3; ++k) f[k] = camera.target[k] - camera.eye[k], length += f[k] * f[k];
      for (double& c : f) c /= std::sqrt(length);
      const double side = std::hypot(f[0], f[2]);
      r = {-f[2] / side, 0, f[0] / side};
      u = {r[1] * f[2] - r[2] * f[1], r[2] * f[0] - r[0] * f[2], r[0] * f[1] - r[1] * f[0]};
      const double half = std::tan(camera.fov_degrees * kPi / 360);
      double widest = 0;
      for (const auto& p : points) {
        double along = 0, right = 0, up = 0;
        for (int k = 0; k < 3; ++k) {
          along += (p[k] - camera.eye[k]) * f[k];
          right += (p[k] - camera.eye[k]) * r[k];
          up += (p[k] - camera.eye[k]) * u[k];
        }
        ASSERT_GT(along, 0);
        widest = std::max({widest, std::fabs(right) / (along * half * aspect), std::fabs(up) / (along * half)});
      }
      EXPECT_LT(widest, 1);
      EXPECT_GT(widest, 0.85);  // the margin leaves 0.9
    }
  }
}

TEST(FrameAll, OnePointAndNonePointsGiveAUsableCamera) {
  const Camera one = frame_all(std::vector<P>{{3, 4, 5}, {kNoNumber, 0, 0}});
  EXPECT_NEAR(one.target[0], 3, 1e-9);
  EXPECT_NEAR(one.target[1], 4, 1e-9);
  EXPECT_NEAR(one.target[2], 5, 1e-9);
  EXPECT_GT(std::hypot(one.eye[0] - 3, one.eye[1] - 4, one.eye[2] - 5), 0.1);
  EXPECT_EQ(frame_all({}).eye, Camera{}.eye);
}

TEST(Picture, BodiesHaveEightColoursThatAreFarApart) {
  for (int i = 0; i < 8; ++i) {
    EXPECT_EQ(body_colour(i), body_colour(i + 8));
    for (int j = 0; j < i; ++j) {
      const auto a = body_colour(i), b = body_colour(j);
      EXPECT_GT(std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]), 0.15f) << i << " " << j;
    }
  }
}

}  // namespace
}  // namespace malha
