// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "host/base/parallel_tasks.h"
#include "host/model/rest_graph.h"
#include "host/model/tangent.h"
#include "kernels/parallel/compute.h"

namespace malha {

namespace {

inline constexpr int kMostParents = 4;
inline constexpr double kSmallWeight = 0.02;  // what is less is left out

/// A coarse particle as seen from a finer one: the way to it, in the finer one's tangent plane.
struct Parent {
  int of;  // its number among the coarse ones
  Vector way;
  double weight = 1;
};

/// At most kMostParents of them, in one place.
struct Parents {
  std::array<Parent, kMostParents> of;
  int count = 0;
  Parent* begin() { return of.data(); }
  Parent* end() { return of.data() + count; }
  const Parent* begin() const { return of.data(); }
  const Parent* end() const { return of.data() + count; }
};

constexpr double kTie = 0.01;  // weights that differ by less are equal

struct Neighbour {
  int of;
  double length;  // m
};

/// Those least far from reproducing the particle's own place, and near ones rather than far ones: they minimise
/// |sum w way|^2 + e sum w^2 |way|^2 with sum w = 1 and w >= 0.
void weigh(Parents& parents) {
  constexpr double e = 0.02;
  while (parents.count > 0) {
    const int n = parents.count;
    double h2 = 0;
    for (const Parent& p : parents) h2 = std::max(h2, dot(p.way, p.way));
    std::array<std::array<double, kMostParents + 1>, kMostParents> rows{};
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) rows[i][j] = h2 > 0 ? dot(parents.of[i].way, parents.of[j].way) / h2 : 0;
      rows[i][i] += e * rows[i][i] + 1e-9;
      rows[i][n] = 1;
    }
    for (int k = 0; k < n; ++k)  // positive definite: no pivots
      for (int i = 0; i < n; ++i) {
        if (i == k) continue;
        const double f = rows[i][k] / rows[k][k];
        for (int j = k; j <= n; ++j) rows[i][j] -= f * rows[k][j];
      }
    double sum = 0;
    for (int k = 0; k < n; ++k) sum += parents.of[k].weight = rows[k][n] / rows[k][k];
    for (Parent& p : parents) p.weight /= sum;
    Parent* least = std::min_element(parents.begin(), parents.end(),
                                     [](const Parent& a, const Parent& b) { return a.weight < b.weight; });
    if (n == 1 || least->weight >= kSmallWeight) return;
    std::copy(least + 1, parents.end(), least);
    --parents.count;
  }
}

class Coarsener {
 public:
  Coarsener(const RestGraph& fine, int threads) : fine_(fine), threads_(threads) {}

  Coarser coarsen() {
    connect();
    choose();
    find_parents();
    gather();
    find_main();
    link();
    return std::move(coarse_);
  }

 private:
  void connect() {
    const int n = fine_.count();
    begin_.assign(n + 1, 0);
    for (const Link& l : fine_.links) ++begin_[l.a + 1], ++begin_[l.b + 1];
    for (const Edge& e : fine_.nearby) ++begin_[e[0] + 1], ++begin_[e[1] + 1];
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    near_.resize(begin_.back());
    std::vector<int> next(begin_.begin(), begin_.end() - 1);
    const auto add = [&](int a, int b, double length) {
      near_[next[a]++] = {b, length}, near_[next[b]++] = {a, length};
    };
    for (const Link& l : fine_.links) add(l.a, l.b, l.length);
    for (const Edge& e : fine_.nearby) add(e[0], e[1], norm(fine_.x[e[0]] - fine_.x[e[1]]));
  }

  template <class Visit>
  void for_each_neighbour(int i, const Visit& visit) const {
    for (int k = begin_[i]; k < begin_[i + 1]; ++k) visit(near_[k]);
  }

