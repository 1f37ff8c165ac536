// SPDX-License-Identifier: Apache-2.0
#include "host/filter/system.h"

#include <algorithm>
#include <string>

#include "host/base/median.h"
#include "host/mesh/compressed_lists.h"
#include "host/mesh/topology.h"
#include "host/model/stencils.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {

namespace {

/// Numbers the unknowns block by block, and finds those with a spring to a pin.
class Unknowns {
 public:
  Unknowns(const std::vector<double>& w, const std::vector<const SpringSet*>& springs) : of_(w.size(), -1) {
    const int n = static_cast<int>(w.size());
    std::vector<Edge> inner;
    std::vector<bool> held(n, false), sprung(n, false);
    for (const SpringSet* set : springs)
      for (const Edge& e : set->ends) {
        const bool a = w[e[0]] > 0, b = w[e[1]] > 0;
        if (a && b) inner.push_back(e);
        if (a) sprung[e[0]] = true, held[e[0]] = held[e[0]] || !b;
        if (b) sprung[e[1]] = true, held[e[1]] = held[e[1]] || !a;
      }
    int islands = 0;
    const std::vector<int> island = components(n, inner, islands);
    std::vector<int> block(islands, -1);
    for (int i = 0; i < n; ++i) {
      if (!sprung[i]) continue;
      int& b = block[island[i]];
      if (b < 0) b = static_cast<int>(blocks.size()), blocks.push_back({0, 0, true, 0});
      ++blocks[b].count, blocks[b].mass += 1 / w[i];
      if (held[i]) blocks[b].free = false;
    }
    int total = 0;
    for (SystemBlock& b : blocks) b.first = total, total += b.count;
    particle.resize(total);
    std::vector<int> next(blocks.size());
    for (std::size_t b = 0; b < blocks.size(); ++b) next[b] = blocks[b].first;
    for (int i = 0; i < n; ++i)
      if (sprung[i]) of_[i] = next[block[island[i]]]++, particle[of_[i]] = i;
  }
  int operator[](int i) const { return of_[i]; }

  std::vector<int> particle;
  std::vector<SystemBlock> blocks;

 private:
  std::vector<int> of_;  // unknown of each particle; -1 if it is pinned or has no springs
};

}  // namespace

SpringSet linear_part(const Model& model) {
  struct Pair {
    Edge ends;
    double stiffness;
  };
  std::vector<Pair> all;
  for_each_stencil(model, [&](const auto& stencil) {
    for (const auto& c : stencil.weights)
      for (int i = 0; i < stencil.n; ++i)
        for (int j = 0; j < i; ++j) {
          const int a = stencil.particles[i], b = stencil.particles[j];
          if (a != b && c[i] * c[j] != 0)
            all.push_back({{std::min(a, b), std::max(a, b)}, -c[i] * c[j] / stencil.alpha});
        }
  });
  std::ranges::stable_sort(all, [](const Pair& a, const Pair& b) { return a.ends < b.ends; });
  SpringSet sum{"", {}, {}, {}};
  for (const Pair& pair : all)
    if (!sum.ends.empty() && sum.ends.back() == pair.ends)
      sum.stiffness.back() += pair.stiffness;
    else
      sum.ends.push_back(pair.ends), sum.stiffness.push_back(pair.stiffness);
  sum.rest.assign(sum.ends.size(), 0);
  return sum;
}

