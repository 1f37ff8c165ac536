// SPDX-License-Identifier: Apache-2.0
// The window of malha view on a virtual display (Xvfb), and simulated input from keyboard and mouse (xdotool).
#pragma once
#include <chrono>
#include <cstdio>
#include <functional>
#include <optional>
#include <string>
#include <thread>

#include "host/render/image.h"
#include "tests/render/read_png.h"
#include "tests/support.h"

namespace malha {

/// The output of a command, whatever its exit status.
inline std::string said_by(const std::string& command) {
  std::string said;
  std::FILE* const pipe = popen(command.c_str(), "r");
  if (!pipe) throw std::runtime_error("cannot run " + command);
  for (int letter = std::fgetc(pipe); letter != EOF; letter = std::fgetc(pipe)) said += static_cast<char>(letter);
  pclose(pipe);
  return said;
}

class ShownWindow {
 public:
  static constexpr int kWidth = 1280, kHeight = 800;  // pixels
  static bool can_be_shown() { return !said_by("command -v Xvfb && command -v xdotool").empty() && built(); }
  static bool built() {
    return std::filesystem::exists(std::filesystem::path(MALHA_COMMAND).parent_path() / "malha_view");
  }

  explicit ShownWindow(const std::string& scene) : ShownWindow(std::vector<std::string>{scene}) {}
  explicit ShownWindow(const std::vector<std::string>& scenes)
      // -noreset: a server that resets after each client, such as xdotool, refuses clients that connect at that moment.
      : server_({"-c", "exec Xvfb " + number() + " -noreset -displayfd 1 -screen 0 1280x800x24 -nolisten tcp > " +
                           (folder_ / "display").string()},
                folder_ / "", RLIM_INFINITY, "/bin/sh") {
    wait_for([this] { return has(bytes_of(folder_ / "display"), "\n"); }, "Xvfb");
    display_ = ":" + bytes_of(folder_ / "display");
    display_.pop_back();
    std::vector<std::string> words{"DISPLAY=" + display_, MALHA_COMMAND, "view", "--out", (folder_ / "out").string()};
    words.insert(words.end(), scenes.begin(), scenes.end());
    view_.emplace(words, folder_ / "", RLIM_INFINITY, "/usr/bin/env");
    wait_for([this] { return has(title(), "step 0"); }, "the window");
  }

  ~ShownWindow() {
    view_.reset();
    server_.send(SIGTERM);  // so that it removes its lock file
    server_.wait();
  }
  ShownWindow(const ShownWindow&) = delete;
  ShownWindow& operator=(const ShownWindow&) = delete;

  std::string title() const { return xdotool("search --name malha getwindowname"); }
  void key(const std::string& name) const { xdotool("key " + name); }
  void move(double x, double y) const {
    xdotool("mousemove " + std::to_string(std::lround(x)) + " " + std::to_string(std::lround(y)));
    pause();
  }
  void press(int button = 1) const { xdotool("mousedown " + std::to_string(button)), pause(); }
  void release(int button = 1) const { xdotool("mouseup " + std::to_string(button)), pause(); }
  std::string xdotool(const std::string& words) const {
    return said_by("DISPLAY=" + display_ + " timeout 20 xdotool " + words + " 2>/dev/null");
  }

  /// Takes that many single steps, one after the other.
  void step(int count) {
    for (int k = 0; k < count; ++k) {
      const std::string before = title();
      key("period");
      wait_for([&] { return title() != before; }, "a step");
    }
  }
  /// A picture of the window.
  Image picture() {
    const std::filesystem::path path = out("picture", ".png", pictures_++);
    key("p");
    wait_for([&] { return std::filesystem::exists(path); }, "a picture");
    return read_png(bytes_of(path));
  }
  /// Saves scene and state; the result is the path of the scene, in whose folder the checkpoint is.
  std::filesystem::path save() {
    const std::filesystem::path path = out("scene", ".json", scenes_++);
    key("ctrl+s");
    wait_for([&] { return std::filesystem::exists(checkpoint_of(path)); }, "a scene");
    return path;
  }
  static std::filesystem::path checkpoint_of(const std::filesystem::path& scene) {
    return std::filesystem::path(scene).replace_extension("") / "checkpoint.malha";
  }
  bool open() { return view_->running(); }
  Ended close() {
    key("ctrl+q");
    for (int k = 0; k < 200 && view_->running(); ++k) pause();
    EXPECT_FALSE(view_->running()) << "the window stays open";
    if (view_->running()) view_->send(SIGKILL);
    return view_->wait();
  }

  void wait_for(const std::function<bool()>& there, const std::string& what) {
    for (int k = 0; k < 600; ++k, pause()) {
      if (there()) return;
      if (view_ && !view_->running()) {
        const Ended ended = view_->wait();
        throw std::runtime_error("malha view ended with " + std::to_string(ended.status) + ": " + ended.err);
      }
    }
    throw std::runtime_error("nothing came of " + what + "; the title: " + title());
  }
  static void pause() { std::this_thread::sleep_for(std::chrono::milliseconds(100)); }

 private:
  /// A display for this process alone: two servers that search for a free one may find the same.
  static std::string number() { return ":" + std::to_string(100 + getpid() % 50'000); }
  std::filesystem::path out(const std::string& stem, const std::string& extension, int number) const {
    char digits[16];
    std::snprintf(digits, sizeof digits, "_%03d", number);
    return folder_ / "out" / (stem + digits + extension);
  }

  TemporaryFolder folder_;
  MalhaProcess server_;
  std::string display_;
  std::optional<MalhaProcess> view_;
  int pictures_ = 0, scenes_ = 0;
};

}  // namespace malha
