// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "host/base/parallel_tasks.h"
#include "host/mesh/compressed_lists.h"
#include "host/model/rest_graph.h"
#include "kernels/parallel/compute.h"

namespace malha {

namespace {

inline constexpr int kMaxParents = 4;
inline constexpr double kMinWeight = 0.02;  // parents with a smaller weight are left out

/// A coarse particle on which a finer one depends.
struct Parent {
  int of;         // index of the coarse particle
  Vector offset;  // m, from the finer particle to it, in the tangent plane of the finer one
  double weight = 1;
};

/// A list of at most kMaxParents parents without heap memory.
struct Parents {
  std::array<Parent, kMaxParents> of;
  int count = 0;
  Parent* begin() { return of.data(); }
  Parent* end() { return of.data() + count; }
  const Parent* begin() const { return of.data(); }
  const Parent* end() const { return of.data() + count; }
};

constexpr double kTie = 0.01;  // weights with a smaller relative difference count as equal

struct Neighbour {
  int of;
  double length;  // m
};

/// Computes the weights that best reproduce the particle's position, and prefers near parents to far ones: they
/// minimise |sum w offset|^2 + e sum w^2 |offset|^2 with sum w = 1 and w >= 0.
void compute_weights(Parents& parents) {
  constexpr double e = 0.02;
  while (parents.count > 0) {
    const int n = parents.count;
    double h2 = 0;
    for (const Parent& p : parents) h2 = std::max(h2, dot(p.offset, p.offset));
    std::array<std::array<double, kMaxParents + 1>, kMaxParents> rows{};
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) rows[i][j] = h2 > 0 ? dot(parents.of[i].offset, parents.of[j].offset) / h2 : 0;
      rows[i][i] += e * rows[i][i] + 1e-9;
      rows[i][n] = 1;
    }
    for (int k = 0; k < n; ++k)  // Gauss-Jordan; the matrix is positive definite, so that no pivoting is needed
      for (int i = 0; i < n; ++i) {
        if (i == k) continue;
        const double f = rows[i][k] / rows[k][k];
        for (int j = k; j <= n; ++j) rows[i][j] -= f * rows[k][j];
      }
    double sum = 0;
    for (int k = 0; k < n; ++k) sum += parents.of[k].weight = rows[k][n] / rows[k][k];
    for (Parent& p : parents) p.weight /= sum;
    Parent* least =
        std::ranges::min_element(parents, [](const Parent& a, const Parent& b) { return a.weight < b.weight; });
    if (n == 1 || least->weight >= kMinWeight) return;
    std::copy(least + 1, parents.end(), least);
    --parents.count;
  }
}

// Tangent vectors and parallel transport on a curved surface that is unrolled near a particle. They are exact on planes
// and cylinders.

/// The direction of `offset` in the plane of `normal` (0: in space), scaled to `length`.
Vector tangent_vector(const Vector& offset, const Vector& normal, double length) {
  const Vector flat = offset - normal * dot(offset, normal);
  const double size = norm(flat), whole = norm(offset);
  if (size > 1e-6 * whole) return flat * (length / size);
  return whole > 0 ? offset * (length / whole) : Vector{0, 0, 0};  // parallel to the normal: any direction
}

/// The vector a after the smallest rotation that takes the normal `from` to `to`.
Vector parallel_transport(const Vector& a, const Vector& from, const Vector& to) {
  const double c = 1 + dot(from, to);
  if (!(c > 1e-6)) return -a;  // half a turn, about any axis
  const Vector axis = cross(from, to), once = cross(axis, a);
  return a + once + cross(axis, once) * (1 / c);
}

class Coarsener {
 public:
  Coarsener(const RestGraph& fine, const OpenMP& threads)
      : fine_(fine), threads_(threads), near_(fine.x.size(), [&](const auto& add) {
          for (const Link& l : fine.links) add(l.a, {l.b, l.length}), add(l.b, {l.a, l.length});
          for (const auto& [a, b] : fine.nearby) {
            const double length = norm(fine.x[a] - fine.x[b]);
            add(a, {b, length}), add(b, {a, length});
          }
        }) {}

  Coarsening coarsen() {
    choose();
    find_parents();
    compute_transfer();
    find_main_parents();
    build_links();
    return std::move(coarse_);
  }

