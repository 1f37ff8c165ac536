// SPDX-License-Identifier: Apache-2.0
#include "host/model/ordering/patches.h"

#include <algorithm>
#include <numeric>

#include "host/base/parallel_tasks.h"
#include "host/model/model.h"
#include "host/model/ordering/colour.h"
#include "host/model/ordering/runs.h"
#include "kernels/projection/patch.h"

namespace malha {

namespace {

constexpr int kSizes[] = {128, 192, 256, 384, 512, 768, 1024, 1536, 2048, 3072, 4096, 6144, 8192};
constexpr int kMinPatches = 32;    // keep the threads of a CPU busy
constexpr int kMaxForeign = 4096;  // with a patch's own particles and the padding below the range of a LocalIndex
constexpr int kPadding = 256;      // slots of a patch's memory that are not particles

/// The lowest and the highest particle of each constraint of all sets.
struct Spans {
  std::vector<int> low, high;
  explicit Spans(const std::vector<ConstraintSet>& sets) {
    for (const ConstraintSet& set : sets)
      for (auto c = set.particles.begin(); c != set.particles.end(); c += set.arity) {
        const auto [a, b] = std::minmax_element(c, c + set.arity);
        low.push_back(*a), high.push_back(*b);
      }
  }
};

/// The smallest patch size at which few constraints cross patches. A tenth of them corresponds to eight rows of a
/// sheet; thinner strips converge worse.
int patch_size(const Spans& spans, int particles, const PatchBounds& bounds) {
  const int least = std::max(bounds.min_particles, std::min(bounds.preferred_particles, particles / kMinPatches));
  for (const int size : kSizes) {
    if (size < least || size > bounds.max_particles) continue;
    std::size_t crossing = 0;
    for (std::size_t c = 0; c < spans.low.size(); ++c) crossing += spans.low[c] / size != spans.high[c] / size;
    if (100 * crossing <= static_cast<std::size_t>(bounds.max_cut_percent) * spans.low.size()) return size;
  }
  return bounds.max_particles;
}

/// First particles of the patches, each at the fewest crossing constraints near a multiple of the patch size.
std::vector<int> cut_positions(const Spans& spans, int particles, int size) {
  const int count = std::max(1, (particles + size / 2) / size);
  std::vector<int> crossing(particles + 1, 0);  // number of constraints that cross a cut before each particle
  for (std::size_t c = 0; c < spans.low.size(); ++c) ++crossing[spans.low[c] + 1], --crossing[spans.high[c] + 1];
  std::partial_sum(crossing.begin(), crossing.end(), crossing.begin());
  std::vector<int> begin{0};
  for (int k = 1; k < count; ++k) {
    const int target = static_cast<int>(std::int64_t{particles} * k / count), radius = size / 4;
    int best = target;
    for (int at = target - radius; at <= target + radius; ++at)
      if (at > begin.back() && at < particles &&
          (crossing[at] < crossing[best] ||
           (crossing[at] == crossing[best] && std::abs(at - target) < std::abs(best - target))))
        best = at;
    begin.push_back(best);
  }
  begin.push_back(particles);
  return begin;
}

/// Calls visit(particles, arity) for each edge and each constraint.
template <class Visit>
void for_each_link(const std::vector<ConstraintSet>& sets, const std::vector<Edge>& edges, const Visit& visit) {
  for (const Edge& e : edges) visit(e.data(), 2);
  for (const ConstraintSet& set : sets)
    for (std::size_t c = 0; c < set.particles.size(); c += set.arity) visit(&set.particles[c], set.arity);
}

/// Colours particles greedily in their order, so that those of an edge or constraint differ. On a square grid the
/// classes are the even and odd rows and columns.
std::vector<std::uint8_t> particle_classes(const std::vector<ConstraintSet>& sets, const std::vector<Edge>& edges,
                                           int particles) {
  struct Link {
    const int* particles;
    int arity;
  };
  const CompressedLists<Link> links(particles, [&](const auto& add) {
    for_each_link(sets, edges, [&](const int* of, int arity) {
      std::for_each(of, of + arity, [&](int i) { add(i, {of, arity}); });
    });
  });
  UsedColours used(particles);
  std::vector<std::uint8_t> class_of(particles);
  for (int i = 0; i < particles; ++i) {
    const int chosen = used.lowest_free(&i, 1);
    class_of[i] = static_cast<std::uint8_t>(std::min<int>(chosen, kNoClass));
    if (chosen >= kNoClass) continue;
    for (const Link& l : links[i]) used.use(chosen, l.particles, l.arity);
  }
  return class_of;
}

/// Sorts the particles of each patch of a cut.
struct PatchSorter {
  const std::vector<ConstraintSet>& sets;
  const std::vector<int>& island;
  const Patches& patches;
  std::vector<int> patch_of;
  std::vector<ByOwner> owned;        // of each set
  std::vector<std::uint8_t> shared;  // whether more than one patch uses the particle
  int max_used = 0;                  // upper bound of the particles that a patch uses
  std::vector<int>& order;

