// SPDX-License-Identifier: Apache-2.0
#include "host/model/coarsening_graph.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "host/mesh/edge_sides.h"
#include "host/mesh/topology.h"
#include "host/model/model.h"
#include "host/model/self_weight_stretch.h"
#include "host/model/tangent.h"
#include "kernels/constraints/constraint_registry.h"

namespace malha {

namespace {

constexpr double kMuchSofter = 0.25;  // of the mean stiffness of a part's stiffest set

/// How many links each of `count` particles is from the nearest one that is held; -1: nothing holds it.
std::vector<int> hops_to_pins(int count, const std::vector<Link>& links, const std::vector<bool>& held) {
  std::vector<int> begin(count + 1, 0), near(2 * links.size());
  for (const Link& l : links) ++begin[l.a + 1], ++begin[l.b + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<int> next(begin.begin(), begin.end() - 1);
  for (const Link& l : links) near[next[l.a]++] = l.b, near[next[l.b]++] = l.a;
  std::vector<int> graph_distance(count, -1), front;
  for (int i = 0; i < count; ++i)
    if (held[i]) graph_distance[i] = 0, front.push_back(i);
  for (std::size_t k = 0; k < front.size(); ++k)
    for (int e = begin[front[k]]; e < begin[front[k] + 1]; ++e)
      if (graph_distance[near[e]] < 0) graph_distance[near[e]] = graph_distance[front[k]] + 1, front.push_back(near[e]);
  return graph_distance;
}

class Linker {
 public:
  Linker(const Model& model, const std::vector<double>& w) : model_(model), w_(model.count()), x_(model.count()) {
    pinned_.resize(model.count()), mass_.resize(model.count());
    for (int i = 0; i < model.count(); ++i) {
      const int user = model.user_index[i];
      x_[user] = vector(model.x[i]), w_[user] = w[i], pinned_[user] = w[i] == 0, mass_[user] = w[i] > 0 ? 1 / w[i] : 0;
    }
  }

  Linkage link() {
    for (std::size_t s = 0; s < model_.sets.size(); ++s) {
      if (model_.sets[s].type == Distance::name) add_springs(static_cast<int>(s));
      if (model_.sets[s].type == Membrane::name) add_membrane(static_cast<int>(s));
    }
    find_parts();
    const auto elastic = [this] { return std::any_of(alpha_.begin(), alpha_.end(), [](double a) { return a > 0; }); };
    if (elastic()) leave_out_the_soft(), find_parts();
    hops_ = hops_to_pins(model_.count(), linkage_.links, pinned_);
    for (int i = 0; i < model_.count(); ++i) {
      LinkedPart& part = linkage_.parts[linkage_.part[i]];
      ++part.particles, part.longest = std::max(part.longest, hops_[i]);
    }
    const bool touched = !model_.environment.empty() || model_.scene.self_collision;
    for (LinkedPart& part : linkage_.parts) part.loaded = touched;
    for (const MovedPins& pins : model_.moved)
      for (const int i : pins.particles)
        linkage_.parts[linkage_.part[model_.user_index[i]]].loaded |= pins.target.moves();
    for (const Link& l : linkage_.links) linkage_.parts[linkage_.part[l.a]].soft |= model_.sets[l.set].stiffness < 1;
    for (const auto& body : model_.tetrahedra)
      for (const Tetrahedron& t : body) linkage_.parts[linkage_.part[model_.user_index[t[0]]]].solid = true;
    if (elastic()) hang();
    return std::move(linkage_);
  }

 private:
  void add(int a, int b, double length, int set, double alpha) {
    linkage_.links.push_back({a, b, length, set});
    alpha_.push_back(alpha);
  }
  void add_springs(int s) {
    const ConstraintSet& set = model_.sets[s];
    for (int c = 0; c < set.count(); ++c) {
      const int a = model_.user_index[set.particles[2 * c]], b = model_.user_index[set.particles[2 * c + 1]];
      add(a, b, norm(x_[a] - x_[b]) * set.parameter, s, set.alpha(c));
    }
  }
  /// Its sides pull as springs of stiffness Y A / l^2, where A is the area of the triangles at them.
  void add_membrane(int s) {
    const ConstraintSet& set = model_.sets[s];
    const double Y = 1 / set.compliance.value_or(1);
    std::vector<double> area;
    const std::size_t begin = sheets_.size();
    for (int c = 0; c < set.count(); ++c) {
      SheetPiece& piece = sheets_.emplace_back(SheetPiece{{}, Y});
      for (int k = 0; k < 3; ++k) piece.corner[k] = model_.user_index[set.particles[3 * c + k]];
      const auto& [i, j, k] = piece.corner;
      area.push_back(norm(cross(x_[j] - x_[i], x_[k] - x_[i])) / 2);
    }
    const auto visit = [&](const auto& add_side) {
      for (std::size_t t = begin; t < sheets_.size(); ++t)
        for (int k = 0; k < 3; ++k) add_side(sheets_[t].corner[k], sheets_[t].corner[(k + 1) % 3]);
    };
    for_each_edge(sorted_sides(x_.size(), visit), [&](auto first, auto last) {
      double sum = 0;
      for (auto side = first; side != last; ++side) sum += area[side->number / 3];
      const double length = norm(x_[first->low] - x_[first->high]);
      if (sum > 0) add(first->low, first->high, length, s, length * length / (Y * sum));
    });
  }

  void find_parts() {
    int parts = 0;
    linkage_.part = components(model_.count(), edges_of(linkage_.links), parts);
    linkage_.parts.assign(parts, {});
  }

  /// As soft shear beside stiff edges: a limit of it would be one of the edges' kind.
  void leave_out_the_soft() {
    struct Mean {
      double sum = 0;
      int count = 0;
      double value() const { return count > 0 ? sum / count : 0; }
    };
    std::map<std::pair<int, int>, Mean> mean;  // of a set in a part: length / alpha
    std::vector<double> stiffest(linkage_.parts.size(), 0);
    const auto of = [&](const Link& l) -> Mean& { return mean[{linkage_.part[l.a], l.set}]; };
    for (std::size_t k = 0; k < alpha_.size(); ++k) {
      Mean& m = of(linkage_.links[k]);
      m.sum += alpha_[k] > 0 ? linkage_.links[k].length / alpha_[k] : HUGE_VAL, ++m.count;
    }
    for (const auto& [where, m] : mean) stiffest[where.first] = std::max(stiffest[where.first], m.value());
    std::size_t kept = 0;
    for (std::size_t k = 0; k < alpha_.size(); ++k) {
      const Link l = linkage_.links[k];
      if (!(of(l).value() >= kMuchSofter * stiffest[linkage_.part[l.a]])) continue;
      linkage_.links[kept] = l, alpha_[kept++] = alpha_[k];
    }
    linkage_.links.resize(kept), alpha_.resize(kept);
    std::erase_if(sheets_, [&](const SheetPiece& t) {
      return stiffest[linkage_.part[t.corner[0]]] == HUGE_VAL;  // not that of links beside which it is soft, either
    });
  }

  /// How elastic parts are, and how far weight stretches them.
  void hang() {
    const double h = model_.scene.solver.dt / model_.scene.solver.substeps;
    std::vector<int> links(linkage_.parts.size(), 0);
    for (std::size_t k = 0; k < alpha_.size(); ++k) {
      const Link& l = linkage_.links[k];
      if (!(alpha_[k] > 0)) continue;
      LinkedPart& part = linkage_.parts[linkage_.part[l.a]];
      part.elastic = true;
      part.lost += h * h * (w_[l.a] + w_[l.b]) / alpha_[k], ++links[linkage_.part[l.a]];
    }
    std::vector<Spring> springs;
    for (std::size_t k = 0; k < alpha_.size(); ++k)
      if (const Link& l = linkage_.links[k]; alpha_[k] > 0 && model_.sets[l.set].type != Membrane::name)
        springs.push_back({l.a, l.b, l.length, alpha_[k]});
    linkage_.give =
        stretch_by_weight({x_, mass_, hops_, linkage_.part, norm(vector(model_.scene.gravity))}, springs, sheets_);
    std::vector<double> mass(linkage_.parts.size(), 0);
    for (int i = 0; i < model_.count(); ++i) {
      const int p = linkage_.part[i];
      linkage_.parts[p].stretch += mass_[i] * dot(linkage_.give[i], linkage_.give[i]), mass[p] += mass_[i];
    }
    for (std::size_t p = 0; p < mass.size(); ++p) {
      if (mass[p] > 0) linkage_.parts[p].stretch /= mass[p];
      if (links[p] > 0) linkage_.parts[p].lost /= links[p];
    }
  }

  const Model& model_;
  std::vector<double> w_, mass_, alpha_;  // in the user's numbers; alpha_: of each link
  std::vector<Vector> x_;
  std::vector<bool> pinned_;
  std::vector<SheetPiece> sheets_;
  std::vector<int> hops_;
  Linkage linkage_;
};

}  // namespace

Linkage linkage_of(const Model& model, const std::vector<double>& w) { return Linker(model, w).link(); }

}  // namespace malha