 private:
  /// Chooses a maximal independent set: pins first, then along a front that advances from them, so that on grids it is
  /// every second row and column.
  void choose() {
    const int n = fine_.count();
    state_.assign(n, State::Unknown);
    std::vector<int> front;
    for (int i = 0; i < n; ++i)
      if (fine_.pinned[i] && state_[i] == State::Unknown) choose_particle(i, true), front.push_back(i);
    for (const int i : front) exclude_neighbours(i, false);
    std::vector<std::uint8_t> visited(n, 0);
    for (const int i : front) visited[i] = 1;
    for (std::size_t next = 0, start = 0; next < front.size() || start < static_cast<std::size_t>(n);) {
      if (next == front.size()) {
        if (!visited[start]) visited[start] = 1, front.push_back(static_cast<int>(start));
        ++start;
        continue;
      }
      const int i = front[next++];
      if (state_[i] == State::Unknown) choose_particle(i, false);
      for (const Neighbour& j : near_[i])
        if (!visited[j.of]) visited[j.of] = 1, front.push_back(j.of);
    }
  }
  void choose_particle(int i, bool pins_only) {
    state_[i] = State::Chosen;
    exclude_neighbours(i, pins_only);
  }
  void exclude_neighbours(int i, bool pins_only) {
    for (const Neighbour& j : near_[i])
      if (state_[j.of] == State::Unknown && (!pins_only || fine_.pinned[j.of])) state_[j.of] = State::Excluded;
  }

  /// The offset from a particle to a neighbour in the tangent plane, with the given length.
  Vector offset(int from, int to, double length) const {
    return tangent_vector(fine_.x[to] - fine_.x[from], fine_.normal[from], length);
  }

  /// Finds the parents of all particles, and chooses further coarse particles where the parents do not surround a
  /// particle, as at a boundary that the front did not meet.
  void find_parents() {
    const int n = fine_.count();
    parents_.resize(n);
    std::vector<int> all(n);
    std::iota(all.begin(), all.end(), 0);
    for (int pass = 0; !all.empty(); ++pass) {
      const auto find = [&](int k) { parents_[all[k]] = parents_of(all[k]); };
      parallel_tasks(threads_, static_cast<int>(all.size()), find, kParticleGrain);
      all = pass < kPasses ? choose_outside(all) : std::vector<int>();
    }
    std::vector<int> number(n, -1);
    for (int i = 0; i < n; ++i)
      if (state_[i] == State::Chosen) number[i] = static_cast<int>(coarse_.chosen.size()), coarse_.chosen.push_back(i);
    for (auto& parents : parents_)
      for (Parent& p : parents) p.of = number[p.of];
    chosen_of_ = std::move(number);
  }

  Parents parents_of(int i) const {
    if (state_[i] == State::Chosen) return {{Parent{i, {0, 0, 0}}}, 1};
    const auto may = [&](int j) { return state_[j] == State::Chosen && (!fine_.pinned[i] || fine_.pinned[j]); };
    std::vector<Parent> near;
    for (const Neighbour& j : near_[i])
      if (may(j.of)) add_parent(near, j.of, offset(i, j.of, j.length));
    Parents parents = nearest(near);
    compute_weights(parents);
    if (reproduction_error(parents) <= kReproduced) return parents;
    for (const Neighbour& j : near_[i]) {
      const Vector first = offset(i, j.of, j.length);
      for (const Neighbour& k : near_[j.of])
        if (may(k.of))
          add_parent(near, k.of,
                     first + parallel_transport(offset(j.of, k.of, k.length), fine_.normal[j.of], fine_.normal[i]));
    }
    parents = nearest(near);
    compute_weights(parents);
    return parents;
  }

  /// Makes those of the given particles coarse that their parents do not surround, those nearest to a parent first.
  /// Returns the particles whose parents have to be found again.
  std::vector<int> choose_outside(const std::vector<int>& all) {
    struct Outside {
      double nearest;  // logarithm of the squared distance to the nearest parent, rounded
      int i;
    };
    std::vector<Outside> outside;
    for (const int i : all)
      if (!fine_.pinned[i] && state_[i] == State::Excluded && reproduction_error(parents_[i]) > kOutside) {
        double nearest2 = HUGE_VAL;
        for (const Parent& p : parents_[i]) nearest2 = std::min(nearest2, dot(p.offset, p.offset));
        outside.push_back({std::round(std::log(nearest2) / kTie), i});
      }
    std::ranges::stable_sort(outside, [](const Outside& a, const Outside& b) { return a.nearest < b.nearest; });
    std::vector<bool> beside(fine_.count(), false), listed(fine_.count(), false);
    std::vector<int> again;
    const auto repeat = [&](int i) {
      if (!listed[i]) listed[i] = true, again.push_back(i);
    };
    for (const Outside& o : outside) {
      if (beside[o.i]) continue;
      state_[o.i] = State::Chosen;
      repeat(o.i);
      for (const Neighbour& j : near_[o.i]) {
        beside[j.of] = true;
        repeat(j.of);
        for (const Neighbour& k : near_[j.of]) repeat(k.of);
      }
    }
    return again;
  }

