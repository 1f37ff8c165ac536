// SPDX-License-Identifier: Apache-2.0
#include "host/patch/patch_plan.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <string>

#include "host/base/disjoint_sets.h"
#include "host/base/parallel_tasks.h"
#include "host/model/ordering/colour.h"
#include "host/patch/patch_layout.h"
#include "malha/error.h"

namespace malha {

namespace {

class Planner {
 public:
  Planner(const Model& model, const OpenMP& threads)
      : model_(model), threads_(threads), patch_of_(patch_of_particles(model.patches)) {
    std::vector<int> foreign(model.patches.count(), 0);
    for (const ConstraintSet& set : model.sets)
      owned_.push_back(by_owner(owners(set, patch_of_, foreign), model.patches.count()));
  }

  PatchPlan plan() {
    const int count = model_.patches.count();
    neighbours_.resize(count);
    launch(count, [this](int k) { neighbours_[k] = neighbours(k); });
    find_colours();
    pieces_.resize(count);
    launch(count, [this](int k) { pieces_[k] = lay_out_patch(model_, owned_, shared_colours_, k, neighbours_[k]); });
    for (const PatchLayout& piece : pieces_)
      if (piece.patch.slots > kMostSlots)
        refuse(model_.scene.file, "/bodies",
               "constraints that connect " + std::to_string(piece.patch.slots) + " particles with each other directly",
               "at most " + std::to_string(kMostSlots));
    return join();
  }

 private:
  template <class Work>
  void launch(int count, const Work& work) const {
    parallel_tasks(threads_, count, work);
  }

  /// Particles of other patches that constraints of this one have, ascending.
  std::vector<int> neighbours(int k) const {
    std::vector<int> found;
    for (std::size_t s = 0; s < owned_.size(); ++s) {
      const ConstraintSet& set = model_.sets[s];
      for (int c = owned_[s].begin[k]; c < owned_[s].begin[k + 1]; ++c) {
        const int* of = &set.particles[owned_[s].list[c] * set.arity];
        std::copy_if(of, of + set.arity, std::back_inserter(found), [&](int i) { return patch_of_[i] != k; });
      }
    }
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
  }

  /// Colours the patches greedily in their order: patches that share a movable particle get different colours.
  void find_colours() {
    const int particles = model_.count(), count = model_.patches.count();
    std::vector<bool> shared(particles, false);
    for (const auto& list : neighbours_)
      for (const int i : list) shared[i] = model_.w[i] > 0;
    UsedColours used(particles);
    colour_.resize(count);
    for (int k = 0; k < count; ++k) {
      const std::vector<int> places = shared_particles(k, shared);
      const int n = static_cast<int>(places.size());
      colour_[k] = used.lowest_free(places.data(), n);
      used.use(colour_[k], places.data(), n);
    }
    const int end = align_last_colour();
    shared_colours_.first.assign(particles, std::numeric_limits<int>::max());
    shared_colours_.last.assign(particles, -1);
    for (int k = 0; k < count; ++k)
      for (const int i : shared_particles(k, shared)) {
        shared_colours_.first[i] = std::min(shared_colours_.first[i], colour_[k]);
        shared_colours_.last[i] = std::max(shared_colours_.last[i], colour_[k]);
      }
    shared_colours_.colour = colour_;
    // The backward sweep over the colours before the last ends at a particle's first one.
    for (int i = 0; i < particles; ++i)
      if (shared_colours_.last[i] != end && shared_colours_.last[i] >= 0)
        shared_colours_.last[i] = shared_colours_.first[i];
    plan_.shared = static_cast<int>(std::count(shared.begin(), shared.end(), true));
  }

  /// The particles of a patch that are in others too.
  std::vector<int> shared_particles(int k, const std::vector<bool>& shared) const {
    std::vector<int> places;
    const auto& begin = model_.patches.begin;
    for (int i = begin[k]; i < begin[k + 1]; ++i)
      if (shared[i]) places.push_back(i);
    std::copy_if(neighbours_[k].begin(), neighbours_[k].end(), std::back_inserter(places),
                 [&](int i) { return shared[i]; });
    return places;
  }

