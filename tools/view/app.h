// SPDX-License-Identifier: Apache-2.0
// The window's contents: draws one frame after the other and handles mouse and keys.
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
  /// `in_software`: OpenGL renders on the CPU. `scale`: the display's scale factor.
  App(const WindowOptions& options, bool in_software, float scale);

  /// Draws everything into a window of this size (pixels), and handles the mouse.
  void frame(int width, int height);
  /// Saves a requested picture; called when the frame is in the back buffer.
  void drawn(int width, int height);
  /// Handles a GLFW key that was pressed or repeats. `held`: GLFW's modifier bits.
  void key(int key, int held);
  /// Opens a file that was dropped on the window.
  void drop(const std::string& path);

  std::string title() const;
  bool should_quit() const { return should_quit_; }
  bool is_running() const { return now_.running; }
  /// Returns whether nothing changes until the next input.
  bool is_idle() const { return !now_.running && now_.doing.empty() && still_ > 3; }

 private:
  /// A particle that the mouse drags.
  struct Drag {
    std::size_t side;
    int particle;
    double depth;  // m
    bool is_held;
  };

  void lay_out(int width, int height);
  void show_all();
  void draw_side(std::size_t side, int height);
  void command_key(int key);
  void save();
  void mouse();
  void press(std::size_t side, double x, double y);
  void drag(double x, double y);
  std::vector<std::size_t> sides_to_pull(std::size_t side) const;
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
  std::shared_ptr<const Scene> framed_;  // the scene for which the camera was set
  std::optional<Drag> dragged_;
  std::optional<std::array<double, 2>> knife_;  // last position of the cut's stroke
  bool orbits_ = false, pans_ = false, picture_ = false, should_quit_ = false;
  std::vector<Coloured> coloured_;
  Eigen::Matrix4d seen_ = Eigen::Matrix4d::Zero();  // the view matrix of the last frame
  bool decimates_while_moving_ = false, decimated_ = false;
  int still_ = 0;  // frames since the snapshot last changed
};

}  // namespace malha::view
