#include "host/filter/dense_columns.h"

#include <atomic>
#include <mutex>
#include <numeric>

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
  const double mean = block.free ? 1 / block.mass : 0;
  std::atomic<int> done{0};
  std::mutex showing;
  const auto share = [&](int thread) {
    const auto space = solver.workspace(1);
    std::vector<Vec4<double>> columns(n);
    for (int q = thread; q < quads; q += threads) {
      solver.apply(Serial{executor.instructions}, space, ColumnEnds{4 * q, columns.data()});
      if (mean > 0)
        for (Vec4<double>& a : columns) a = {a.x - mean, a.y - mean, a.z - mean, a.w - mean};
      take(4 * q, columns.data());
      ++done;
      const std::unique_lock<std::mutex> lock(showing, std::try_to_lock);
      if (lock && progress) progress("columns of the dense filter", double(done) / quads);
    }
  };
  parallel_for(executor, threads, share, 0);
  return -1;
}

}  // namespace malha