  PatchSorter(const std::vector<ConstraintSet>& all, const std::vector<int>& islands, const Patches& cut,
              std::vector<int>& result)
      : sets(all),
        island(islands),
        patches(cut),
        patch_of(patch_of_particles(cut)),
        shared(islands.size(), 0),
        order(result) {
    std::vector<int> foreign(cut.count(), 0);
    for (const ConstraintSet& set : all) {
      const std::vector<int> owner = owners(set, patch_of, foreign);
      for (std::size_t e = 0; e < set.particles.size(); ++e)
        if (patch_of[set.particles[e]] != owner[e / set.arity]) shared[set.particles[e]] = 1;
      owned.push_back(by_owner(owner, cut.count()));
    }
    for (int k = 0; k < cut.count(); ++k) max_used = std::max(max_used, cut.begin[k + 1] - cut.begin[k] + foreign[k]);
  }

  void operator()(int patch) const {
    const auto first = order.begin() + patches.begin[patch], last = order.begin() + patches.begin[patch + 1];
    if (prefers_runs(patch))
      std::stable_sort(first, last, [&](int a, int b) {
        return island[a] != island[b] ? island[a] < island[b] : patches.class_of[a] < patches.class_of[b];
      });
    else
      std::stable_sort(first, last, [&](int a, int b) {
        return island[a] != island[b] ? island[a] < island[b] : shared[a] > shared[b];
      });
  }

