// The memory behind kernels/nearby.h: of the particles near one environment mesh.
#pragma once
#include <algorithm>
#include <vector>

#include "host/base/array.h"
#include "kernels/nearby.h"

namespace malha {

template <class Executor, class R>
class NearMemory {
 public:
  explicit NearMemory(std::size_t particles)
      : at_(3 * particles, 0.0f),
        distance_(particles, -INFINITY),
        balls_((particles + kWord - 1) / kWord, WordBall{}),
        slot_(particles, -1),
        counts_(2, 0) {}

  Nearby<R> view() const {
    float* const at = at_.data();
    const std::size_t n = slot_.size();
    return {{at, at + n, at + 2 * n}, balls_.data(), distance_.data(), slot_.data(),
            contacts_.data(),         near_.data(),  counts_.data(),   counts_.data() + 1};
  }

  int slots() const { return counts_.data()[0]; }

  /// Room for so many more slots, and for not many more than are used: free ones are taken out.
  void make_room(int more) {
    int &used = counts_.data()[0], &freed = counts_.data()[1];
    const std::size_t needed = static_cast<std::size_t>(used - freed) + static_cast<std::size_t>(more);
    const bool wide = near_.size() > 4 * needed + 1024;
    if (freed <= used / 4 + kSpare && static_cast<std::size_t>(used) + static_cast<std::size_t>(more) <= near_.size() &&
        !wide)
      return;
    const bool moves = needed > near_.size() || wide;
    Array<Executor, Near> near_to;
    Array<Executor, Contact<R>> contacts_to;
    if (moves) {
      const std::size_t room = needed + needed / 8 + (more > 0 ? kSpare / 2 : 0);
      near_to = Array<Executor, Near>(room), contacts_to = Array<Executor, Contact<R>>(room);
    }
    Near *const near = near_.data(), *const near_into = moves ? near_to.data() : near;
    Contact<R>*const contacts = contacts_.data(), *const contacts_into = moves ? contacts_to.data() : contacts;
    int kept = 0;
    for (int s = 0; s < used; ++s) {
      if (contacts[s].particle < 0) continue;
      near_into[kept] = near[s], contacts_into[kept] = contacts[s];
      slot_.data()[contacts_into[kept].particle] = kept;
      ++kept;
    }
    written_ = used > written_ ? used : written_;
    if (moves) near_ = std::move(near_to), contacts_ = std::move(contacts_to), written_ = kept;
    used = kept, freed = 0;
  }

  /// Cells are no longer what they were.
  void forget_cells() {
    for (int s = 0; s < slots(); ++s) near_.data()[s].cell = 0;
  }

  /// What a later substep depends on, for checkpoints.
  void append_to(std::vector<LastSeen>& all) const {
    const Nearby<R> nearby = view();
    for (int i = 0; i < static_cast<int>(slot_.size()); ++i) all.push_back(nearby.seen(i));
  }
  void remember(const LastSeen* all) {
    const int n = static_cast<int>(slot_.size());
    std::fill_n(slot_.data(), n, -1);
    counts_.data()[0] = counts_.data()[1] = 0;
    int near = 0;
    for (int i = 0; i < n; ++i) near += Nearby<R>::needs_slot(all[i]);
    make_room(near);
    for (int i = 0; i < n; ++i) view().see(i, all[i]);
  }

  static constexpr std::size_t kSlotBytes = sizeof(Near) + sizeof(Contact<R>);
  int near() const { return counts_.data()[0] - counts_.data()[1]; }
  /// Of slots that were ever filled: there is room for more, in pages that nothing was written to.
  std::size_t near_bytes() const { return static_cast<std::size_t>(std::max(written_, slots())) * kSlotBytes; }
  std::size_t bytes() const { return at_.bytes() + distance_.bytes() + balls_.bytes() + slot_.bytes() + near_bytes(); }

 private:
  static constexpr int kSpare = 32;  // slots: fewer are not worth a copy
  Array<Executor, float> at_, distance_;
  Array<Executor, WordBall> balls_;
  Array<Executor, int> slot_;
  Array<Executor, int> counts_;           // of slots, and of free ones among them
  Array<Executor, Contact<R>> contacts_;  // of each slot
  Array<Executor, Near> near_;            // the same
  int written_ = 0;                       // slots, since there is this room
};

}  // namespace malha
