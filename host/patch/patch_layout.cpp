// SPDX-License-Identifier: Apache-2.0
#include "host/patch/patch_layout.h"

#include <algorithm>
#include <map>
#include <numeric>

#include "host/model/ordering/colour.h"
#include "host/model/ordering/runs.h"

namespace malha {

namespace {

class PatchBuilder {
 public:
  PatchBuilder(const Model& model, const std::vector<ByOwner>& owned, const SharedColours& shared, int patch,
               const std::vector<int>& neighbours)
      : model_(model), owned_(owned), shared_(shared), patch_(patch) {
    begin_ = model.patches.begin[patch], end_ = model.patches.begin[patch + 1];
    particles_.resize(end_ - begin_);
    std::iota(particles_.begin(), particles_.end(), begin_);
    particles_.insert(particles_.end(), neighbours.begin(), neighbours.end());
    std::sort(particles_.begin(), particles_.end());
  }

  PatchLayout build() {
    if (!try_columns()) use_rows();
    piece_.segments.clear();
    add_segments();
    piece_.patch.segments = static_cast<int>(piece_.segments.size());
    piece_.patch.batches = static_cast<int>(piece_.batches.size());
    return std::move(piece_);
  }

 private:
  /// Number of padding particles of a gathered batch: padding lanes of a pack have particles of their own.
  int padding_particles() const {
    int arity = 4;
    for (const ConstraintSet& set : model_.sets) arity = std::max(arity, set.arity);
    return arity * kSlotPack;
  }

  /// Lays the patch out as a structure of arrays, with particles sorted by class, if enough constraints then form runs.
  bool try_columns() {
    const auto& class_of = model_.patches.class_of;
    if (std::any_of(particles_.begin(), particles_.end(), [&](int i) { return class_of[i] == kNoClass; })) return false;
    const std::vector<int> in_order = particles_;
    std::stable_sort(particles_.begin(), particles_.end(), [&](int a, int b) { return class_of[a] < class_of[b]; });
    std::vector<std::uint8_t> classes;
    for (const int i : particles_) classes.push_back(class_of[i]);
    const ClassLayout layout = lay_out_classes(classes);
    class_of_slot_.assign(layout.slots, 0);
    for (std::size_t i = 0; i < classes.size(); ++i) class_of_slot_[layout.slot[i]] = classes[i];
    slot_ = layout.slot;
    spares_ = layout.slots;
    add_sets(true);
    int in_runs = 0, all = 0;
    for (std::size_t s = 0; s < owned_.size(); ++s) {
      in_runs += piece_.sets[s].in_runs;
      all += owned_[s].begin[patch_ + 1] - owned_[s].begin[patch_];
    }
    if (layout.slots + padding_particles() <= kMostSlots && should_use_runs(in_runs, all)) {
      piece_.patch.columns = true;
      piece_.patch.slots = layout.slots + padding_particles();
      return true;
    }
    particles_ = in_order;
    return false;
  }

  void use_rows() {
    slot_.resize(particles_.size());
    std::iota(slot_.begin(), slot_.end(), 0);
    spares_ = static_cast<int>(particles_.size());
    add_sets(false);
    piece_.patch.columns = false;
    piece_.patch.slots = spares_ + padding_particles();
  }

  void add_segments() {
    for (const int i : particles_) origin_.try_emplace(model_.patches.island_of(i), i);
    const auto at = [this](std::size_t n) {
      const int i = particles_[n], colour = shared_.colour[patch_];
      const bool movable = model_.w[i] > 0;
      const int body = model_.patches.island_of(i);
      const bool alone = !movable || shared_.last[i] < 0;
      return Segment{i,
                     slot_[n],
                     1,
                     origin_.at(body),
                     body,
                     alone || shared_.first[i] == colour,
                     alone || shared_.last[i] == colour,
                     movable};
    };
    for (std::size_t n = 0; n < particles_.size(); ++n) {
      const Segment next = at(n);
      if (!piece_.segments.empty()) {
        Segment& last = piece_.segments.back();
        if (last.global + last.count == next.global && last.local + last.count == next.local &&
            last.body == next.body && last.first_solve == next.first_solve && last.last_solve == next.last_solve &&
            last.movable == next.movable) {
          ++last.count;
          continue;
        }
      }
      piece_.segments.push_back(next);
    }
  }