  /// An independent set, pins first; then by a front that goes out from them, so that of grids it takes every second
  /// row and column.
  void choose() {
    const int n = fine_.count();
    state_.assign(n, State::Unknown);
    std::vector<int> front;
    for (int i = 0; i < n; ++i)
      if (fine_.pinned[i] && state_[i] == State::Unknown) take(i, true), front.push_back(i);
    for (const int i : front) leave_neighbours(i, false);
    std::vector<std::uint8_t> seen(n, 0);
    for (const int i : front) seen[i] = 1;
    for (std::size_t next = 0, start = 0; next < front.size() || start < static_cast<std::size_t>(n);) {
      if (next == front.size()) {
        if (!seen[start]) seen[start] = 1, front.push_back(static_cast<int>(start));
        ++start;
        continue;
      }
      const int i = front[next++];
      if (state_[i] == State::Unknown) take(i, false);
      for_each_neighbour(i, [&](const Neighbour& j) {
        if (!seen[j.of]) seen[j.of] = 1, front.push_back(j.of);
      });
    }
  }
  void take(int i, bool pins_only) {
    state_[i] = State::Chosen;
    leave_neighbours(i, pins_only);
  }
  void leave_neighbours(int i, bool pins_only) {
    for_each_neighbour(i, [&](const Neighbour& j) {
      if (state_[j.of] == State::Unknown && (!pins_only || fine_.pinned[j.of])) state_[j.of] = State::Left;
    });
  }

  Vector way(int from, int to, double length) const {
    return along(fine_.x[to] - fine_.x[from], fine_.normal[from], length);
  }

