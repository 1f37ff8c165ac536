#include "tools/progress.h"

#include <unistd.h>

#include <cstdio>
#include <string>

namespace malha {

ProgressReporter::ProgressReporter(bool quiet) : quiet_(quiet), terminal_(isatty(STDERR_FILENO) != 0) {}

void ProgressReporter::operator()(const Progress& progress) {
  if (quiet_) return;
  seconds_ += progress.step_ms / 1000;
  const bool last = progress.step == progress.steps;
  if (terminal_) {
    if (seconds_ - drawn_at_ < 0.05 && !last) return;
    draw_bar(progress);
    drawn_at_ = seconds_;
    return;
  }
  const std::int64_t tenth = progress.step * 10 / progress.steps;
  if (tenth == tenth_) return;
  tenth_ = tenth;
  std::fprintf(stderr, "step %lld of %lld, t = %.3f s, %.2f ms a step\n", static_cast<long long>(progress.step),
               static_cast<long long>(progress.steps), progress.time, progress.step_ms);
}

void ProgressReporter::draw_bar(const Progress& progress) {
  constexpr int width = 30;
  const int filled = static_cast<int>(progress.step * width / progress.steps);
  std::fprintf(stderr, "\r[%s%s] %lld/%lld  t = %.3f s  %.2f ms a step \033[K", std::string(filled, '#').c_str(),
               std::string(width - filled, '.').c_str(), static_cast<long long>(progress.step),
               static_cast<long long>(progress.steps), progress.time, progress.step_ms);
  if (progress.step == progress.steps) std::fprintf(stderr, "\n");
}

}  // namespace malha
