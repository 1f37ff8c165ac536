// SPDX-License-Identifier: Apache-2.0
// Constraints without a mesh, for tests of colouring and partitioning: random hypergraphs with hubs, models of them,
// and a checker of independence that shares no code with the host.
#pragma once
#include <algorithm>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "host/model/model.h"
#include "kernels/constraints/constraint_registry.h"
#include "tests/constraints/some_material.h"
#include "tests/numbers.h"

namespace malha {

/// Tests whether no two of these constraints share a movable particle, by a set instead of bit words.
inline bool independent(const std::vector<int>& constraints, const std::vector<int>& particles, int arity,
                        const std::vector<bool>& pinned) {
  std::set<int> taken;
  for (const int c : constraints) {
    std::set<int> own;
    for (int j = 0; j < arity; ++j)
      if (const int i = particles[c * arity + j]; !pinned[i]) own.insert(i);
    for (const int i : own)
      if (!taken.insert(i).second) return false;
  }
  return true;
}

/// Edges 0-1, 0-2, ... from one hub.
inline std::vector<int> star(int edges) {
  std::vector<int> flat;
  for (int leaf = 1; leaf <= edges; ++leaf) flat.insert(flat.end(), {0, leaf});
  return flat;
}

template <class List>
std::vector<int> flatten(const List& list) {
  std::vector<int> flat;
  for (const auto& element : list) flat.insert(flat.end(), element.begin(), element.end());
  return flat;
}

/// A random hypergraph with hubs: `arity` distinct particles a constraint, some of which occur in many. `reach`: the
/// largest difference of numbers within a constraint.
inline std::vector<int> tangle(int constraints, int arity, int particles, Random& random, int reach = 0) {
  if (reach == 0) reach = particles;
  std::vector<int> flat;
  for (int c = 0; c < constraints; ++c) {
    const int from = random.below(particles - reach + 1);
    for (int j = 0; j < arity;) {
      const int i = from + random.below(random.below(3) == 0 ? std::min(5 * arity, reach) : reach);
      if (std::find(flat.end() - j, flat.end(), i) != flat.end()) continue;
      flat.push_back(i), ++j;
    }
  }
  return flat;
}

inline std::vector<bool> some_pinned(int particles, Random& random) {
  std::vector<bool> pinned(particles);
  for (int i = 0; i < particles; ++i) pinned[i] = random.below(6) == 0;
  return pinned;
}

inline std::vector<bool> pinned_of(const Model& model) {
  std::vector<bool> pinned;
  for (const double w : model.w) pinned.push_back(w == 0);
  return pinned;
}

/// A set of a kind of the registry with this many particles a constraint.
inline ConstraintSet set_of(int arity, std::vector<int> particles) {
  ConstraintSet set;
  for_each_constraint([&]<class Kind>(Kind) {
    if (Kind::particles == arity)
      set.type = Kind::name, set.parameter = Kind::parameter.default_value, set.orthotropic = some_orthotropic<Kind>();
  });
  set.arity = arity;
  set.particles = std::move(particles);
  return set;
}

/// A model of these sets with random positions and masses, cut into patches. `begin`: the first particle of each patch,
/// instead.
inline Model model_of(std::vector<ConstraintSet> sets, const std::vector<bool>& pinned, Random& random,
                      std::vector<int> begin = {}) {
  const int particles = static_cast<int>(pinned.size());
  Model model;
  Cut cut = cut_into_patches(sets, {}, std::vector<int>(particles, 0));
  std::vector<int> now(particles);
  for (int i = 0; i < particles; ++i) now[cut.order[i]] = i;
  for (ConstraintSet& set : sets)
    for (int& i : set.particles) i = now[i];
  model.sets = std::move(sets);
  model.patches = std::move(cut.patches);
  if (!begin.empty()) model.patches.begin = std::move(begin);
  for (int i = 0; i < particles; ++i) {
    const double x = random(), y = random(), z = random();
    model.x.push_back({x, y, z});
    model.v.push_back({0, 0, 0});
    model.mass.push_back(random(0.2, 5));
    model.w.push_back(pinned[cut.order[i]] ? 0 : 1 / model.mass.back());
    model.user_index.push_back(i);
  }
  return model;
}

/// 0, `cuts` random particles in ascending order, and `particles`.
inline std::vector<int> random_cuts(int cuts, int particles, Random& random) {
  std::set<int> begin{0, particles};
  while (static_cast<int>(begin.size()) < cuts + 2) begin.insert(random.below(particles));
  return {begin.begin(), begin.end()};
}

}  // namespace malha
