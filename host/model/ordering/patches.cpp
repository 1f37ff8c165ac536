// SPDX-License-Identifier: Apache-2.0
#include "host/model/ordering/patches.h"

#include <algorithm>
#include <numeric>
#include <span>
#include <utility>

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

/// The fewest particles of a patch that are worth a solve, of so many particles.
int least_size(int particles, const PatchBounds& bounds) {
  return std::max(bounds.min_particles, std::min(bounds.preferred_particles, particles / kMinPatches));
}

/// The lowest and the highest particle of each constraint of all sets.
struct Spans {
  std::vector<int> low, high;
  std::vector<int> crossing;  // number of constraints that a cut before each particle, or behind the last, crosses
  Spans(const std::vector<ConstraintSet>& sets, int particles) : crossing(particles + 1, 0) {
    for (const ConstraintSet& set : sets)
      for (auto c = set.particles.begin(); c != set.particles.end(); c += set.arity) {
        const auto [a, b] = std::minmax_element(c, c + set.arity);
        low.push_back(*a), high.push_back(*b);
        ++crossing[*a + 1], --crossing[*b + 1];
      }
    std::partial_sum(crossing.begin(), crossing.end(), crossing.begin());
  }
};

/// The first particle of each island (Patches::islands), and the number of particles.
std::vector<int> find_islands(const std::vector<int>& component, const std::vector<int>& crossing) {
  const int particles = static_cast<int>(component.size());
  std::vector<int> islands{0};
  bool loose = false;  // whether the island before is of loose particles
  for (int i = 0, end; i < particles; i = end) {
    for (end = i + 1; end < particles && (component[end] == component[i] || crossing[end] > 0);) ++end;
    if (i > 0 && !(loose && end - i == 1)) islands.push_back(i);
    loose = end - i == 1;
  }
  islands.push_back(particles);
  return islands;
}

/// The smallest patch size of an island of so many particles at which few of its constraints cross patches. A tenth of
/// them corresponds to eight rows of a sheet; thinner strips converge worse. `own`: its constraints.
int patch_size(const Spans& spans, std::span<const int> own, int first, int particles, const PatchBounds& bounds) {
  const int least = least_size(particles, bounds);
  for (const int size : kSizes) {
    if (size < least || size > bounds.max_particles) continue;
    std::size_t crossing = 0;
    for (const int c : own) crossing += (spans.low[c] - first) / size != (spans.high[c] - first) / size;
    if (100 * crossing <= static_cast<std::size_t>(bounds.max_cut_percent) * own.size()) return size;
  }
  return bounds.max_particles;
}

/// Appends the first particles of the patches of the island first .. last - 1, each at the fewest crossing constraints
/// near a multiple of the patch size.
void cut_island(const std::vector<int>& crossing, int first, int last, int size, std::vector<int>& begin) {
  const int particles = last - first, count = std::max(1, (particles + size / 2) / size);
  begin.push_back(first);
  for (int k = 1; k < count; ++k) {
    const int target = first + static_cast<int>(std::int64_t{particles} * k / count), radius = size / 4;
    int best = target;
    for (int at = target - radius; at <= target + radius; ++at)
      if (at > begin.back() && at < last &&
          (crossing[at] < crossing[best] ||
           (crossing[at] == crossing[best] && std::abs(at - target) < std::abs(best - target))))
        best = at;
    begin.push_back(best);
  }
}

