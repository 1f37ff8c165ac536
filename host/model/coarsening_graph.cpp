// SPDX-License-Identifier: Apache-2.0
#include "host/model/coarsening_graph.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "host/mesh/compressed_lists.h"
#include "host/mesh/edge_sides.h"
#include "host/mesh/topology.h"
#include "host/model/model.h"
#include "host/model/self_weight_stretch.h"
#include "host/model/tangent.h"
#include "kernels/constraints/constraint_registry.h"

namespace malha {

namespace {

constexpr double kMuchSofter = 0.25;  // mean stiffness of a set over that of the stiffest set of its component

/// The number of links from each of `count` particles to the nearest pinned one; -1 if it is not connected with one.
std::vector<int> graph_distances(int count, const std::vector<Link>& links, const std::vector<bool>& pinned) {
  const CompressedLists<int> near(count, [&](const auto& add) {
    for (const Link& l : links) add(l.a, l.b), add(l.b, l.a);
  });
  std::vector<int> graph_distance(count, -1), front;
  for (int i = 0; i < count; ++i)
    if (pinned[i]) graph_distance[i] = 0, front.push_back(i);
  for (std::size_t k = 0; k < front.size(); ++k)
    for (const int j : near[front[k]])
      if (graph_distance[j] < 0) graph_distance[j] = graph_distance[front[k]] + 1, front.push_back(j);
  return graph_distance;
}

class GraphBuilder {
 public:
  GraphBuilder(const Model& model, const std::vector<double>& w) : model_(model), w_(model.count()), x_(model.count()) {
    pinned_.resize(model.count()), mass_.resize(model.count());
    for (int i = 0; i < model.count(); ++i) {
      const int user = model.user_index[i];
      x_[user] = vector(model.x[i]), w_[user] = w[i], pinned_[user] = w[i] == 0, mass_[user] = w[i] > 0 ? 1 / w[i] : 0;
    }
  }

  CoarseningGraph build() {
    for (std::size_t s = 0; s < model_.sets.size(); ++s) {
      if (model_.sets[s].type == Distance::name) add_springs(static_cast<int>(s));
      if (model_.sets[s].type == Membrane::name) add_membrane(static_cast<int>(s));
    }
    find_parts();
    const auto elastic = [this] { return std::any_of(alpha_.begin(), alpha_.end(), [](double a) { return a > 0; }); };
    if (elastic()) drop_soft_links(), find_parts();
    graph_distance_ = graph_distances(model_.count(), graph_.links, pinned_);
    for (int i = 0; i < model_.count(); ++i) {
      GraphComponent& part = graph_.parts[graph_.part[i]];
      ++part.particles, part.max_graph_distance = std::max(part.max_graph_distance, graph_distance_[i]);
    }
    const bool has_contacts = !model_.environment.empty() || model_.scene.self_collision;
    for (GraphComponent& part : graph_.parts) part.loaded = has_contacts;
    for (const MovedPins& pins : model_.moved)
      for (const int i : pins.particles) graph_.parts[graph_.part[model_.user_index[i]]].loaded |= pins.target.moves();
    for (const Link& l : graph_.links) graph_.parts[graph_.part[l.a]].soft |= model_.sets[l.set].stiffness < 1;
    for (const auto& body : model_.tetrahedra)
      for (const Tetrahedron& t : body) graph_.parts[graph_.part[model_.user_index[t[0]]]].solid = true;
    if (elastic()) compute_stretch();
    return std::move(graph_);
  }

