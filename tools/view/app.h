// SPDX-License-Identifier: Apache-2.0
// One frame of the window after the other.
#pragma once
#include <array>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "tools/view/layout.h"
#include "tools/view/painter.h"
#include "tools/view/panels.h"
#include "tools/view/window.h"

namespace malha::view {

class App {
 public:
  /// `in_software`: pictures are drawn without a GPU. `scale`: how many times larger the display shows things.
  App(const WindowOptions& options, bool in_software, float scale);

  /// Draws everything into a window of so many pixels, and does what mouse and keys say.
  void frame(int width, int height);
  /// After it lies in the window's back buffer.
  void drawn(int width, int height);
  /// A key of GLFW went down, or repeats; `held`: GLFW's bits of Ctrl and the like.
  void key(int key, int held);
  /// A file was dropped on the window.
  void drop(const std::string& path);

  std::string title() const;
  bool quits() const { return quits_; }
  bool runs() const { return now_.running; }
  /// Whether nothing changes until somebody does something.
  bool rests() const { return !now_.running && now_.doing.empty() && still_ > 3; }

 private:
  /// A particle that the mouse has taken.
  struct Taken {
    std::size_t side;
    int particle;
    double depth;  // m
    bool firm;
  };

  void lay_out(int width, int height);
  void show_all();
  void draw_side(std::size_t side, int height);
  void command_key(int key);
  void save();
  void mouse();
  void press(std::size_t side, double x, double y);
  void drag(double x, double y);
  std::vector<std::size_t> alike(std::size_t side) const;
  void pin_or_release(std::size_t side, int particle);
  void throw_ball_at(double x, double y);
  std::filesystem::path free_name(const std::string& stem, const std::string& extension) const;
  void panels(int width, int height);
  void overlay(std::size_t side);
  std::optional<std::size_t> side_at(double x, double y) const;
  void add_marks(const SideShown& side, Marks& marks) const;

  WindowOptions options_;
  Session session_;
  Snapshot now_;
  Choices choices_;
  std::vector<Edited> edited_;
  OrbitCamera camera_;
  Panels panels_;
  std::deque<Painter> painters_;
  std::vector<Viewport> ports_;
  std::shared_ptr<const Scene> framed_;  // the scene whose camera was set
  std::optional<Taken> taken_;
  std::optional<std::array<double, 2>> knife_;  // where the stroke was last
  bool orbits_ = false, pans_ = false, picture_ = false, quits_ = false;
  std::vector<Coloured> coloured_;
  Eigen::Matrix4d seen_ = Eigen::Matrix4d::Zero();  // the camera's, in the last picture
  bool coarse_while_moving_ = false, coarse_ = false;
  int still_ = 0;  // pictures since the session last said something new
};

}  // namespace malha::view
