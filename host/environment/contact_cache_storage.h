// SPDX-License-Identifier: Apache-2.0
// The memory behind kernels/environment/contact_cache.h: of the particles near one environment mesh.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "host/base/array.h"
#include "host/environment/contact_memory.h"
#include "kernels/environment/contact_cache.h"
#include "kernels/parallel/compute.h"

namespace malha {

/// What memory for pieces that are handed out has to do before so many more are: `size` pieces have room there, and
/// fewer free ones than `spare` are not worth a copy.
struct RoomForMore {
  bool tidies, moves;  // free pieces are taken out; what is kept goes to other memory
  std::size_t room;    // pieces of the other memory
  RoomForMore(const Handed& handed, int more, std::size_t size, int spare) {
    const std::size_t used = static_cast<std::size_t>(handed.used), added = static_cast<std::size_t>(more);
    const std::size_t needed = used - static_cast<std::size_t>(handed.freed) + added;
    const bool wide = size > 4 * needed + 32 * static_cast<std::size_t>(spare);
    tidies = handed.freed > handed.used / 4 + spare || used + added > size || wide;
    moves = needed > size || wide;
    room = needed + needed / 8 + (more > 0 ? static_cast<std::size_t>(spare / 2) : 0);
  }
};

template <class Executor, class R>
class NearMemory {
 public:
  explicit NearMemory(std::size_t particles)
      : particles_(particles),
        boxes_(words_of(particles), WordBox{}),
        which_(words_of(particles), -1),
        handed_(2, Handed{}) {}

  ContactCacheView<R> view() const {
    return {boxes_.data(), which_.data(),  places_.data(),    contacts_.data(),
            near_.data(),  handed_.data(), handed_.data() + 1};
  }

  /// How many may be filled: on a device at most so many, as nobody waits for the number.
  int slots() const { return Memory<Executor>::kOnHost ? slots_handed().used : most_; }

  /// Room for so many more slots and places of words, and for not many more than are used: free ones are taken out.
  void reserve_slots(const Executor& executor, int slots, int places) {
    reserve_slots(executor, slots, slots_handed(), places, places_handed());
  }
  /// Where it is known how many there are, and how many of them are free.
  void reserve_slots(const Executor& executor, int slots, const Handed& of_slots, int places, const Handed& of_places) {
    make_room_for_slots(executor, slots, of_slots);
    make_room_for_places(executor, places, of_places);
  }

  /// Cells are no longer what they were.
  void forget_cells(const Executor& executor) { parallel_for(executor, slots(), ForgetCells{near_.data()}); }

