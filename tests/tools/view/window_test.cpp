// SPDX-License-Identifier: Apache-2.0
// malha view from a user's view: a window, keys and a mouse. Pixels on the screen are compared with the solver's
// positions.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "host/model/model.h"
#include "malha/simulation.h"
#include "tests/numbers.h"
#include "tests/tools/view/display.h"
#include "tools/view/layout.h"

namespace malha {
namespace {

using view::OrbitCamera;
using view::Viewport;

constexpr const char* kScene = MALHA_SOURCE_DIR "/scenes/sheet_shear.json";

class Window : public testing::Test {
 protected:
  void SetUp() override {
    if (!ShownWindow::can_be_shown()) GTEST_SKIP() << "needs malha_view, Xvfb and xdotool: tools/setup display";
  }
};

Viewport port() { return view::port_of(0, 1, true, ShownWindow::kWidth, ShownWindow::kHeight); }

/// The camera with which the window opens.
OrbitCamera camera_of(const Simulation& simulation) {
  const auto& picture = simulation.model().scene.outputs.picture;
  if (picture && picture->camera)
    return OrbitCamera(*picture->camera, double(picture->size[0]) / picture->size[1], port().aspect());
  OrbitCamera camera;
  std::vector<view::Point3f> points;
  for (const Vec3& x : simulation.positions()) points.push_back({float(x[0]), float(x[1]), float(x[2])});
  camera.frame(points, port().aspect());
  return camera;
}

std::array<double, 2> on_screen(const OrbitCamera& camera, const Vec3& x) {
  const Eigen::Vector3d at = camera.on_screen(port(), {x[0], x[1], x[2]});
  return {at.x(), at.y()};
}

/// Tests whether a pixel shows the first body, which is blue; its lines are darker, the sky is nearly white.
bool is_cloth(const Image& image, int x, int y) {
  const unsigned char* pixel = &image.pixels[3 * (std::size_t(y) * image.width + x)];
  return pixel[2] > pixel[0] + 40;
}

/// The pixels of the port that the projected faces cover.
std::vector<bool> covered(const Simulation& simulation, const OrbitCamera& camera) {
  std::vector<bool> mask(std::size_t(ShownWindow::kWidth) * ShownWindow::kHeight, false);
  const std::vector<Vec3> x = simulation.positions();
  const auto fill = [&](const std::array<double, 2>& a, const std::array<double, 2>& b,
                        const std::array<double, 2>& c) {
    const auto side = [](const auto& p, const auto& q, double u, double v) {
      return (q[0] - p[0]) * (v - p[1]) - (q[1] - p[1]) * (u - p[0]);
    };
    for (int v = int(std::floor(std::min({a[1], b[1], c[1]}))); v <= std::max({a[1], b[1], c[1]}); ++v)
      for (int u = int(std::floor(std::min({a[0], b[0], c[0]}))); u <= std::max({a[0], b[0], c[0]}); ++u) {
        const double s = side(a, b, u + 0.5, v + 0.5), t = side(b, c, u + 0.5, v + 0.5),
                     r = side(c, a, u + 0.5, v + 0.5);
        const bool inside = (s >= 0 && t >= 0 && r >= 0) || (s <= 0 && t <= 0 && r <= 0);
        if (inside && port().contains(u, v)) mask[std::size_t(v) * ShownWindow::kWidth + u] = true;
      }
  };
  for (const Quad& face : simulation.model().render_mesh.faces) {
    const auto corner = [&](int k) { return on_screen(camera, x[face[k]]); };
    fill(corner(0), corner(1), corner(2));
    if (face[3] >= 0) fill(corner(0), corner(2), corner(3));
  }
  return mask;
}

/// The share of pixels on which picture and faces agree, of those that are cloth in either.
double agreement(const Image& image, const std::vector<bool>& mask) {
  int both = 0, either = 0;
  for (int y = 0; y < port().height; ++y)
    for (int x = port().left; x < port().left + port().width; ++x) {
      if (x < port().left + 90 && y > port().height - 90) continue;  // the axes
      const bool one = is_cloth(image, x, y), other = mask[std::size_t(y) * ShownWindow::kWidth + x];
      both += one && other, either += one || other;
    }
  return double(both) / either;
}

TEST_F(Window, ShowsTheClothWhereTheSolverSays) {
  ShownWindow window(kScene);
  Simulation simulation(load_scene(kScene));
  const OrbitCamera camera = camera_of(simulation);
  const std::vector<bool> start = covered(simulation, camera);
  for (const int steps : {0, 20, 25}) {
    window.step(steps);
    for (int k = 0; k < steps; ++k) simulation.step();
    const Image image = window.picture();
    ASSERT_EQ(image.width, ShownWindow::kWidth);
    // The outline is a pixel wide, pins are red: some 1 % of the cloth's 200,000 pixels.
    const double agreed = agreement(image, covered(simulation, camera));
    EXPECT_GT(agreed, 0.97) << simulation.steps();
    if (steps > 0) {
      EXPECT_LT(agreement(image, start), agreed - 0.02) << "the cloth has moved";
    }
  }
  EXPECT_EQ(window.close().status, 0);
}

TEST_F(Window, PullsTheParticleThatTheMouseTakes) {
  ShownWindow window(kScene);
  Simulation simulation(load_scene(kScene));
  const OrbitCamera camera = camera_of(simulation);
  const int particle = static_cast<int>(simulation.positions().size()) / 2;
  const Vec3 start = simulation.positions()[particle];
  const std::array<double, 2> at = on_screen(camera, start);
  window.move(at[0], at[1]), window.press();
  for (int k = 1; k <= 6; ++k) window.move(at[0] + 15 * k, at[1]);
  window.step(40);
  const std::filesystem::path saved = window.save();
  window.release();
  for (int k = 0; k < 40; ++k) simulation.step();
  Simulation pulled(load_scene(saved.string()));
  pulled.load_checkpoint(ShownWindow::checkpoint_of(saved).string());
  EXPECT_EQ(pulled.steps(), 40);
  const double left_alone = on_screen(camera, simulation.positions()[particle])[0] - at[0];
  const double moved = on_screen(camera, pulled.positions()[particle])[0] - at[0];
  // The spring stretches by 1 mm a newton, and the cloth resists: most of the distance of the mouse remains.
  EXPECT_GT(moved, left_alone + 60) << "of 90 pixels";
  EXPECT_EQ(window.close().status, 0);
}

TEST_F(Window, WhatIsSavedRunsTheSame) {
  ShownWindow window(kScene);
  window.move(50, 205);  // the field of the substeps
  window.xdotool("click --repeat 2 --delay 50 1"), ShownWindow::pause();
  window.key("ctrl+a"), window.xdotool("type --delay 0 24"), window.key("Return");  // faster than pictures are drawn
  window.move(600, 300), ShownWindow::pause(), ShownWindow::pause();
  window.step(15);
  const std::filesystem::path saved = window.save();
  EXPECT_EQ(window.close().status, 0);
  const Scene scene = load_scene(saved.string());
  EXPECT_EQ(scene.solver.substeps, 24);
  Simulation again(scene), there(scene);
  for (int k = 0; k < 15; ++k) again.step();
  there.load_checkpoint(ShownWindow::checkpoint_of(saved).string());
  EXPECT_EQ(there.steps(), 15);
  EXPECT_EQ(there.state_hash(), again.state_hash());
}

// "no force is known: constraints at pins have no compliance, ...", in two sides of 350 pixels.
TEST_F(Window, TextOfASideStaysWithinIt) {
  const TemporaryFolder folder;
  nlohmann::json scene = nlohmann::json::parse(bytes_of(kScene));
  scene["bodies"][0]["constraints"] = {{{"type", "distance"}, {"stiffness", 1}}};
  const std::string file = folder.write("stiff.json", scene.dump());
  ShownWindow window({file, file});
  const Viewport right = view::port_of(1, 2, true, ShownWindow::kWidth, ShownWindow::kHeight);
  const auto ink = [&](int from, int to) {
    const Image image = window.picture();
    int count = 0;
    for (int y = 0; y < 140; ++y)
      for (int x = from; x < to; ++x) {
        const unsigned char* const pixel = &image.pixels[3 * (std::size_t(y) * image.width + x)];
        count += std::max({pixel[0], pixel[1], pixel[2]}) < 90;
      }
    return count;
  };
  window.key("9");
  EXPECT_GT(ink(right.left - right.width, right.left - 8), 300) << "the words of the left side";
  EXPECT_GT(ink(right.left + 12, right.left + right.width), 300) << "of the right side";
  EXPECT_EQ(ink(right.left - 7, right.left + 11), 0) << "between them";
  EXPECT_EQ(window.close().status, 0);
}

TEST_F(Window, SurvivesRandomInputs) {
  ShownWindow window(MALHA_SOURCE_DIR "/scenes/torn_sheet.json");
  Random random(7);
  const std::vector<std::string> keys{
      "space", "period", "r", "Left", "Right", "bracketleft", "bracketright", "backslash", "f",   "b",
      "w",     "q",      "a", "d",    "p",     "Tab",         "F1",           "1",         "2",   "3",
      "4",     "5",      "6", "7",    "8",     "ctrl+s",      "Escape",       "Return",    "Down"};
  for (int k = 0; k < 60 && window.open(); ++k) {
    const int what = random.below(4);
    const std::string at = std::to_string(random.below(1280)) + " " + std::to_string(random.below(800));
    const std::string button = std::to_string(1 + random.below(5));
    if (what < 2)
      window.key(keys[std::size_t(random.below(int(keys.size())))]);
    else if (what == 2)
      window.xdotool("mousemove " + at + " click " + button);
    else
      window.xdotool(std::string(random.below(2) == 0 ? "keydown c " : "") + "mousedown 1 mousemove " + at +
                     " sleep 0.05 mouseup 1 keyup c");
  }
  ASSERT_TRUE(window.open());
  const Ended ended = window.close();
  EXPECT_EQ(ended.status, 0);
  EXPECT_EQ(ended.err, "");
}

TEST_F(Window, SaysThatARunDivergedAndStaysOpen) {
  const TemporaryFolder folder;
  const nlohmann::json here{{"lattice", {{"min", {0, 0, 0}}, {"max", {1, 1, 1}}, {"count", {2, 2, 2}}}}};
  const nlohmann::json scene{// beyond the largest float, 3.4e38 m, in the third step: g dt^2 = 1e38 m
                             {"name", "rush"},
                             {"gravity", {0, -1e18, 0}},
                             {"solver", {{"type", "pbd"}, {"dt", 1e10}, {"substeps", 1}}},
                             {"bodies", {{{"name", "rushing"}, {"shape", here}, {"mass", 1}}}},
                             {"duration", 1e12}};
  ShownWindow window(folder.write("rush.json", scene.dump()));
  window.step(2);
  window.key("period");
  window.wait_for([&] { return has(window.title(), "diverged"); }, "the rush");
  window.key("r");
  window.wait_for([&] { return has(window.title(), "step 0"); }, "the reset");
  EXPECT_EQ(window.close().status, 0);
}

TEST(WindowWithoutDisplay, SaysSo) {
  if (!ShownWindow::built()) GTEST_SKIP() << "malha_view is not built";
  const TemporaryFolder folder;
  const Ended ended = MalhaProcess({"-u", "DISPLAY", "-u", "WAYLAND_DISPLAY", MALHA_COMMAND, "view", kScene},
                                   folder / "", RLIM_INFINITY, "/usr/bin/env")
                          .wait();
  EXPECT_EQ(ended.status, 4);
  EXPECT_TRUE(has(ended.err, "malha view: no window can be opened")) << ended.err;
  EXPECT_EQ(std::count(ended.err.begin(), ended.err.end(), '\n'), 1);
}

TEST(WindowWithoutDisplay, RefusesABadSceneBefore) {
  if (!ShownWindow::built()) GTEST_SKIP() << "malha_view is not built";
  const TemporaryFolder folder;
  const Ended ended = malha_command({"view", folder.write("bad.json", "{\"name\": 3}")}, folder / "");
  EXPECT_EQ(ended.status, 2);
  EXPECT_TRUE(has(ended.err, "bad.json: ")) << ended.err;
}

}  // namespace
}  // namespace malha
