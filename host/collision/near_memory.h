// The memory behind kernels/nearby.h: of the particles near one environment mesh.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "host/base/array.h"
#include "host/collision/contact_memory.h"
#include "kernels/compute.h"
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

  /// How many may be filled: on a device at most so many, as nobody waits for the number.
  int slots() const { return Memory<Executor>::kOfTheHost ? used() : most_; }

  /// Room for so many more slots, and for not many more than are used: free ones are taken out.
  void make_room(const Executor& executor, int more) { make_room(executor, more, used(), counts_.get(1)); }
  /// Where it is known how many there are, and how many of them are free.
  void make_room(const Executor& executor, int more, int used, int freed) {
    most_ = used + more;
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
    if (used > 0)
      parallel_for(
          executor, 1,
          TakeOutFree<R>{view(), moves ? near_to.data() : near_.data(), moves ? contacts_to.data() : contacts_.data()});
    written_ = used > written_ ? used : written_;
    if (moves) near_ = std::move(near_to), contacts_ = std::move(contacts_to), written_ = used - freed;
    most_ = used - freed + more;
    empty_from(static_cast<std::size_t>(used - freed));
  }

  /// Cells are no longer what they were.
  void forget_cells(const Executor& executor) { parallel_for(executor, slots(), ForgetCells{near_.data()}); }

  /// What a later substep depends on. `first`: pair of the mesh.
  void append_to(ContactMemory& all, long long first) const {
    const std::vector<WordBall> balls = balls_.download();
    const std::vector<float> at = at_.download(), distance = distance_.download();
    const std::size_t n = distance.size();
    all.balls.insert(all.balls.end(), balls.begin(), balls.end());
    for (std::size_t i = 0; i < n; ++i)
      if (!balls[i / kWord].keeps_all()) all.places.push_back({at[i], at[n + i], at[2 * n + i], distance[i]});
    const auto slots = static_cast<std::size_t>(used());
    std::vector<Contact<R>> contacts(slots);
    std::vector<Near> near(slots);
    Memory<Executor>::copy_out(contacts_.data(), slots, contacts.data());
    Memory<Executor>::copy_out(near_.data(), slots, near.data());
    const auto begin = static_cast<std::ptrdiff_t>(all.near.size());
    for (std::size_t s = 0; s < slots; ++s)
      if (contacts[s].particle >= 0) all.near.push_back({first + contacts[s].particle, near[s].seen});
    std::sort(all.near.begin() + begin, all.near.end(), [](const auto& a, const auto& b) { return a.pair < b.pair; });
  }
  /// Of this mesh: its balls, its places and what is near.
  void remember(const Executor& executor, const std::vector<WordBall>& balls, const PlaceSeen* place,
                const std::vector<SeenOfPair>& near, long long first) {
    const std::size_t n = slot_.size();
    std::vector<float> at(3 * n), distance(n);
    for (std::size_t i = 0; i < n; ++i) {
      const WordBall& ball = balls[i / kWord];
      const PlaceSeen seen = ball.keeps_all() ? PlaceSeen{ball.x, ball.y, ball.z, ball.from_middle()} : *place++;
      at[i] = seen.x, at[n + i] = seen.y, at[2 * n + i] = seen.z, distance[i] = seen.distance;
      if (std::isnan(distance[i])) distance[i] = -INFINITY;  // beyond float: what is near says it itself
    }
    at_.upload(at), distance_.upload(distance);
    slot_.upload(std::vector<int>(n, -1)), counts_.upload({0, 0});
    empty_from(0);
    const int count = static_cast<int>(near.size());
    make_room(executor, count);
    if (count > 0) {
      const Array<Executor, SeenOfPair> seen(near);
      parallel_for(executor, 1, SeeAll<R>{view(), seen.data(), count, first});
    }
    balls_.upload(balls);
  }

  void forget(const Executor& executor) {
    const std::size_t n = slot_.size();
    const std::vector<PlaceSeen> places(n, {0, 0, 0, -INFINITY});
    remember(executor, std::vector<WordBall>(balls_.size(), WordBall{}), places.data(), {}, 0);
  }

  static constexpr std::size_t kSlotBytes = sizeof(Near) + sizeof(Contact<R>);
  int near() const { return used() - counts_.get(1); }
  /// Of slots that were ever filled: there is room for more, in pages that nothing was written to.
  std::size_t near_bytes() const { return static_cast<std::size_t>(std::max(written_, used())) * kSlotBytes; }
  std::size_t bytes() const { return at_.bytes() + distance_.bytes() + balls_.bytes() + slot_.bytes() + near_bytes(); }

 private:
  int used() const { return counts_.get(0); }

  /// A device looks at all slots that may be filled.
  void empty_from([[maybe_unused]] std::size_t slot) {
    if constexpr (!Memory<Executor>::kOfTheHost) {
      Contact<R> none{};
      let_go(none);
      Memory<Executor>::fill(contacts_.data() + slot, contacts_.size() - slot, none);
    }
  }

  static constexpr int kSpare = 32;  // slots: fewer are not worth a copy
  Array<Executor, float> at_, distance_;
  Array<Executor, WordBall> balls_;
  Array<Executor, int> slot_;
  Array<Executor, int> counts_;           // of slots, and of free ones among them
  Array<Executor, Contact<R>> contacts_;  // of each slot
  Array<Executor, Near> near_;            // the same
  int written_ = 0;                       // slots, since there is this room
  int most_ = 0;                          // slots that may be filled
};

}  // namespace malha
