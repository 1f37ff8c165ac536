// SPDX-License-Identifier: Apache-2.0
#include "host/filter/exact_factor.h"

#include <numeric>

namespace malha {

namespace {

SpringSystem with_unknowns_for_particles(SpringSystem system) {
  std::iota(system.particle.begin(), system.particle.end(), 0);
  return system;
}

}  // namespace

ExactFactor::ExactFactor(const SpringSystem& whole, const OpenMP& executor)
    : system(with_unknowns_for_particles(whole)),
      all(supernodes(system)),
      cut(subtrees(all)),
      filter(Serial{executor.instructions}, 1, system, all, cut) {
  const int failed =
      factor(system, all, cut, executor, [this](int s, const double* panel) { filter.take(s, panel); }, {});
  singular = failed < 0 ? -1 : all.order[failed];
}

SpringSystem body_system(const SpringSystem& system, int body) {
  const SystemBlock& block = system.blocks[body];
  SpringSystem own;
  const int first = block.first, end = first + block.count, at = system.begin[first];
  own.blocks = {{0, block.count, block.free, block.mass}};
  own.particle.assign(&system.particle[first], &system.particle[first] + block.count);
  own.mass.assign(&system.mass[first], &system.mass[first] + block.count);
  own.diagonal.assign(&system.diagonal[first], &system.diagonal[first] + block.count);
  for (int i = first; i <= end; ++i) own.begin.push_back(system.begin[i] - at);
  for (int k = at; k < system.begin[end]; ++k) {
    own.column.push_back(system.column[k] - first);
    own.value.push_back(system.value[k]);
  }
  return own;
}

}  // namespace malha