  /// True if enough of the constraints that lie completely in the patch would be contiguous.
  bool prefers_runs(int patch) const {
    const int begin = patches.begin[patch], count = patches.begin[patch + 1] - begin;
    std::vector<int> sorted(count);
    std::iota(sorted.begin(), sorted.end(), begin);
    const auto& class_of = patches.class_of;
    if (std::ranges::any_of(sorted, [&](int i) { return class_of[i] == kNoClass; })) return false;
    std::ranges::stable_sort(sorted, [&](int a, int b) { return class_of[a] < class_of[b]; });
    std::vector<std::uint8_t> class_at(count);
    for (int i = 0; i < count; ++i) class_at[i] = class_of[sorted[i]];
    const ClassLayout layout = lay_out_classes(class_at);
    std::vector<int> slot(count);
    std::vector<std::uint8_t> class_of_slot(layout.slots);
    for (int i = 0; i < count; ++i)
      slot[sorted[i] - begin] = layout.slot[i], class_of_slot[layout.slot[i]] = class_at[i];
    int contiguous = 0, all = 0;
    for (std::size_t s = 0; s < sets.size(); ++s) {
      std::vector<int> particles;
      for (const int c : owned[s][patch]) {
        const int* of = &sets[s].particles[c * sets[s].arity];
        if (std::any_of(of, of + sets[s].arity, [&](int i) { return patch_of[i] != patch; })) continue;
        for (int j = 0; j < sets[s].arity; ++j) particles.push_back(slot[of[j] - begin]);
      }
      contiguous += find_runs(particles, sets[s].arity, class_of_slot).contiguous();
      all += static_cast<int>(particles.size()) / sets[s].arity;
    }
    return should_use_runs(contiguous, all);
  }
};

}  // namespace

std::vector<int> patch_of_particles(const Patches& patches) {
  std::vector<int> patch_of(patches.begin.back());
  for (int k = 0; k < patches.count(); ++k)
    std::fill(patch_of.begin() + patches.begin[k], patch_of.begin() + patches.begin[k + 1], k);
  return patch_of;
}

std::vector<int> owners(const ConstraintSet& set, const std::vector<int>& patch_of, std::vector<int>& foreign) {
  std::vector<int> owner(set.count());
  std::vector<int> noted(patch_of.size(),
                         -1);  // last patch that counted each particle as foreign, so that it counts once
  for (int c = 0; c < set.count(); ++c) {
    const int* of = &set.particles[c * set.arity];
    int lowest = patch_of[of[0]], lowest_free = -1;
    for (int j = 0; j < set.arity; ++j) {
      const int k = patch_of[of[j]];
      lowest = std::min(lowest, k);
      if (foreign[k] < kMaxForeign && (lowest_free < 0 || k < lowest_free)) lowest_free = k;
    }
    owner[c] = lowest_free < 0 ? lowest : lowest_free;
    for (int j = 0; j < set.arity; ++j)
      if (patch_of[of[j]] != owner[c] && noted[of[j]] != owner[c]) ++foreign[owner[c]], noted[of[j]] = owner[c];
  }
  return owner;
}

ByOwner by_owner(const std::vector<int>& owner, int patches) {
  return {static_cast<std::size_t>(patches), [&](const auto& add) {
            for (std::size_t c = 0; c < owner.size(); ++c) add(owner[c], static_cast<int>(c));
          }};
}

ClassLayout lay_out_classes(const std::vector<std::uint8_t>& class_of) {
  constexpr int pack = kSlotPack;
  ClassLayout layout;
  layout.slot.resize(class_of.size());
  for (std::size_t i = 0; i < class_of.size(); ++i) {
    if (i > 0 && class_of[i] != class_of[i - 1]) layout.slots = (layout.slots + pack - 1) / pack * pack + pack;
    layout.slot[i] = layout.slots++;
  }
  layout.slots = (layout.slots + pack - 1) / pack * pack + pack;
  return layout;
}

bool should_use_runs(int contiguous, int constraints) { return constraints > 0 && 10 * contiguous >= 7 * constraints; }

Cut cut_into_patches(const std::vector<ConstraintSet>& sets, const std::vector<Edge>& edges,
                     const std::vector<int>& island, int threads, const PatchBounds& bounds) {
  const int particles = static_cast<int>(island.size());
  const Spans spans(sets);
  Patches patches{{}, particle_classes(sets, edges, particles), bounds};
  Cut cut;
  cut.order.resize(particles);
  std::iota(cut.order.begin(), cut.order.end(), 0);
  const int slots = bounds.slots > 0 ? std::min(bounds.slots, kMostSlots) : kMostSlots;
  // In a densely connected graph smaller patches use fewer foreign particles each.
  for (int size = patch_size(spans, particles, bounds);; size /= 2) {
    patches.begin = cut_positions(spans, particles, size);
    const PatchSorter sort(sets, island, patches, cut.order);
    if (sort.max_used > slots - kPadding && size > bounds.min_particles) continue;
    parallel_tasks(OpenMP{threads}, patches.count(), sort);
    break;
  }
  cut.patches.begin = patches.begin, cut.patches.bounds = bounds;
  for (const int i : cut.order) cut.patches.class_of.push_back(patches.class_of[i]);
  return cut;
}

}  // namespace malha
