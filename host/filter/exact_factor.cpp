// SPDX-License-Identifier: Apache-2.0
#include "host/filter/exact_factor.h"

#include <atomic>
#include <mutex>
#include <numeric>

#include "host/base/parallel_tasks.h"

namespace malha {

namespace {

SpringSystem with_unknowns_for_particles(SpringSystem system) {
  std::iota(system.particle.begin(), system.particle.end(), 0);
  return system;
}

/// Removes the mass-weighted means of four columns, which are rounding errors.
void remove_means(const std::vector<double>& mass, double per_mass, std::vector<Vec4<double>>& columns) {
  Vec4<double> mean{0, 0, 0, 0};
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const double share = mass[i] * per_mass;
    const Vec4<double>& a = columns[i];
    mean = {mean.x + share * a.x, mean.y + share * a.y, mean.z + share * a.z, mean.w + share * a.w};
  }
  for (Vec4<double>& a : columns) a = {a.x - mean.x, a.y - mean.y, a.z - mean.z, a.w - mean.w};
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

void dense_columns(const ExactFactor& exact, const OpenMP& executor, const TakeColumns& take,
                   const ShowProgress& progress) {
  const SystemBlock& block = exact.system.blocks[0];
  const std::vector<double>& mass = exact.system.mass;
  const int n = block.count, quads = (n + 3) / 4, threads = executor.threads;
  const double per_mass = block.free ? 1 / block.mass : 0;
  std::atomic<int> done{0};
  std::mutex showing;
  const auto some = [&](int thread) {
    const auto space = exact.filter.workspace(1);
    std::vector<Vec4<double>> columns(n);
    for (int q = thread; q < quads; q += threads) {
      exact.filter.apply(Serial{executor.instructions}, space, ColumnIo{4 * q, mass.data(), per_mass, columns.data()});
      if (block.free) remove_means(mass, per_mass, columns);
      take(4 * q, columns.data());
      ++done;
      const std::unique_lock<std::mutex> lock(showing, std::try_to_lock);
      if (lock && progress) progress("columns of the dense filter", double(done) / quads);
    }
  };
  parallel_tasks(executor, threads, some);
}

}  // namespace malha
