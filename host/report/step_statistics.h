// SPDX-License-Identifier: Apache-2.0
// Statistics of the durations of steps, in constant memory.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/base/median.h"

namespace malha {

class StepStatistics {
 public:
  void add(double seconds) {
    least_ = count_ == 0 ? seconds : std::min(least_, seconds), most_ = std::max(most_, seconds);
    sum_ += seconds, last_ = seconds;
    if (count_ == 0) sample_.reserve(kMost);  // no later step allocates
    if (count_++ % every_ != 0) return;
    if (sample_.size() == kMost) thin();
    sample_.push_back(seconds);
  }

  std::int64_t count() const { return count_; }
  double sum() const { return sum_; }  ///< s, as the others; 0 without steps
  double least() const { return least_; }
  double most() const { return most_; }
  double last() const { return last_; }
  /// The median of all steps, or of every second, fourth ... step of long runs.
  double median() const { return malha::median(sample_); }
  std::size_t bytes() const { return sample_.capacity() * sizeof(double); }

 private:
  static constexpr std::size_t kMost = 4096;
  void thin() {
    for (std::size_t k = 0; k < kMost / 2; ++k) sample_[k] = sample_[2 * k];
    sample_.resize(kMost / 2);
    every_ *= 2;
  }

  std::int64_t count_ = 0, every_ = 1;
  double sum_ = 0, least_ = 0, most_ = 0, last_ = 0;
  std::vector<double> sample_;  // durations of every `every_`-th step
};

}  // namespace malha