  /// Moves the last colour of each connected set of patches to the last colour of all, which it returns. Otherwise the
  /// order within one body would depend on the number of colours of another.
  int align_last_colour() {
    const int count = model_.patches.count();
    DisjointSets together(count);
    for (int k = 0; k < count; ++k)
      for (const int i : neighbours_[k])
        if (model_.w[i] > 0) together.join(k, patch_of_[i]);
    std::vector<int> last(count, 0);
    for (int k = 0; k < count; ++k) last[together.root(k)] = std::max(last[together.root(k)], colour_[k]);
    const int end = count > 0 ? *std::max_element(last.begin(), last.end()) : 0;
    for (int k = 0; k < count; ++k)
      if (colour_[k] == last[together.root(k)]) colour_[k] = end;
    return end;
  }

  /// Concatenates the patches colour by colour.
  PatchPlan join() {
    std::vector<int> order(pieces_.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [this](int a, int b) { return colour_[a] < colour_[b]; });
    plan_.sets.resize(model_.sets.size());
    for (const int k : order) {
      if (plan_.patches.empty() || colour_[k] != colour_[order[plan_.patches.size() - 1]])
        plan_.colour_begin.push_back(static_cast<int>(plan_.patches.size()));
      append(std::move(pieces_[k]));
      plan_.number.push_back(k);
    }
    plan_.colour_begin.push_back(static_cast<int>(plan_.patches.size()));
    return std::move(plan_);
  }

  void append(PatchLayout piece) {
    Patch patch = piece.patch;
    patch.segment = static_cast<int>(plan_.segments.size());
    patch.batch = static_cast<int>(plan_.batches.size());
    plan_.segments.insert(plan_.segments.end(), piece.segments.begin(), piece.segments.end());
    int slots = 0;
    for (Batch batch : piece.batches) {
      batch.first = slots;
      slots += (batch.count + kSlotPack - 1) / kSlotPack * kSlotPack;
      batch.slot += static_cast<int>(plan_.sets[batch.set].constraint.size());
      batch.index += static_cast<int>(plan_.sets[batch.set].index[0].size());
      plan_.batches.push_back(batch);
    }
    for (std::size_t s = 0; s < plan_.sets.size(); ++s) {
      SetPlan &all = plan_.sets[s], &own = piece.sets[s];
      all.constraint.insert(all.constraint.end(), own.constraint.begin(), own.constraint.end());
      for (int j = 0; j < kMostParticles; ++j)
        all.index[j].insert(all.index[j].end(), own.index[j].begin(), own.index[j].end());
      all.in_runs += own.in_runs;
      all.most_batches = std::max(all.most_batches, own.most_batches);
    }
    plan_.patches.push_back(patch);
    plan_.most_slots = std::max(plan_.most_slots, patch.slots);
    plan_.most_constraints = std::max(plan_.most_constraints, slots);
    plan_.columns += patch.columns;
  }

  const Model& model_;
  OpenMP threads_;
  std::vector<int> patch_of_, colour_;
  std::vector<ByOwner> owned_;                // of each set
  std::vector<std::vector<int>> neighbours_;  // of each patch
  SharedColours shared_colours_;
  std::vector<PatchLayout> pieces_;
  PatchPlan plan_;
};

}  // namespace

std::vector<ColourSweep> sweep_order(int colours) {
  std::vector<ColourSweep> all;
  const int turn = colours - 2;
  for (int colour = 0; colour < turn; ++colour) all.push_back({colour, Sweeps::Forward});
  if (turn >= 0) all.push_back({turn, Sweeps::Both});
  for (int colour = turn - 1; colour >= 0; --colour) all.push_back({colour, Sweeps::Backward});
  if (colours > 0) all.push_back({colours - 1, Sweeps::Both});
  return all;
}

int PatchPlan::width() const {
  int width = 0;
  for (int colour = 0; colour < colours(); ++colour)
    width = std::max(width, colour_begin[colour + 1] - colour_begin[colour]);
  return width;
}

std::size_t PatchPlan::bytes() const {
  return patches.size() * sizeof(Patch) + segments.size() * sizeof(Segment) + batches.size() * sizeof(Batch);
}

PatchPlan plan_patches(const Model& model, const OpenMP& threads) { return Planner(model, threads).plan(); }

}  // namespace malha
