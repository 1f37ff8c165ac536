// SPDX-License-Identifier: Apache-2.0
#include "tools/progress.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <string>

#include "malha/text.h"

namespace malha {

namespace {

constexpr int kWords = 66;  // columns beside the bar, enough for most lines, so that its width is constant

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

/// Returns "20/40 t = 0.400 s "; "" before the first step.
std::string place(const Progress& at) {
  if (at.steps == 0) return "";
  char text[80];
  std::snprintf(text, sizeof text, "%lld/%lld  t = %.3f s  ", static_cast<long long>(at.step),
                static_cast<long long>(at.steps), at.time);
  return text;
}

double share(const Progress& at) {
  return at.steps == 0 ? 0 : static_cast<double>(at.step) / static_cast<double>(at.steps);
}

}  // namespace

ProgressReporter::ProgressReporter(bool quiet) : quiet_(quiet), terminal_(isatty(STDERR_FILENO) != 0) {}

ProgressReporter::~ProgressReporter() {
  if (!drawn_) return;
  if (line_.empty())
    std::fprintf(stderr, "\r\033[K");
  else
    draw_bar(share(last_), line_), std::fprintf(stderr, "\n");
}

void ProgressReporter::operator()(const Progress& progress) {
  if (quiet_) return;
  const auto now = Clock::now();
  if (first_ < 0) first_ = progress.step, start_ = reported_at_ = now;
  last_ = progress, ++steps_since_, ms_since_ += progress.step_ms;
  const bool last = progress.step == progress.steps;
  const std::chrono::duration<double> silence = now - reported_at_, elapsed = now - start_;
  const std::int64_t tenth = progress.step * 10 / progress.steps;
  const bool due = terminal_ ? silence.count() > 0.05 || line_.empty() : tenth != tenth_ || silence.count() > 10;
  if (!due && !last) return;

  const double step_ms = ms_since_ / static_cast<double>(steps_since_);
  if (terminal_) {
    char text[80];
    std::snprintf(text, sizeof text, "%.2f ms a step", step_ms);
    line_ = place(progress) + text, activity_ = nullptr;
    // The estimate of the remaining time includes pictures and files. It starts after the first step, whose start is
    // unknown.
    if (const auto seen = static_cast<double>(progress.step - first_); seen > 0) {
      const double rate = seen / elapsed.count();
      std::snprintf(text, sizeof text, rate < 100 ? "  %.3g steps/s  " : "  %.0f steps/s  ", rate);
      line_ += text + clock_text(static_cast<double>(progress.steps - progress.step) / rate) + " left";
    }
    draw_bar(share(progress), line_);
  } else {
    std::fprintf(stderr, "step %lld of %lld, t = %.3f s, %.2f ms a step\n", static_cast<long long>(progress.step),
                 static_cast<long long>(progress.steps), progress.time, step_ms);
  }
  reported_at_ = now, tenth_ = tenth;
  steps_since_ = 0, ms_since_ = 0;
}

void ProgressReporter::show_activity(const char* what) {
  if (quiet_ || !terminal_) return;
  if (activity_ != nullptr && std::strcmp(activity_, what) == 0) return;  // it is already shown
  activity_ = what;
  draw_bar(share(last_), place(last_) + what);
}

void ProgressReporter::setup(const char* what, double part) {
  const auto now = Clock::now();
  const bool begins = part < 0;
  if (quiet_ || (begins && !terminal_)) return;
  if (!begins && std::chrono::duration<double>(now - setup_reported_at_).count() < (terminal_ ? 0.05 : 5)) return;
  setup_reported_at_ = now;
  char text[100];
  if (begins)
    std::snprintf(text, sizeof text, "setting up: %s", what);
  else
    std::snprintf(text, sizeof text, "setting up: %s, %.0f %%", what, 100 * part);
  if (terminal_)
    draw_bar(std::max(part, 0.0), text);
  else
    std::fprintf(stderr, "%s\n", text);
}

void ProgressReporter::warn(const std::string& scene, const std::string& line) {
  std::fprintf(stderr, "%s%s: warning: %s\n", drawn_ ? "\r\033[K" : "", printable(scene).c_str(),
               printable(line).c_str());
  drawn_ = false;
}

void ProgressReporter::draw_bar(double part, const std::string& what) {
  // One column stays free, because a full line would wrap and could not be redrawn.
  std::string line = what;
  const int room = terminal_width() - 1;
  const int width = std::min(30, room - std::max(kWords, static_cast<int>(line.size())) - 3);
  if (width >= 5) {
    const auto filled = std::min(static_cast<std::size_t>(width), static_cast<std::size_t>(part * width));
    line = "[" + std::string(filled, '#') + std::string(width - filled, '.') + "] " + line;
  }
  std::fprintf(stderr, "\r%s\033[K", line.substr(0, static_cast<std::size_t>(std::max(room, 0))).c_str());
  drawn_ = true;
}

}  // namespace malha