  /// What a later substep depends on, as ContactMemory has it. Of what is beyond float its slot tells all.
  std::vector<WordBox> boxes() const { return boxes_.download(); }
  std::vector<PlaceSeen> places() const {
    const std::vector<int> which = which_.download();
    const auto own = first_of(places_, static_cast<std::size_t>(places_handed().used));
    std::vector<PlaceSeen> all;
    for (std::size_t word = 0; word < which.size(); ++word)
      for (int k = 0; which[word] >= 0 && k < particles_in(word, particles_); ++k) {
        const PlaceSeen at = own[static_cast<std::size_t>(which[word])].of(k);
        const bool finite = std::isfinite(at.x) && std::isfinite(at.y) && std::isfinite(at.z);
        all.push_back(finite ? at : PlaceSeen{0, 0, 0, -INFINITY});
      }
    return all;
  }
  /// `first`: pair of the mesh.
  std::vector<SeenOfPair> near_pairs(long long first) const {
    const auto slots = static_cast<std::size_t>(slots_handed().used);
    const std::vector<Contact<R>> contacts = first_of(contacts_, slots);
    const std::vector<ProximityRecord> near = first_of(near_, slots);
    std::vector<SeenOfPair> all;
    for (std::size_t s = 0; s < slots; ++s)
      if (contacts[s].particle >= 0) all.push_back({first + contacts[s].particle, near[s].seen});
    std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.pair < b.pair; });
    return all;
  }
  /// Places of particles there are at most.
  std::size_t most_places() const { return static_cast<std::size_t>(places_handed().used) * kGroupSize; }
  /// Of this mesh: its boxes, its places and what is near, of which there are so many.
  void restore_state(const Executor& executor, std::vector<WordBox> boxes, const PlaceSeen* place,
                     const SeenOfPair* near, std::size_t count, long long first) {
    std::vector<int> which(boxes.size(), -1);
    std::vector<WordPlaces> places;
    std::vector<Contact<R>> contacts(count);
    std::vector<ProximityRecord> of_slots(count);
    const auto places_for = [&](std::size_t word) -> WordPlaces& {
      if (which[word] < 0) {
        which[word] = static_cast<int>(places.size());
        WordPlaces& own = places.emplace_back();
        own.word = static_cast<int>(word);
        for (int k = 0; k < kGroupSize; ++k) own.set(k, {0, 0, 0, -INFINITY}), own.slot[k] = -1;
      }
      return places[static_cast<std::size_t>(which[word])];
    };
    for (std::size_t word = 0; word < boxes.size(); ++word)
      for (int k = 0; boxes[word].is_of_each() && k < particles_in(word, particles_); ++k)
        places_for(word).set(k, *place++);
    for (std::size_t s = 0; s < count; ++s) {
      contacts[s].particle = static_cast<int>(near[s].pair - first);
      ContactCacheView<R>::clear_slot(contacts[s], of_slots[s]);
      of_slots[s].seen = near[s].seen;
      const auto word = static_cast<std::size_t>(contacts[s].particle / kGroupSize);
      places_for(word).slot[contacts[s].particle % kGroupSize] = static_cast<int>(s);
      if (!boxes[word].is_of_each()) boxes[word].leave_to_each();
    }
    handed_.upload({{}, {}});
    const int slots = static_cast<int>(count), words = static_cast<int>(places.size());
    reserve_slots(executor, slots, {}, words, {});
    empty_from(0);
    fill_first(places_, places), fill_first(contacts_, contacts), fill_first(near_, of_slots);
    handed_.upload({{slots, 0}, {words, 0}}), which_.upload(which), boxes_.upload(boxes);
  }

  void forget(const Executor& executor) {
    restore_state(executor, std::vector<WordBox>(boxes_.size(), WordBox{}), nullptr, nullptr, 0, 0);
  }

  static constexpr std::size_t kSlotBytes = sizeof(ProximityRecord) + sizeof(Contact<R>);
  int near() const {
    const Handed handed = slots_handed();
    return handed.used - handed.freed;
  }
  /// Of slots that were ever filled: there is room for more, in pages that nothing was written to.
  std::size_t near_bytes() const { return near_bytes(slots_handed()); }
  std::size_t bytes() const {
    const std::vector<Handed> handed = handed_.download();  // in one read
    const auto places = static_cast<std::size_t>(std::max(places_written_, handed[1].used));
    return boxes_.bytes() + which_.bytes() + places * sizeof(WordPlaces) + near_bytes(handed[0]);
  }

 private:
  Handed slots_handed() const { return handed_.get(0); }
  Handed places_handed() const { return handed_.get(1); }
  std::size_t near_bytes(const Handed& handed) const {
    return static_cast<std::size_t>(std::max(written_, handed.used)) * kSlotBytes;
  }

  void make_room_for_slots(const Executor& executor, int more, const Handed& handed) {
    most_ = handed.used + more;
    const RoomForMore plan(handed, more, near_.size(), kSpareSlots);
    if (!plan.tidies) return;
    Array<Executor, ProximityRecord> near_to(plan.moves ? plan.room : 0);
    Array<Executor, Contact<R>> contacts_to(plan.moves ? plan.room : 0);
    if (handed.used > 0)
      parallel_for(executor, 1,
                   CompactSlots<R>{view(), plan.moves ? near_to.data() : near_.data(),
                                   plan.moves ? contacts_to.data() : contacts_.data()});
    const int kept = handed.used - handed.freed;
    written_ = std::max(written_, handed.used);
    if (plan.moves) near_ = std::move(near_to), contacts_ = std::move(contacts_to), written_ = kept;
    most_ = kept + more;
    empty_from(static_cast<std::size_t>(kept));
  }
  void make_room_for_places(const Executor& executor, int more, const Handed& handed) {
    const RoomForMore plan(handed, more, places_.size(), kSparePlaces);
    if (!plan.tidies) return;
    Array<Executor, WordPlaces> to(plan.moves ? plan.room : 0);
    if (handed.used > 0)
      parallel_for(executor, 1, TakeOutFreePlaces<R>{view(), plan.moves ? to.data() : places_.data()});
    places_written_ = std::max(places_written_, handed.used);
    if (plan.moves) places_ = std::move(to), places_written_ = handed.used - handed.freed;
  }

  template <class T>
  static std::vector<T> first_of(const Array<Executor, T>& array, std::size_t count) {
    std::vector<T> values(count);
    if (count > 0) Memory<Executor>::copy_out(array.data(), count, values.data());
    return values;
  }
  template <class T>
  static void fill_first(const Array<Executor, T>& array, const std::vector<T>& values) {
    if (!values.empty()) Memory<Executor>::copy_in(values.data(), values.size(), array.data());
  }

  /// A device looks at all slots that may be filled.
  void empty_from([[maybe_unused]] std::size_t slot) {
    if constexpr (!Memory<Executor>::kOnHost) {
      Contact<R> none{};
      invalidate(none);
      Memory<Executor>::fill(contacts_.data() + slot, contacts_.size() - slot, none);
    }
  }

  static constexpr int kSpareSlots = 32, kSparePlaces = Memory<Executor>::kOnHost ? 4 : 32;
  std::size_t particles_;
  Array<Executor, WordBox> boxes_;
  Array<Executor, int> which_;             // of each word
  Array<Executor, Handed> handed_;         // slots, and places of words
  Array<Executor, WordPlaces> places_;     // of words
  Array<Executor, Contact<R>> contacts_;   // of each slot
  Array<Executor, ProximityRecord> near_;  // the same
  int written_ = 0, places_written_ = 0;   // slots, and places, since there is this room
  int most_ = 0;                           // slots that may be filled
};

}  // namespace malha