  void add_sets(bool with_runs) {
    // The slot of each particle: own ones are looked up by number, the others by search.
    std::vector<int> sorted(particles_.size());
    std::iota(sorted.begin(), sorted.end(), 0);
    std::sort(sorted.begin(), sorted.end(), [this](int a, int b) { return particles_[a] < particles_[b]; });
    std::vector<int> own(end_ - begin_);
    for (std::size_t n = 0; n < particles_.size(); ++n)
      if (begin_ <= particles_[n] && particles_[n] < end_) own[particles_[n] - begin_] = slot_[n];
    const auto slot_of = [&](int i) {
      if (begin_ <= i && i < end_) return own[i - begin_];
      const auto found =
          std::lower_bound(sorted.begin(), sorted.end(), i, [this](int n, int value) { return particles_[n] < value; });
      return slot_[*found];
    };
    std::vector<bool> pinned(*std::max_element(slot_.begin(), slot_.end()) + 1, false);
    for (std::size_t n = 0; n < particles_.size(); ++n) pinned[slot_[n]] = model_.w[particles_[n]] == 0;

    piece_.sets.assign(owned_.size(), SetPlan{});
    piece_.batches.clear();
    for (std::size_t s = 0; s < owned_.size(); ++s) {
      const ConstraintSet& set = model_.sets[s];
      std::vector<int> constraints(owned_[s].list.begin() + owned_[s].begin[patch_],
                                   owned_[s].list.begin() + owned_[s].begin[patch_ + 1]);
      std::vector<int> local;
      local.reserve(constraints.size() * set.arity);
      for (const int c : constraints)
        for (int j = 0; j < set.arity; ++j) local.push_back(slot_of(set.particles[c * set.arity + j]));
      const std::size_t before = piece_.batches.size();
      if (with_runs) {
        std::vector<int> island;
        for (const int c : constraints) island.push_back(model_.patches.island_of(set.particles[c * set.arity]));
        const Runs runs = find_runs(local, set.arity, class_of_slot_, island);
        for (const Run& run : runs.runs) add_run(static_cast<int>(s), run, constraints, local);
        piece_.sets[s].in_runs = runs.contiguous();
        std::vector<int> loose, loose_local;
        for (const int c : runs.loose) {
          loose.push_back(constraints[c]);
          for (int j = 0; j < set.arity; ++j) loose_local.push_back(local[c * set.arity + j]);
        }
        constraints = std::move(loose), local = std::move(loose_local);
      }
      add_gathered(static_cast<int>(s), constraints, local, pinned);
      piece_.sets[s].most_batches = static_cast<int>(piece_.batches.size() - before);
    }
  }

  void add_run(int s, const Run& run, const std::vector<int>& constraints, const std::vector<int>& local) {
    auto& slots = piece_.sets[s].constraint;
    const int arity = model_.sets[s].arity;
    Batch batch{};
    batch.set = s, batch.slot = static_cast<int>(slots.size()), batch.count = static_cast<int>(run.slots.size());
    batch.run = true;
    for (int j = 0; j < arity; ++j) batch.from[j] = static_cast<LocalIndex>(local[run.slots[0] * arity + j]);
    for (const int c : run.slots) slots.push_back(c < 0 ? -1 : constraints[c]);
    while (slots.size() % kSlotPack != 0) slots.push_back(-1);
    piece_.batches.push_back(batch);
  }

  /// Adds gathered batches colour by colour, those without pins first.
  void add_gathered(int s, const std::vector<int>& constraints, const std::vector<int>& local,
                    const std::vector<bool>& pinned) {
    const int arity = model_.sets[s].arity;
    const Colouring colouring = colour(local, arity, pinned);
    std::vector<std::vector<int>> members(2 * colouring.count);
    for (std::size_t c = 0; c < constraints.size(); ++c) {
      const bool pins = std::any_of(&local[c * arity], &local[c * arity] + arity, [&](int i) { return pinned[i]; });
      members[2 * colouring.colour[c] + pins].push_back(static_cast<int>(c));
    }
    SetPlan& set = piece_.sets[s];
    for (std::size_t k = 0; k < members.size(); ++k) {
      if (members[k].empty()) continue;
      Batch batch{};
      batch.set = s, batch.slot = static_cast<int>(set.constraint.size());
      batch.index = static_cast<int>(set.index[0].size());
      batch.count = static_cast<int>(members[k].size());
      batch.pins = k % 2 == 1;
      for (const int c : members[k]) {
        set.constraint.push_back(constraints[c]);
        for (int j = 0; j < arity; ++j) set.index[j].push_back(static_cast<LocalIndex>(local[c * arity + j]));
      }
      while (set.constraint.size() % kSlotPack != 0) {
        const auto spare = static_cast<int>(set.constraint.size() % kSlotPack);
        set.constraint.push_back(-1);
        for (int j = 0; j < arity; ++j)
          set.index[j].push_back(static_cast<LocalIndex>(spares_ + j * kSlotPack + spare));
      }
      piece_.batches.push_back(batch);
    }
  }

  const Model& model_;
  const std::vector<ByOwner>& owned_;
  const SharedColours& shared_;
  const int patch_;
  int begin_ = 0, end_ = 0;     // the patch's own particles
  std::vector<int> particles_;  // with the neighbours, in the order of their slots
  std::vector<int> slot_;       // of each
  std::map<int, int> origin_;   // one particle of each body
  int spares_ = 0;              // first padding slot, behind all particles
  std::vector<std::uint8_t> class_of_slot_;
  PatchLayout piece_;
};

}  // namespace

PatchLayout lay_out_patch(const Model& model, const std::vector<ByOwner>& owned, const SharedColours& shared, int patch,
                          const std::vector<int>& neighbours) {
  return PatchBuilder(model, owned, shared, patch, neighbours).build();
}

}  // namespace malha