/// First particles of the patches if consecutive small islands share them, as long as these have at most `most`
/// particles and all have runs or none. `parts`: first particles of the patches of each island alone.
std::vector<int> merge_islands(const std::vector<int>& parts, const std::vector<int>& islands,
                               const std::vector<std::uint8_t>& has_runs, int most) {
  const auto is_island = [&](std::size_t part) {
    return std::binary_search(islands.begin(), islands.end(), parts[part]) &&
           std::binary_search(islands.begin(), islands.end(), parts[part + 1]);
  };
  std::vector<int> begin{0};
  for (std::size_t part = 1; part + 1 < parts.size(); ++part) {
    const bool joins = has_runs[part] == has_runs[part - 1] && parts[part + 1] - begin.back() <= most;
    if (!joins || !is_island(part) || !is_island(part - 1)) begin.push_back(parts[part]);
  }
  begin.push_back(parts.back());
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

/// Sorts the particles of each patch of a cut, none of which has more than one island.
struct PatchSorter {
  const std::vector<ConstraintSet>& sets;
  const std::vector<int>& component;
  const Patches& patches;
  std::vector<int> patch_of;
  std::vector<ByOwner> owned;        // of each set
  std::vector<std::uint8_t> shared;  // whether more than one patch uses the particle
  std::vector<int> max_used;         // upper bound of the particles that each patch uses
  std::vector<int>& order;
  std::vector<std::uint8_t>& has_runs;  // of each patch

  PatchSorter(const std::vector<ConstraintSet>& all, const std::vector<int>& components, const Patches& cut,
              std::vector<int>& result, std::vector<std::uint8_t>& runs)
      : sets(all),
        component(components),
        patches(cut),
        patch_of(patch_of_particles(cut)),
        shared(patch_of.size(), 0),
        max_used(cut.count(), 0),
        order(result),
        has_runs(runs) {
    for (const ConstraintSet& set : all) {
      const std::vector<int> owner = owners(set, patch_of, max_used);
      for (std::size_t e = 0; e < set.particles.size(); ++e)
        if (patch_of[set.particles[e]] != owner[e / set.arity]) shared[set.particles[e]] = 1;
      owned.push_back(by_owner(owner, cut.count()));
    }
    for (int k = 0; k < cut.count(); ++k) max_used[k] += cut.begin[k + 1] - cut.begin[k];
  }

  void operator()(int patch) const {
    const auto first = order.begin() + patches.begin[patch], last = order.begin() + patches.begin[patch + 1];
    has_runs[patch] = prefers_runs(patch);
    if (has_runs[patch])
      std::stable_sort(first, last, [&](int a, int b) {
        return component[a] != component[b] ? component[a] < component[b] : patches.class_of[a] < patches.class_of[b];
      });
    else
      std::stable_sort(first, last, [&](int a, int b) {
        return component[a] != component[b] ? component[a] < component[b] : shared[a] > shared[b];
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

int Patches::island_of(int particle) const {
  return static_cast<int>(std::upper_bound(islands.begin(), islands.end(), particle) - islands.begin()) - 1;
}

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
                     const std::vector<int>& component, const OpenMP& threads, const PatchBounds& bounds) {
  const int particles = static_cast<int>(component.size());
  const Spans spans(sets, particles);
  const std::vector<int> islands = find_islands(component, spans.crossing);
  Patches patches{{}, {islands.begin(), islands.end() - 1}, particle_classes(sets, edges, particles), bounds};
  const int count = static_cast<int>(islands.size()) - 1;
  std::vector<int> owner, size;
  for (const int i : spans.low) owner.push_back(patches.island_of(i));
  const ByOwner own = by_owner(owner, count);
  for (int k = 0; k < count; ++k)
    size.push_back(patch_size(spans, own[k], islands[k], islands[k + 1] - islands[k], bounds));
  std::vector<int> order(particles);
  std::iota(order.begin(), order.end(), 0);
  std::vector<std::uint8_t> has_runs;
  const int slots = (bounds.slots > 0 ? std::min(bounds.slots, kMostSlots) : kMostSlots) - kPadding;
  for (bool fits = false; !fits;) {
    patches.begin.clear();
    for (int k = 0; k < count; ++k) cut_island(spans.crossing, islands[k], islands[k + 1], size[k], patches.begin);
    patches.begin.push_back(particles);
    has_runs.assign(patches.count(), 0);
    const PatchSorter sort(sets, component, patches, order, has_runs);
    std::vector<std::uint8_t> overflows(count, 0);
    for (int k = 0; k < patches.count(); ++k)
      if (sort.max_used[k] > slots) overflows[patches.island_of(patches.begin[k])] = 1;
    // In a densely connected graph smaller patches use fewer foreign particles each.
    fits = true;
    for (int k = 0; k < count; ++k)
      if (overflows[k] && size[k] > bounds.min_particles) size[k] /= 2, fits = false;
    if (fits) parallel_tasks(threads, patches.count(), sort);
  }
  patches.begin = merge_islands(patches.begin, islands, has_runs, std::min(least_size(particles, bounds), slots));
  std::vector<std::uint8_t> class_of;
  for (const int i : order) class_of.push_back(patches.class_of[i]);
  patches.class_of = std::move(class_of);
  return {std::move(order), std::move(patches)};
}

}  // namespace malha
