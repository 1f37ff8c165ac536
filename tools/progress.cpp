#include "tools/progress.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <string>

#include "host/base/shown.h"

namespace malha {

namespace {

int terminal_width() {
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

/// "0:07", "12:40", "3:05:00"
std::string clock_text(double seconds) {
  const auto whole = static_cast<long long>(seconds + 0.5);
  char text[48];
  if (whole < 3600)
    std::snprintf(text, sizeof text, "%lld:%02lld", whole / 60, whole % 60);
  else
    std::snprintf(text, sizeof text, "%lld:%02lld:%02lld", whole / 3600, whole / 60 % 60, whole % 60);
  return text;
}

}  // namespace

ProgressReporter::ProgressReporter(bool quiet) : quiet_(quiet), terminal_(isatty(STDERR_FILENO) != 0) {}

ProgressReporter::~ProgressReporter() {
  if (drawn_) std::fprintf(stderr, "\n");
}

void ProgressReporter::operator()(const Progress& progress) {
  if (quiet_) return;
  const auto now = Clock::now();
  if (first_ < 0) first_ = progress.step, start_ = said_at_ = now;
  ++steps_since_, ms_since_ += progress.step_ms;
  const bool last = progress.step == progress.steps;
  const std::chrono::duration<double> silence = now - said_at_, elapsed = now - start_;
  const std::int64_t tenth = progress.step * 10 / progress.steps;
  const bool due = terminal_ ? silence.count() > 0.05 || !drawn_ : tenth != tenth_ || silence.count() > 10;
  if (!due && !last) return;

  const double step_ms = ms_since_ / static_cast<double>(steps_since_);
  if (terminal_) {
    const auto seen = static_cast<double>(progress.step - first_);
    char text[160];
    std::snprintf(text, sizeof text, "%lld/%lld  t = %.3f s  %.2f ms a step", static_cast<long long>(progress.step),
                  static_cast<long long>(progress.steps), progress.time, step_ms);
    std::string line = text;
    if (seen > 0)
      line += "  " + clock_text(elapsed.count() / seen * static_cast<double>(progress.steps - progress.step)) + " left";
    draw_bar(static_cast<double>(progress.step) / static_cast<double>(progress.steps), line);
  } else {
    std::fprintf(stderr, "step %lld of %lld, t = %.3f s, %.2f ms a step\n", static_cast<long long>(progress.step),
                 static_cast<long long>(progress.steps), progress.time, step_ms);
  }
  said_at_ = now, tenth_ = tenth;
  steps_since_ = 0, ms_since_ = 0;
}

void ProgressReporter::setup(const char* what, double part) {
  const auto now = Clock::now();
  if (quiet_ || std::chrono::duration<double>(now - setup_said_at_).count() < (terminal_ ? 0.05 : 5)) return;
  setup_said_at_ = now;
  char text[80];
  std::snprintf(text, sizeof text, "setting up: %s, %.0f %%", what, 100 * part);
  if (terminal_)
    draw_bar(part, text);
  else
    std::fprintf(stderr, "%s\n", text);
}

void ProgressReporter::warn(const std::string& scene, const std::string& line) {
  std::fprintf(stderr, "%s%s: warning: %s\n", drawn_ ? "\r\033[K" : "", printable(scene).c_str(),
               printable(line).c_str());
  drawn_ = false;
}

void ProgressReporter::draw_bar(double part, const std::string& what) {
  // One column stays free: a full line would wrap, and the next one could not redraw it.
  std::string line = what;
  const int room = terminal_width() - 1;
  const int width = std::min(30, room - static_cast<int>(line.size()) - 3);
  if (width >= 5) {
    const auto filled = std::min(static_cast<std::size_t>(width), static_cast<std::size_t>(part * width));
    line = "[" + std::string(filled, '#') + std::string(width - filled, '.') + "] " + line;
  }
  std::fprintf(stderr, "\r%s\033[K", line.substr(0, static_cast<std::size_t>(std::max(room, 0))).c_str());
  drawn_ = true;
}

}  // namespace malha