SpringSystem spring_system(const Model& model, double dt, const std::vector<double>& w) {
  const SpringSet linear = linear_part(model);
  std::vector<const SpringSet*> springs{&linear};
  for (const SpringSet& set : model.springs) springs.push_back(&set);
  Unknowns unknown(w, springs);
  SpringSystem system;
  system.particle = std::move(unknown.particle);
  system.blocks = std::move(unknown.blocks);
  const int n = system.count();
  for (const int i : system.particle) system.mass.push_back(1 / w[i]);
  system.diagonal = system.mass;
  const auto each_spring = [&](const auto& visit) {
    for (const SpringSet* set : springs)
      for (std::size_t s = 0; s < set->ends.size(); ++s)
        visit(unknown[set->ends[s][0]], unknown[set->ends[s][1]], dt * dt * set->stiffness[s]);
  };
  each_spring([&](int a, int b, double k) {
    if (a >= 0) system.diagonal[a] += k;
    if (b >= 0) system.diagonal[b] += k;
  });
  struct Entry {
    int column;
    double value;
  };
  CompressedLists<Entry> rows(n, [&](const auto& add) {
    each_spring([&](int a, int b, double k) {
      if (a >= 0 && b >= 0) add(a, {b, -k}), add(b, {a, -k});
    });
  });
  system.begin = {0};
  for (int i = 0; i < n; ++i) {
    std::ranges::stable_sort(rows[i], {}, &Entry::column);
    for (const Entry& entry : rows[i]) {
      const bool again =
          static_cast<int>(system.column.size()) > system.begin[i] && system.column.back() == entry.column;
      if (again)
        system.value.back() += entry.value;
      else
        system.column.push_back(entry.column), system.value.push_back(entry.value);
    }
    system.begin.push_back(static_cast<int>(system.column.size()));
  }
  return system;
}

std::vector<double> multiply(const SpringSystem& system, const std::vector<double>& x) {
  std::vector<double> y(x.size());
  for (int i = 0; i < system.count(); ++i)
    for (int r = 0; r < 3; ++r) {
      double sum = system.diagonal[i] * x[3 * i + r];
      for (int k = system.begin[i]; k < system.begin[i + 1]; ++k) sum += system.value[k] * x[3 * system.column[k] + r];
      y[3 * i + r] = sum;
    }
  return y;
}

namespace {

/// The stiffest constraint: its largest stiffness at a corner (N/m), and the ratio to the median.
struct Stiffest {
  double stiffness = 0, times = 0;
  std::string type;
  std::vector<int> particles;
};

Stiffest stiffest_of(const Model& model) {
  Stiffest found;
  std::vector<double> all;
  const auto take = [&](double stiffness, const std::string& type, const int* particles, int n) {
    all.push_back(stiffness);
    if (stiffness > found.stiffness) found = {stiffness, 0, type, {particles, particles + n}};
  };
  for (const SpringSet& set : model.springs)
    for (std::size_t s = 0; s < set.ends.size(); ++s) take(set.stiffness[s], set.type, set.ends[s].data(), 2);
  for (const ConstraintSet& set : model.stencils)
    with_stencil(set, [&]<class Kind, class Stencil>(Kind, Stencil) {
      for (int c = 0; c < set.count(); ++c) {
        const StencilOf<Kind> one = stencil_of<Kind>(model, set, c);
        take(one.stiffest(), set.type, one.particles, Kind::particles);
      }
    });
  found.times = all.empty() ? 0 : found.stiffness / median(std::move(all));
  return found;
}

/// Ratio to the median from which a stiffness is named: double has 16 digits, and 10 are left to the other constraints.
constexpr double kStandsOut = 1e6;

}  // namespace

void refuse_singular(const Model& model, int particle) {
  const Stiffest one = stiffest_of(model);
  std::string found = "a system that is singular to working precision at " +
                      particle_name(model, model.user_index[particle]),
              allowed = "a stiffness times dt^2 that is less than 1e14 times the particles' masses";
  if (one.times > kStandsOut) {
    const std::string body = model.scene.bodies[body_of(model, model.user_index[one.particles[0]])].name;
    std::string vertices;
    for (const int i : one.particles)
      vertices += (vertices.empty() ? "" : "-") + std::to_string(number_in_body(model, model.user_index[i]));
    found += ", where '" + one.type + "' at vertices " + vertices + " of body '" + body + "' is " +
             shown(one.times, 2) + " times as stiff as most constraints";
    allowed += ", and triangles there that are less flat, or a \"stiffness\" or \"rigidity\" in place of a compliance";
  }
  refuse(model.scene.file, "/solver/dt", found, allowed);
}

}  // namespace malha