  /// Adds a parent; if it is known, the shorter offset is kept.
  static void add_parent(std::vector<Parent>& parents, int of, const Vector& offset) {
    for (Parent& p : parents)
      if (p.of == of) {
        if (dot(offset, offset) < dot(p.offset, p.offset)) p.offset = offset;
        return;
      }
    parents.push_back({of, offset});
  }
  /// The nearest parents. Of those at equal distances, up to rounding, the lowest indices are chosen, so that grids
  /// stay regular.
  static Parents nearest(std::vector<Parent>& near) {
    double h2 = 0;
    for (const Parent& p : near) h2 = std::max(h2, dot(p.offset, p.offset));
    const auto rounded = [h2](const Parent& p) {
      return h2 > 0 ? std::llround(1e6 * dot(p.offset, p.offset) / h2) : 0LL;
    };
    std::ranges::sort(near, [&](const Parent& a, const Parent& b) {
      const auto u = rounded(a), v = rounded(b);
      return u != v ? u < v : a.of < b.of;
    });
    Parents parents;
    parents.count = std::min(static_cast<int>(near.size()), kMaxParents);
    std::copy_n(near.begin(), parents.count, parents.of.begin());
    return parents;
  }
  /// The squared distance from the particle to the mean of its parents, over that to the farthest parent; infinite
  /// without parents.
  static double reproduction_error(const Parents& parents) {
    Vector mean{0, 0, 0};
    double h2 = 0;
    for (const Parent& p : parents) mean = mean + p.offset * p.weight, h2 = std::max(h2, dot(p.offset, p.offset));
    return parents.count == 0 ? HUGE_VAL : h2 > 0 ? dot(mean, mean) / h2 : 0;
  }

  /// The parent with the largest weight; of several the one with the lowest index.
  int main_parent(int i) const {
    double largest = 0;
    for (const Parent& p : parents_[i]) largest = std::max(largest, p.weight);
    int best = static_cast<int>(coarse_.chosen.size());
    for (const Parent& p : parents_[i])
      if (p.weight > (1 - kTie) * largest) best = std::min(best, p.of);
    return best;
  }

  /// Calls visit(i, parent) for each finer particle i that contributes to the mass centre of a coarse one. Pinned
  /// coarse particles are made from one pinned particle only.
  template <class Visit>
  void for_each_part(const Visit& visit) const {
    for (int i = 0; i < fine_.count(); ++i)
      for (const Parent& p : parents_[i])
        if (chosen_of_[i] == p.of || !(fine_.pinned[i] || fine_.pinned[coarse_.chosen[p.of]])) visit(i, p);
  }

  /// Computes the coarse particles as mass centres, and the weights of restriction and prolongation.
  void compute_transfer() {
    const int n = fine_.count(), count = static_cast<int>(coarse_.chosen.size());
    RestGraph& graph = coarse_.graph;
    Means &prolongation = coarse_.prolongation, &restriction = coarse_.restriction;
    prolongation.reserve(n, kMaxParents);
    for (int i = 0; i < n; ++i) {
      if (!fine_.pinned[i])
        for (const Parent& p : parents_[i]) prolongation.of.push_back(p.of), prolongation.weight.push_back(p.weight);
      prolongation.begin.push_back(static_cast<int>(prolongation.of.size()));
    }
    const auto mass = [&](int i, const Parent& p) { return fine_.pinned[i] ? 1 : p.weight * fine_.mass[i]; };
    graph.mass.assign(count, 0), restriction.begin.assign(count + 1, 0);
    for_each_part([&](int i, const Parent& p) { graph.mass[p.of] += mass(i, p), ++restriction.begin[p.of + 1]; });
    std::partial_sum(restriction.begin.begin(), restriction.begin.end(), restriction.begin.begin());
    restriction.of.resize(restriction.begin.back()), restriction.weight.resize(restriction.begin.back());
    graph.mean.assign(count, {0, 0, 0}), centre_offset_.assign(count, {0, 0, 0}), graph.normal.assign(count, {0, 0, 0});
    std::vector<int> next(restriction.begin.begin(), restriction.begin.end() - 1);
    for_each_part([&](int i, const Parent& p) {
      const double weight = mass(i, p) / graph.mass[p.of];
      restriction.of[next[p.of]] = i, restriction.weight[next[p.of]++] = weight;
      const Vector& normal = fine_.normal[i];
      centre_offset_[p.of] =
          centre_offset_[p.of] - parallel_transport(p.offset, normal, fine_.normal[coarse_.chosen[p.of]]) * weight;
      graph.normal[p.of] = graph.normal[p.of] + normal * weight;
      graph.mean[p.of] = graph.mean[p.of] + fine_.mean[i] * weight;
    });
    for (int k = 0; k < count; ++k) {
      const int chosen = coarse_.chosen[k];
      graph.pinned.push_back(fine_.pinned[chosen]);
      graph.x.push_back(fine_.x[chosen] + centre_offset_[k]);
      if (!fine_.stretch.empty()) graph.stretch.push_back(fine_.stretch[chosen]);
      const double size = norm(graph.normal[k]);
      graph.folded.push_back(norm(fine_.normal[chosen]) > 0 && size < kFolded);
      if (graph.folded[k])
        graph.normal[k] = fine_.normal[chosen];
      else if (size > 0)
        graph.normal[k] = graph.normal[k] * (1 / size);
    }
  }

