// SPDX-License-Identifier: Apache-2.0
// What was, as far back as memory allows: frames to look at, states to go on from, and graphs.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "malha/scene.h"
#include "tools/view/shown_state.h"

namespace malha::view {

/// Of every side at about the same time.
struct Moment {
  std::vector<std::shared_ptr<const Frame>> frames;
  std::vector<std::string> states;
  std::vector<std::shared_ptr<const Scene>> scenes;  // with the settings of then
  std::size_t bytes() const;
};

using Moments = std::vector<std::shared_ptr<const Moment>>;

/// Moments at equal distances; where they take too much room, or are too many, every second goes. The first stays.
class History {
 public:
  explicit History(std::size_t room) : room_(room) {}

  /// Whether there is to be a moment now. `time`: s, simulated.
  bool wants(double time) const { return moments_.empty() || time >= last_ + 0.999 * apart_; }
  void add(Moment moment, double time);

  /// Forgets what came after this moment.
  void cut_after(std::size_t moment);
  void clear();

  const Moments& moments() const { return moments_; }
  std::size_t room() const { return room_; }  // bytes

 private:
  static constexpr std::size_t kMost = 4'000;  // more than a graph has pixels; a picture draws them all
  static constexpr double kFirstApart = 1.0 / 60;
  std::size_t room_, bytes_ = 0;
  double apart_ = kFirstApart, last_ = 0;  // s
  Moments moments_;
};

}  // namespace malha::view
