#include "host/filter/dense_columns.h"

#include <atomic>
#include <mutex>
#include <numeric>

#include "host/base/failures.h"
#include "host/filter/sparse_filter.h"

namespace malha {

namespace {

/// The body's part of the system, with its unknowns for particles.
SpringSystem part(const SpringSystem& system, const SystemBlock& body) {
  SpringSystem own;
  const int first = body.first, end = first + body.count, at = system.begin[first];
  own.blocks = {{0, body.count, body.free, body.mass}};
  own.particle.resize(body.count);
  std::iota(own.particle.begin(), own.particle.end(), 0);
  own.mass.assign(&system.mass[first], &system.mass[first] + body.count);
  own.diagonal.assign(&system.diagonal[first], &system.diagonal[first] + body.count);
  for (int i = first; i <= end; ++i) own.begin.push_back(system.begin[i] - at);
  for (int k = at; k < system.begin[end]; ++k) {
    own.column.push_back(system.column[k] - first);
    own.value.push_back(system.value[k]);
  }
  return own;
}

/// Takes the means over mass of four columns from them: what rounding left there.
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

int dense_columns(const SpringSystem& system, int body, const OpenMP& executor, const TakeColumns& take,
                  const ShowProgress& progress) {
  const SystemBlock& block = system.blocks[body];
  const SpringSystem own = part(system, block);
  const Supernodes all = supernodes(own);
  const Subtrees cut = subtrees(all);
  SparseFilter<Serial, double> solver(Serial{executor.instructions}, 1, own, all, cut);
  const int failed = factor(own, all, cut, executor, [&](int s, const double* panel) { solver.take(s, panel); }, {});
  if (failed >= 0) return all.order[failed];

  const int n = block.count, quads = (n + 3) / 4, threads = executor.threads;
  const double per_mass = block.free ? 1 / block.mass : 0;
  std::atomic<int> done{0};
  std::mutex showing;
  const auto some = [&](int thread) {
    const auto space = solver.workspace(1);
    std::vector<Vec4<double>> columns(n);
    for (int q = thread; q < quads; q += threads) {
      solver.apply(Serial{executor.instructions}, space, ColumnEnds{4 * q, own.mass.data(), per_mass, columns.data()});
      if (block.free) remove_means(own.mass, per_mass, columns);
      take(4 * q, columns.data());
      ++done;
      const std::unique_lock<std::mutex> lock(showing, std::try_to_lock);
      if (lock && progress) progress("columns of the dense filter", double(done) / quads);
    }
  };
  Failures failures;
  parallel_for(
      executor, threads, [&](int thread) { failures.keep([&] { some(thread); }); }, 0);
  failures.rethrow();
  return -1;
}

}  // namespace malha