  /// The offset from particle i to the mass centre of its main parent k.
  Vector offset_to_centre(int k, int i) const {
    const int chosen = coarse_.chosen[k];
    Vector to{0, 0, 0};
    for (const Parent& p : parents_[i])
      if (p.of == k) to = p.offset;
    return to + parallel_transport(centre_offset_[k], fine_.normal[chosen], fine_.normal[i]);
  }

  void find_main_parents() {
    main_.resize(fine_.count());
    parallel_for(threads_, fine_.count(), [&](int i) {
      const int k = main_parent(i);
      main_[i] = {k, offset_to_centre(k, i), fine_.folded[i] || coarse_.graph.folded[k]};
    });
  }

  /// The distance along the surface between the main parents of a link's ends. At folds it is measured along the ends.
  double parent_distance(const Link& l) const {
    const Main &a = main_[l.a], &b = main_[l.b];
    if (a.folded || b.folded) return norm(a.offset) + l.length + norm(b.offset);
    return norm(offset(l.a, l.b, l.length) - a.offset +
                parallel_transport(b.offset, fine_.normal[l.b], fine_.normal[l.a]));
  }
  /// The length of a coarse link: not below the distance of the mass centres at rest, shortened like the fine link if
  /// that is shorter than the distance of its ends.
  double coarse_length(const Link& l) const {
    const double shrunk = std::min(1.0, l.length / norm(fine_.x[l.a] - fine_.x[l.b]));
    const std::vector<Vector>& mean = coarse_.graph.mean;
    return std::max(parent_distance(l), shrunk * norm(mean[main_[l.a].of] - mean[main_[l.b].of]));
  }

  /// Links the coarse particles whose regions of finer ones are adjacent. The longest of the lengths across their
  /// border is taken: a link that is too long does no harm, one that is too short would shrink the body.
  void build_links() {
    RestGraph& graph = coarse_.graph;
    std::vector<int> first(graph.count(), -1), next;  // list of links of each particle that is the lower of their ends
    const auto find = [&](int a, int b) {
      int l = first[std::min(a, b)];
      while (l >= 0 && std::max(graph.links[l].a, graph.links[l].b) != std::max(a, b)) l = next[l];
      return l;
    };
    const auto needs_link = [&](int a, int b) { return a != b && !(graph.pinned[a] && graph.pinned[b]); };
    std::vector<double> length(fine_.links.size(), 0);
    parallel_for(threads_, static_cast<int>(length.size()), [&](int k) {
      const Link& l = fine_.links[k];
      if (needs_link(main_[l.a].of, main_[l.b].of)) length[k] = coarse_length(l);
    });
    for (std::size_t k = 0; k < length.size(); ++k) {
      const Link& l = fine_.links[k];
      const int a = main_[l.a].of, b = main_[l.b].of;
      if (!needs_link(a, b)) continue;
      if (const int known = find(a, b); known >= 0) {
        graph.links[known].length = std::max(graph.links[known].length, length[k]);
      } else {
        next.push_back(first[std::min(a, b)]);
        first[std::min(a, b)] = static_cast<int>(graph.links.size());
        graph.links.push_back({a, b, length[k], l.set});
      }
    }
    for (const Edge& e : fine_.nearby)
      if (const int a = main_[e[0]].of, b = main_[e[1]].of; a != b) graph.nearby.push_back({a, b});
  }

  enum class State : std::uint8_t { Unknown, Excluded, Chosen };
  static constexpr double kReproduced = 1e-4, kOutside = 0.1;  // bounds of reproduction_error()
  static constexpr int kPasses = 3;
  const RestGraph& fine_;
  const OpenMP threads_;
  CompressedLists<Neighbour> near_;  // of each particle
  std::vector<State> state_;
  std::vector<int> chosen_of_;  // coarse particle that was made from each finer one, -1: none
  std::vector<Parents> parents_;
  struct Main {
    int of;
    Vector offset;  // m, to its mass centre
    bool folded;    // a fold at the particle or at the parent
  };
  std::vector<Main> main_;             // main parent of each particle
  std::vector<Vector> centre_offset_;  // from the chosen particle of each coarse one to its mass centre
  Coarsening coarse_;
};

}  // namespace

Coarsening coarsen(const RestGraph& fine, const OpenMP& threads) { return Coarsener(fine, threads).coarsen(); }

}  // namespace malha
