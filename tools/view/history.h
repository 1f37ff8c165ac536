// SPDX-License-Identifier: Apache-2.0
// History of a session within a memory limit: frames to show, states to restore, and graphs.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "malha/scene.h"
#include "tools/view/shown_state.h"

namespace malha::view {

/// Frames, states and scenes of all sides at about the same time.
struct Moment {
  std::vector<std::shared_ptr<const Frame>> frames;
  std::vector<std::string> states;
  std::vector<std::shared_ptr<const Scene>> scenes;  // with the settings at that time
  std::size_t bytes() const;
};

using Moments = std::vector<std::shared_ptr<const Moment>>;

/// Moments at equal intervals. If they exceed the memory limit or the largest number, every second one is removed; the
/// first one stays.
class History {
 public:
  explicit History(std::size_t room) : room_(room) {}

  /// Returns whether a moment is due at this simulated time (s).
  bool is_due(double time) const { return moments_.empty() || time >= last_ + 0.999 * interval_; }
  void add(Moment moment, double time);

  /// Removes the moments after this one.
  void cut_after(std::size_t moment);
  void clear();

  const Moments& moments() const { return moments_; }
  std::size_t room() const { return room_; }  // bytes

 private:
  static constexpr std::size_t kMost = 4'000;  // more than a graph has pixels, and every frame draws them all
  static constexpr double kFirstInterval = 1.0 / 60;
  std::size_t room_, bytes_ = 0;
  double interval_ = kFirstInterval, last_ = 0;  // s
  Moments moments_;
};

}  // namespace malha::view
