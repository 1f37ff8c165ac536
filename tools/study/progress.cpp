#include "tools/study/progress.h"

#include <unistd.h>

#include <cstdio>

namespace malha::study {

void CellProgress::operator()(const std::string& what, int done, int planned) {
  const std::string line = study_ + " " + std::to_string(done) + "/" + std::to_string(planned) + " " + what;
  status_.show(line, planned > 0 ? static_cast<double>(done) / planned : 0);
  constexpr double silence = 10;  // s
  const auto now = Clock::now();
  if (isatty(STDERR_FILENO) || std::chrono::duration<double>(now - said_at_).count() < silence) return;
  std::fprintf(stderr, "%s\n", line.c_str());
  said_at_ = now;
}

}  // namespace malha::study