  /// And further chosen ones where they are needed, as at a rim that the front did not end on.
  void find_parents() {
    const int n = fine_.count();
    parents_.resize(n);
    std::vector<int> all(n);
    std::iota(all.begin(), all.end(), 0);
    for (int pass = 0; !all.empty(); ++pass) {
      const auto find = [&](int k) { parents_[all[k]] = parents_of(all[k]); };
      parallel_tasks(OpenMP{threads_}, static_cast<int>(all.size()), find, kParticleGrain);
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
    for_each_neighbour(i, [&](const Neighbour& j) {
      if (may(j.of)) note(near, j.of, way(i, j.of, j.length));
    });
    Parents parents = nearest(near);
    weigh(parents);
    if (astray(parents) <= kAtHome) return parents;
    for_each_neighbour(i, [&](const Neighbour& j) {
      const Vector first = way(i, j.of, j.length);
      for_each_neighbour(j.of, [&](const Neighbour& k) {
        if (may(k.of)) note(near, k.of, first + turned(way(j.of, k.of, k.length), fine_.normal[j.of], fine_.normal[i]));
      });
    });
    parents = nearest(near);
    weigh(parents);
    return parents;
  }

  /// Of these, particles that no parents surround become coarse themselves, those next to another one first. Which
  /// ones are to be looked at again.
  std::vector<int> choose_outside(const std::vector<int>& all) {
    struct Outside {
      double nearest;  // logarithm, rounded
      int i;
    };
    std::vector<Outside> outside;
    for (const int i : all)
      if (!fine_.pinned[i] && state_[i] == State::Left && astray(parents_[i]) > kOutside) {
        double nearest2 = HUGE_VAL;
        for (const Parent& p : parents_[i]) nearest2 = std::min(nearest2, dot(p.way, p.way));
        outside.push_back({std::round(std::log(nearest2) / kTie), i});
      }
    std::stable_sort(outside.begin(), outside.end(),
                     [](const Outside& a, const Outside& b) { return a.nearest < b.nearest; });
    std::vector<bool> beside(fine_.count(), false), listed(fine_.count(), false);
    std::vector<int> again;
    const auto look_again = [&](int i) {
      if (!listed[i]) listed[i] = true, again.push_back(i);
    };
    for (const Outside& o : outside) {
      if (beside[o.i]) continue;
      state_[o.i] = State::Chosen;
      look_again(o.i);
      for_each_neighbour(o.i, [&](const Neighbour& j) {
        beside[j.of] = true;
        look_again(j.of);
        for_each_neighbour(j.of, [&](const Neighbour& k) { look_again(k.of); });
      });
    }
    return again;
  }

  static void note(std::vector<Parent>& parents, int of, const Vector& way) {
    for (Parent& p : parents)
      if (p.of == of) {
        if (dot(way, way) < dot(p.way, p.way)) p.way = way;
        return;
      }
    parents.push_back({of, way});
  }
  /// Of those as far away, rounding aside, the first by number: grids stay regular.
  static Parents nearest(std::vector<Parent>& near) {
    double h2 = 0;
    for (const Parent& p : near) h2 = std::max(h2, dot(p.way, p.way));
    const auto rounded = [h2](const Parent& p) { return std::llround(1e6 * dot(p.way, p.way) / h2); };
    std::sort(near.begin(), near.end(), [&](const Parent& a, const Parent& b) {
      const auto u = rounded(a), v = rounded(b);
      return u != v ? u < v : a.of < b.of;
    });
    Parents parents;
    parents.count = std::min(static_cast<int>(near.size()), kMostParents);
    std::copy_n(near.begin(), parents.count, parents.of.begin());
    return parents;
  }
  /// How far their mean is from the particle, over the farthest of them, squared. Without parents: very far.
  static double astray(const Parents& parents) {
    Vector mean{0, 0, 0};
    double h2 = 0;
    for (const Parent& p : parents) mean = mean + p.way * p.weight, h2 = std::max(h2, dot(p.way, p.way));
    return parents.count == 0 ? HUGE_VAL : h2 > 0 ? dot(mean, mean) / h2 : 0;
  }

  /// The one of the largest weight; of several the first by number.
  int main_parent(int i) const {
    double largest = 0;
    for (const Parent& p : parents_[i]) largest = std::max(largest, p.weight);
    int best = static_cast<int>(coarse_.chosen.size());
    for (const Parent& p : parents_[i])
      if (p.weight > (1 - kTie) * largest) best = std::min(best, p.of);
    return best;
  }

  /// Calls visit(i, parent) for all that coarse particles are the mass centres of: pins of themselves alone.
  template <class Visit>
  void for_each_part(const Visit& visit) const {
    for (int i = 0; i < fine_.count(); ++i)
      for (const Parent& p : parents_[i])
        if (chosen_of_[i] == p.of || !(fine_.pinned[i] || fine_.pinned[coarse_.chosen[p.of]])) visit(i, p);
  }

  /// The coarse particles, as mass centres, and both kinds of means.
  void gather() {
    const int n = fine_.count(), count = static_cast<int>(coarse_.chosen.size());
    RestGraph& graph = coarse_.graph;
    Means &down = coarse_.down, &up = coarse_.up;
    down.reserve(n, kMostParents);
    for (int i = 0; i < n; ++i) {
      if (!fine_.pinned[i])
        for (const Parent& p : parents_[i]) down.of.push_back(p.of), down.weight.push_back(p.weight);
      down.begin.push_back(static_cast<int>(down.of.size()));
    }
    const auto mass = [&](int i, const Parent& p) { return fine_.pinned[i] ? 1 : p.weight * fine_.mass[i]; };
    graph.mass.assign(count, 0), up.begin.assign(count + 1, 0);
    for_each_part([&](int i, const Parent& p) { graph.mass[p.of] += mass(i, p), ++up.begin[p.of + 1]; });
    std::partial_sum(up.begin.begin(), up.begin.end(), up.begin.begin());
    up.of.resize(up.begin.back()), up.weight.resize(up.begin.back());
    graph.mean.assign(count, {0, 0, 0}), aside_.assign(count, {0, 0, 0}), graph.normal.assign(count, {0, 0, 0});
    std::vector<int> next(up.begin.begin(), up.begin.end() - 1);
    for_each_part([&](int i, const Parent& p) {
      const double weight = mass(i, p) / graph.mass[p.of];
      up.of[next[p.of]] = i, up.weight[next[p.of]++] = weight;
      const Vector& normal = fine_.normal[i];
      aside_[p.of] = aside_[p.of] - turned(p.way, normal, fine_.normal[coarse_.chosen[p.of]]) * weight;
      graph.normal[p.of] = graph.normal[p.of] + normal * weight;
      graph.mean[p.of] = graph.mean[p.of] + fine_.mean[i] * weight;
    });
    for (int k = 0; k < count; ++k) {
      const int chosen = coarse_.chosen[k];
      graph.pinned.push_back(fine_.pinned[chosen]);
      graph.x.push_back(fine_.x[chosen] + aside_[k]);
      if (!fine_.give.empty()) graph.give.push_back(fine_.give[chosen]);
      const double size = norm(graph.normal[k]);
      graph.folded.push_back(norm(fine_.normal[chosen]) > 0 && size < kFolded);
      if (graph.folded[k])
        graph.normal[k] = fine_.normal[chosen];
      else if (size > 0)
        graph.normal[k] = graph.normal[k] * (1 / size);
    }
  }

  /// The way from a particle to the mass centre of its main parent k.
  Vector way_to(int k, int i) const {
    const int chosen = coarse_.chosen[k];
    Vector to{0, 0, 0};
    for (const Parent& p : parents_[i])
      if (p.of == k) to = p.way;
    return to + turned(aside_[k], fine_.normal[chosen], fine_.normal[i]);
  }

  void find_main() {
    main_.resize(fine_.count());
    parallel_for(OpenMP{threads_}, fine_.count(), [&](int i) {
      const int k = main_parent(i);
      main_[i] = {k, way_to(k, i), fine_.folded[i] || coarse_.graph.folded[k]};
    });
  }

  /// How far apart the main parents of a link's ends are. Where the surface lies on itself, by way of those ends.
  double apart(const Link& l) const {
    const Main &a = main_[l.a], &b = main_[l.b];
    if (a.folded || b.folded) return norm(a.way) + l.length + norm(b.way);
    return norm(way(l.a, l.b, l.length) - a.way + turned(b.way, fine_.normal[l.b], fine_.normal[l.a]));
  }
  /// Never shorter than the mass centres are apart at rest; of links that are shorter than that, as much less.
  double coarse_length(const Link& l) const {
    const double shrunk = std::min(1.0, l.length / norm(fine_.x[l.a] - fine_.x[l.b]));
    const std::vector<Vector>& mean = coarse_.graph.mean;
    return std::max(apart(l), shrunk * norm(mean[main_[l.a].of] - mean[main_[l.b].of]));
  }

  /// Where the regions of two parents meet. The longest of the ways over their border: too long does no harm, too short
  /// would shrink.
  void link() {
    RestGraph& graph = coarse_.graph;
    std::vector<int> first(graph.count(), -1), next;  // links of each particle, the lower one of two
    const auto find = [&](int a, int b) {
      int l = first[std::min(a, b)];
      while (l >= 0 && std::max(graph.links[l].a, graph.links[l].b) != std::max(a, b)) l = next[l];
      return l;
    };
    const auto joins = [&](int a, int b) { return a != b && !(graph.pinned[a] && graph.pinned[b]); };
    std::vector<double> length(fine_.links.size(), 0);
    parallel_for(OpenMP{threads_}, static_cast<int>(length.size()), [&](int k) {
      const Link& l = fine_.links[k];
      if (joins(main_[l.a].of, main_[l.b].of)) length[k] = coarse_length(l);
    });
    for (std::size_t k = 0; k < length.size(); ++k) {
      const Link& l = fine_.links[k];
      const int a = main_[l.a].of, b = main_[l.b].of;
      if (!joins(a, b)) continue;
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

  enum class State : std::uint8_t { Unknown, Left, Chosen };
  static constexpr double kAtHome = 1e-4, kOutside = 0.1;  // of astray()
  static constexpr int kPasses = 3;
  const RestGraph& fine_;
  const int threads_;
  std::vector<int> begin_;
  std::vector<Neighbour> near_;
  std::vector<State> state_;
  std::vector<int> chosen_of_;  // the coarse particle that each finer one is, -1: none
  std::vector<Parents> parents_;
  struct Main {
    int of;
    Vector way;   // to its mass centre
    bool folded;  // there or here
  };
  std::vector<Main> main_;     // parent of each particle
  std::vector<Vector> aside_;  // of each coarse particle: where its mass centre is, seen from the chosen one
  Coarser coarse_;
};

}  // namespace

Coarser coarsen(const RestGraph& fine, int threads) { return Coarsener(fine, threads).coarsen(); }

}  // namespace malha