 private:
  void add(int a, int b, double length, int set, double alpha) {
    graph_.links.push_back({a, b, length, set});
    alpha_.push_back(alpha);
  }
  void add_springs(int s) {
    const ConstraintSet& set = model_.sets[s];
    for (int c = 0; c < set.count(); ++c) {
      const int a = model_.user_index[set.particles[2 * c]], b = model_.user_index[set.particles[2 * c + 1]];
      add(a, b, norm(x_[a] - x_[b]) * set.parameter, s, set.alpha(c));
    }
  }
  /// Adds the sides of a membrane as springs of stiffness Y A / l^2, where A is the area of the incident triangles.
  void add_membrane(int s) {
    const ConstraintSet& set = model_.sets[s];
    const double Y = 1 / set.compliance.value_or(1);
    std::vector<double> area;
    const std::size_t begin = sheets_.size();
    for (int c = 0; c < set.count(); ++c) {
      SheetTriangle& piece = sheets_.emplace_back(SheetTriangle{{}, Y});
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
    graph_.part = components(model_.count(), edges_of(graph_.links), parts);
    graph_.parts.assign(parts, {});
  }

  /// Drops links that are much softer than others of their component, such as shear beside stiff edges: a coarse
  /// constraint made from them would be as stiff as one of the edges.
  void drop_soft_links() {
    struct Mean {
      double sum = 0;
      int count = 0;
      double value() const { return count > 0 ? sum / count : 0; }
    };
    std::map<std::pair<int, int>, Mean> mean;  // mean of length / alpha of each set in each component
    std::vector<double> stiffest(graph_.parts.size(), 0);
    const auto of = [&](const Link& l) -> Mean& { return mean[{graph_.part[l.a], l.set}]; };
    for (std::size_t k = 0; k < alpha_.size(); ++k) {
      Mean& m = of(graph_.links[k]);
      m.sum += alpha_[k] > 0 ? graph_.links[k].length / alpha_[k] : HUGE_VAL, ++m.count;
    }
    for (const auto& [where, m] : mean) stiffest[where.first] = std::max(stiffest[where.first], m.value());
    std::size_t kept = 0;
    for (std::size_t k = 0; k < alpha_.size(); ++k) {
      const Link l = graph_.links[k];
      if (!(of(l).value() >= kMuchSofter * stiffest[graph_.part[l.a]])) continue;
      graph_.links[kept] = l, alpha_[kept++] = alpha_[k];
    }
    graph_.links.resize(kept), alpha_.resize(kept);
    std::erase_if(sheets_, [&](const SheetTriangle& t) {
      return stiffest[graph_.part[t.corner[0]]] == HUGE_VAL;  // beside inextensible links the sheet is soft
    });
  }

  /// Computes the compliance loss and the static stretch of elastic components.
  void compute_stretch() {
    const double h = model_.scene.solver.dt / model_.scene.solver.substeps;
    std::vector<int> links(graph_.parts.size(), 0);
    for (std::size_t k = 0; k < alpha_.size(); ++k) {
      const Link& l = graph_.links[k];
      if (!(alpha_[k] > 0)) continue;
      GraphComponent& part = graph_.parts[graph_.part[l.a]];
      part.elastic = true;
      part.compliance_loss += h * h * (w_[l.a] + w_[l.b]) / alpha_[k], ++links[graph_.part[l.a]];
    }
    std::vector<Spring> springs;
    for (std::size_t k = 0; k < alpha_.size(); ++k)
      if (const Link& l = graph_.links[k]; alpha_[k] > 0 && model_.sets[l.set].type != Membrane::name)
        springs.push_back({l.a, l.b, l.length, alpha_[k]});
    graph_.stretch = stretch_by_weight({x_, mass_, graph_distance_, graph_.part, norm(vector(model_.scene.gravity))},
                                       springs, sheets_);
    std::vector<double> mass(graph_.parts.size(), 0);
    for (int i = 0; i < model_.count(); ++i) {
      const int p = graph_.part[i];
      graph_.parts[p].stretch += mass_[i] * dot(graph_.stretch[i], graph_.stretch[i]), mass[p] += mass_[i];
    }
    for (std::size_t p = 0; p < mass.size(); ++p) {
      if (mass[p] > 0) graph_.parts[p].stretch /= mass[p];
      if (links[p] > 0) graph_.parts[p].compliance_loss /= links[p];
    }
  }

  const Model& model_;
  std::vector<double> w_, mass_, alpha_;  // w_, mass_: in the user's numbering; alpha_: of each link
  std::vector<Vector> x_;
  std::vector<bool> pinned_;
  std::vector<SheetTriangle> sheets_;
  std::vector<int> graph_distance_;
  CoarseningGraph graph_;
};

}  // namespace

CoarseningGraph coarsening_graph(const Model& model, const std::vector<double>& w) {
  return GraphBuilder(model, w).build();
}

}  // namespace malha
