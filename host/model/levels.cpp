// SPDX-License-Identifier: Apache-2.0
#include "host/model/levels.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include "host/mesh/edge_sides.h"
#include "host/mesh/topology.h"
#include "host/model/coarsening_graph.h"
#include "host/model/ordering/index_map.h"
#include "host/model/ordering/order.h"
#include "host/model/tear.h"
#include "kernels/multilevel/coarse_constraint.h"

namespace malha {

std::int64_t auto_level_threshold(const SolverSpec& solver, bool elastic) {
  const std::int64_t sweeps = std::int64_t{solver.substeps} * solver.iterations;
  return std::max<std::int64_t>(elastic ? 40 : 12, elastic ? 4 * sweeps : sweeps);
}

int levels_interval(const Model& model) {
  if (model.scene.solver.levels_interval > 0) return model.scene.solver.levels_interval;
  const auto moves = [](const auto& pins) { return pins.target.has_motion(); };
  const bool driven =
      model.scene.wind || std::ranges::any_of(model.moved, moves) || std::ranges::any_of(model.attached, moves);
  return driven ? 1 : 2;
}

namespace {

constexpr int kMinParticles = 16;      // of a level
constexpr double kMaxStretch = 0.01;   // static strain by weight; levels would correct more than that as an error
constexpr double kSmooth = 0.85;       // cosine of the turn of the normal along a link of a smooth surface
constexpr double kMaxTurning = 0.02;   // share of the links of a smooth part that turn by more
constexpr double kMaxReduction = 0.8;  // particles of a level over those of the next finer one

/// The subgraph of the chosen particles. `which` gets their indices in the whole graph.
RestGraph subgraph(RestGraph&& whole, const std::vector<bool>& chosen, std::vector<int>& which) {
  if (std::ranges::find(chosen, false) == chosen.end()) {
    which.resize(whole.count());
    std::iota(which.begin(), which.end(), 0);
    return std::move(whole);
  }
  RestGraph part;
  std::vector<int> now(whole.count(), -1);
  for (int i = 0; i < whole.count(); ++i) {
    if (!chosen[i]) continue;
    now[i] = part.count();
    which.push_back(i);
    part.x.push_back(whole.x[i]), part.mean.push_back(whole.mean[i]), part.normal.push_back(whole.normal[i]),
        part.folded.push_back(whole.folded[i]);
    part.mass.push_back(whole.mass[i]), part.pinned.push_back(whole.pinned[i]);
    if (!whole.stretch.empty()) part.stretch.push_back(whole.stretch[i]);
  }
  for (const Link& l : whole.links)
    if (chosen[l.a]) part.links.push_back({now[l.a], now[l.b], l.length, l.set});
  for (const Edge& e : whole.nearby)
    if (chosen[e[0]] && chosen[e[1]]) part.nearby.push_back({now[e[0]], now[e[1]]});
  return part;
}

/// Adds the diagonals of quads without a constraint along them as neighbours, so that coarsening a net keeps every
/// second row and column.
void add_free_diagonals(const Model& model, RestGraph& graph) {
  std::vector<Edge> diagonals;
  for (std::size_t b = 0; b + 1 < model.render_mesh.body_begin.size(); ++b) {
    const int first = model.render_mesh.body_begin[b];
    for (const Quad& face : body_mesh(model.render_mesh, b).faces)
      for (int k = 0; k < 2 && !is_triangle(face); ++k) diagonals.push_back({first + face[k], first + face[k + 2]});
  }
  if (diagonals.empty()) return;
  const int linked = static_cast<int>(graph.links.size());
  const auto visit = [&](const auto& add) {
    for (const Link& l : graph.links) add(l.a, l.b);
    for (const Edge& e : diagonals) add(e[0], e[1]);
  };
  for_each_edge(sorted_sides(graph.x.size(), visit), [&](auto first, auto /*last*/) {
    if (first->number >= linked) graph.nearby.push_back({first->low, first->high});
  });
}

/// Tells whether the component of each particle is smooth at this spacing, so that lengths along the surface can be
/// computed: along hardly any link the normal turns by much.
std::vector<bool> smooth(const RestGraph& graph, const std::vector<int>& part, int parts) {
  std::vector<int> links(parts, 0), turning(parts, 0);
  for (const Link& l : graph.links) {
    const bool turns = graph.folded[l.a] || graph.folded[l.b];
    const double cosine = dot(graph.normal[l.a], graph.normal[l.b]), sizes = dot(graph.normal[l.a], graph.normal[l.a]);
    ++links[part[l.a]], turning[part[l.a]] += turns || (sizes > 0 && cosine < kSmooth);
  }
  std::vector<bool> chosen(graph.count());
  for (int i = 0; i < graph.count(); ++i) chosen[i] = turning[part[i]] <= kMaxTurning * links[part[i]];
  return chosen;
}

/// Tells whether the component of each particle has a level: each decides by itself how many it has.
std::vector<bool> reduced(const RestGraph& fine, const Coarsening& coarser, const std::vector<int>& part, int parts) {
  std::vector<int> before(parts, 0), after(parts, 0), links(parts, 0);
  for (int i = 0; i < fine.count(); ++i) ++before[part[i]];
  for (const int i : coarser.chosen) ++after[part[i]];
  for (const Link& l : coarser.graph.links) ++links[part[coarser.chosen[l.a]]];
  std::vector<bool> chosen(fine.count());
  for (int i = 0; i < fine.count(); ++i) {
    const int k = part[i];
    chosen[i] =
        before[k] > kMinParticles && after[k] >= kMinParticles && after[k] < kMaxReduction * before[k] && links[k] > 0;
  }
  return chosen;
}

/// The static strain of a link by weight.
double strain_along(const RestGraph& graph, const Link& l) {
  if (graph.stretch.empty()) return 0;
  const Vector d = graph.x[l.b] - graph.x[l.a];
  const double a = dot(graph.stretch[l.a], d), b = dot(graph.stretch[l.b], d), size2 = dot(d, d);
  return size2 > 0 ? (a * a + b * b) / (2 * size2) : 0;
}

/// Builds the model of a level from a coarse graph. `order` gets the particle of the graph for each particle of the
/// model.
Model build_level_model(const Model& finest, const RestGraph& graph, std::vector<int>& order, const OpenMP& threads) {
  const int n = graph.count();
  int count = 0;
  const std::vector<Edge> all = edges_of(graph.links, graph.nearby);
  const std::vector<int> component = components(n, all, count);
  std::vector<Vec3> positions;
  for (const Vector& x : graph.x) positions.push_back({x.x, x.y, x.z});
  order = solver_order(positions, component, count, all);
  const std::vector<int> slot = solver_of(order);
  Model level;
  level.scene.file = finest.scene.file;
  level.scene.solver = finest.scene.solver;
  std::map<int, ConstraintSet> sets;  // by set of the finest level, so that they have the same order
  for (const Link& l : graph.links) {
    ConstraintSet& set =
        sets.try_emplace(l.set, ConstraintSet{Coarse::name, 2, finest.sets[l.set].stiffness, {}, 1, {}, {}})
            .first->second;
    set.particles.push_back(slot[l.a]), set.particles.push_back(slot[l.b]);
    set.rest.push_back(l.length * (1 + strain_along(graph, l)));
  }
  for (auto& [from, set] : sets) level.sets.push_back(std::move(set));
  std::vector<Edge> edges;
  std::vector<int> component_in_order;
  for (const Edge& e : all) edges.push_back({slot[e[0]], slot[e[1]]});
  for (const int i : order) component_in_order.push_back(component[i]);
  Cut cut = cut_into_patches(level.sets, edges, component_in_order, threads, finest.patches.bounds);
  const std::vector<int> now = solver_of(cut.order);
  order = in_solver_order(order, cut.order);
  for (ConstraintSet& set : level.sets)
    for (int& i : set.particles) i = now[i];
  level.patches = std::move(cut.patches);
  level.user_index = order;
  for (const int i : order) {
    level.x.push_back(positions[i]), level.mass.push_back(graph.mass[i]);
    level.w.push_back(graph.pinned[i] ? 0 : 1 / graph.mass[i]);
  }
  return level;
}

/// Reindexes means: mean k of the result is mean order[k], empty if that is negative, and the particle i of a term
/// becomes names[i].
Means reindexed(const Means& means, const std::vector<int>& order, const std::vector<int>& names) {
  Means result;
  result.begin.reserve(order.size() + 1), result.of.reserve(means.of.size()), result.weight.reserve(means.of.size());
  for (const int i : order) {
    for (int k = i < 0 ? 0 : means.begin[i]; k < (i < 0 ? 0 : means.begin[i + 1]); ++k)
      result.of.push_back(names[means.of[k]]), result.weight.push_back(means.weight[k]);
    result.begin.push_back(static_cast<int>(result.of.size()));
  }
  return result;
}

}  // namespace

bool should_use_levels(const GraphComponent& part, const SolverSpec& solver) {
  if (part.solid || (part.elastic && !(part.stretch > 0))) return false;
  if (solver.levels != kAutoLevels) return part.particles > kMinParticles;
  const bool by_weight = part.stretch <= kMaxStretch && part.compliance_loss >= 1 && !part.loaded;
  return part.max_graph_distance >= auto_level_threshold(solver, part.elastic) && !part.soft &&
         (!part.elastic || by_weight);
}

std::vector<Level> make_levels(const Model& model, const std::vector<double>& w, const OpenMP& threads) {
  std::vector<Level> levels;
  if (model.scene.solver.levels == 0) return levels;
  CoarseningGraph full = coarsening_graph(model, w);
  std::vector<bool> chosen(model.count());
  for (int i = 0; i < model.count(); ++i) chosen[i] = should_use_levels(full.parts[full.part[i]], model.scene.solver);
  if (std::ranges::find(chosen, true) == chosen.end()) return levels;
  RestGraph whole = rest_graph(model, w);
  whole.links = std::move(full.links), whole.stretch = std::move(full.stretch);
  add_free_diagonals(model, whole);
  std::vector<int> user, part;
  RestGraph fine = subgraph(std::move(whole), chosen, user);
  for (const int i : user) part.push_back(full.part[i]);
  // `in_graph` maps the particles of the finer model to those of the finer graph, -1 for none; `slot` is the inverse.
  std::vector<int> inside(model.count(), -1), in_graph(model.count()), slot;
  for (std::size_t i = 0; i < user.size(); ++i) inside[user[i]] = static_cast<int>(i);
  for (int i = 0; i < model.count(); ++i) in_graph[i] = inside[model.user_index[i]];
  const int most = model.scene.solver.levels == kAutoLevels ? kMaxLevels : model.scene.solver.levels;
  const auto keep = [&](const std::vector<bool>& which) {
    std::vector<int> kept, now(fine.count(), -1);
    fine = subgraph(std::move(fine), which, kept);
    for (int i = 0; i < fine.count(); ++i) now[kept[i]] = i, part[i] = part[kept[i]];
    for (int& i : in_graph) i = i < 0 ? -1 : now[i];
  };
  const int parts = static_cast<int>(full.parts.size());
  while (static_cast<int>(levels.size()) < most) {
    keep(smooth(fine, part, parts));
    Coarsening coarser = coarsen(fine, threads);
    // Components without a level are left out; what the others get does not change.
    if (const std::vector<bool> smaller = reduced(fine, coarser, part, parts); std::ranges::count(smaller, false) > 0) {
      keep(smaller);
      coarser = coarsen(fine, threads);
    }
    if (fine.count() == 0) break;
    const int n = coarser.graph.count();
    slot.resize(fine.count());
    for (std::size_t i = 0; i < in_graph.size(); ++i)
      if (in_graph[i] >= 0) slot[in_graph[i]] = static_cast<int>(i);
    Level level;
    std::vector<int> order;
    level.model = build_level_model(model, coarser.graph, order, threads);
    std::vector<int> by_rank(n);
    std::iota(by_rank.begin(), by_rank.end(), 0);
    std::ranges::sort(by_rank, [&](int a, int b) { return slot[coarser.chosen[a]] < slot[coarser.chosen[b]]; });
    const std::vector<int> rank = solver_of(by_rank), at = solver_of(order);
    level.restriction = reindexed(coarser.restriction, by_rank, slot);
    level.prolongation = reindexed(coarser.prolongation, in_graph, rank);
    for (const int i : by_rank) level.particle.push_back(at[i]);
    for (int i = 0; i < n; ++i) part[i] = part[coarser.chosen[i]];
    fine = std::move(coarser.graph);
    in_graph = order;
    levels.push_back(std::move(level));
  }
  return levels;
}

}  // namespace malha
