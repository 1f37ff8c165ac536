// SPDX-License-Identifier: Apache-2.0
#include "host/base/adaptive_thread_count.h"

#include <algorithm>

namespace malha {

void AdaptiveThreadCount::took(double wall, double running) {
  if (all_ == 1) return;
  ++steps_, wall_ += wall, running_ += running;
  if (wall_ < kWindow) return;
  const double spent = wall_, step = wall_ / steps_;
  const bool crowded = running_ < kCrowded * wall_;
  since_ += spent, steps_ = 0, wall_ = running_ = 0;
  if (together_)
    observe_team(step, spent, crowded);
  else
    observe_single(step, spent, crowded);
}

void AdaptiveThreadCount::decide(bool together, double wait) {
  together_ = together, trial_ = false, since_ = 0, wait_ = wait;
}

void AdaptiveThreadCount::observe_team(double step, double spent, bool crowded) {
  if (trial_) {
    usual_ = step, known_ = true, lost_crowded_ = crowded_, lost_at_ = single_;
    return decide(step < single_, step < single_ ? 0 : kRarely * spent);
  }
  const bool slower = crowded || step > kSlower * usual_ || step > single_;
  const bool tries = slower && since_ >= wait_;
  usual_ = tries ? step : std::min(step, usual_ * 1.02);  // it follows a scene whose steps become slower
  if (tries) try_the_other();
}

void AdaptiveThreadCount::observe_single(double step, double spent, bool crowded) {
  single_ = step, crowded_ = crowded;
  if (trial_) {
    lost_crowded_ = crowded, lost_at_ = step;
    // An unsuccessful trial is repeated half as often.
    return step < usual_ ? decide(false, kRarely * std::max(kWindow, usual_))
                         : decide(true, std::max(std::min(2 * wait_, kLongest), kRarely * spent));
  }
  if (!known_ && crowded) wait_ = kRarely * std::max(kWindow, kWorst * step);
  const bool others_ended = lost_crowded_ && !crowded,
             has_more_to_do = known_ && !crowded && step > kHeavier * lost_at_;
  if (since_ >= wait_ || others_ended || has_more_to_do) try_the_other();
}

}  // namespace malha
