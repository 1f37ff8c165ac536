// SPDX-License-Identifier: Apache-2.0
#include "tools/view/history.h"

#include <algorithm>

namespace malha::view {

std::size_t Moment::bytes() const {
  std::size_t sum = 0;
  for (const auto& frame : frames) sum += frame->x.size() * (sizeof(Point3f) + sizeof(float)) + sizeof(Frame);
  for (const std::string& state : states) sum += state.size();
  return sum;
}

void History::add(Moment moment, double time) {
  if (!moments_.empty()) interval_ = std::max(interval_, time - last_);  // a step may be longer than the interval
  bytes_ += moment.bytes(), last_ = time;
  moments_.push_back(std::make_shared<const Moment>(std::move(moment)));
  while ((bytes_ > room_ && moments_.size() > 2) || moments_.size() > kMost) {
    Moments kept;
    for (std::size_t k = 0; k < moments_.size(); k += 2) kept.push_back(moments_[k]);
    moments_ = std::move(kept), interval_ *= 2, bytes_ = 0;
    for (const auto& one : moments_) bytes_ += one->bytes();
    last_ = moments_.back()->frames.front()->time;
  }
}

void History::cut_after(std::size_t moment) {
  while (moments_.size() > moment + 1) bytes_ -= moments_.back()->bytes(), moments_.pop_back();
  if (!moments_.empty()) last_ = moments_.back()->frames.front()->time;
}

void History::clear() { *this = History(room_); }

}  // namespace malha::view
