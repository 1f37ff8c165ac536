// SPDX-License-Identifier: Apache-2.0
#include "host/filter/factor.h"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <numeric>

#include "host/base/parallel_tasks.h"
#include "host/model/ordering/index_map.h"
#include "kernels/filter/front.h"

namespace malha {

namespace {

/// Lower bound of a pivot over its original diagonal entry; below it only rounding errors are left.
constexpr double kLeastPivot = 1e-14;

class Factorisation {
 public:
  Factorisation(const SpringSystem& system, const Supernodes& all, const OpenMP& executor, const TakePanel& take,
                const ShowProgress& progress)
      : system_(system),
        all_(all),
        executor_(executor),
        take_(take),
        progress_(progress),
        updates_(all.count()),
        first_child_(all.count(), -1),
        sibling_(all.count(), -1),
        column_of_(solver_of(all.order)) {
    for (int s = all.count() - 1; s >= 0; --s) {
      total_ += work(s);
      if (const int up = all.parent[s]; up >= 0) sibling_[s] = first_child_[up], first_child_[up] = s;
    }
  }

  int operator()(const Subtrees& cut) {
    std::vector<int> failed(cut.tasks.size());
    const auto work = [&](int t) { failed[t] = eliminate(cut.tasks[t]); };
    parallel_tasks(executor_, static_cast<int>(cut.tasks.size()), work);
    // The result is the lowest column, whichever task failed first.
    int first = -1;
    for (const int column : failed)
      if (column >= 0 && (first < 0 || column < first)) first = column;
    return first >= 0 ? first : eliminate(cut.top);
  }

 private:
  struct Scratch {
    std::vector<double> panel, copy, least;
    std::vector<int> place;  // the place of each column in the front
  };

  double work(int s) const { return double(all_.columns(s)) * all_.height(s) * all_.height(s); }

  /// Returns the first column that failed, or -1.
  int eliminate(const std::vector<int>& supernodes) {
    Scratch scratch;
    scratch.place.resize(system_.count());
    for (const int s : supernodes) {
      const int failed = eliminate(s, scratch);
      if (failed >= 0) return failed;
      done_ += static_cast<std::int64_t>(work(s));
      const std::unique_lock<std::mutex> lock(showing_, std::try_to_lock);
      if (lock && progress_) progress_("factoring", total_ > 0 ? double(done_) / total_ : 1);
    }
    return -1;
  }

  int eliminate(int s, Scratch& scratch) {
    const int first = all_.column_begin[s], pivots = all_.columns(s), below = all_.below(s), height = pivots + below;
    const int* rows = all_.rows.data() + all_.row_begin[s];
    for (int k = 0; k < pivots; ++k) scratch.place[first + k] = k;
    for (int k = 0; k < below; ++k) scratch.place[rows[k]] = pivots + k;
    scratch.panel.assign(std::size_t(height) * pivots, 0);
    scratch.copy.resize(std::size_t(pivots) * pivots);
    scratch.least.resize(pivots);
    updates_[s].assign(std::size_t(below) * below, 0);
    const ColumnMajorView<double> panel{scratch.panel.data(), height}, update{updates_[s].data(), below};
    for (int k = 0; k < pivots; ++k) {
      const int i = all_.order[first + k];
      panel(k, k) = system_.diagonal[i];
      scratch.least[k] = kLeastPivot * system_.diagonal[i];
      for (int e = system_.begin[i]; e < system_.begin[i + 1]; ++e)
        if (const int j = column_of_[system_.column[e]]; j > first + k) panel(scratch.place[j], k) = system_.value[e];
    }
    for (int c = first_child_[s]; c >= 0; c = sibling_[c]) add_child(c, pivots, panel, update, scratch.place);

    int failed = -1;
    for_each_isa([&]<class Isa>(Isa isa) {
      if (Isa::value != executor_.instructions) return;
      run(isa,
          EliminateFront<double, Isa>{
              height, pivots, panel, update, {scratch.copy.data(), pivots}, scratch.least.data(), &failed},
          0, 1);
    });
    if (failed >= 0) return first + failed;
    take_(s, scratch.panel.data());
    return -1;
  }

  /// Adds a child's Schur complement to the front (extend-add). The child's rows are ascending in the front too.
  void add_child(int c, int pivots, const ColumnMajorView<double>& panel, const ColumnMajorView<double>& update,
                 const std::vector<int>& place) {
    const int size = all_.below(c);
    const int* rows = all_.rows.data() + all_.row_begin[c];
    const ColumnMajorView<double> from{updates_[c].data(), size};
    for (int j = 0; j < size; ++j) {
      const int to = place[rows[j]];
      const int shift = to < pivots ? 0 : pivots;
      double* column = to < pivots ? &panel(0, to) : &update(0, to - pivots);
      for (int i = j; i < size; ++i) column[place[rows[i]] - shift] += from(i, j);
    }
    std::vector<double>().swap(updates_[c]);
  }

  const SpringSystem& system_;
  const Supernodes& all_;
  OpenMP executor_;
  const TakePanel& take_;
  const ShowProgress& progress_;
  std::vector<std::vector<double>> updates_;  // Schur complements, kept until their parent is assembled
  std::vector<int> first_child_, sibling_, column_of_;
  double total_ = 0;
  std::atomic<std::int64_t> done_{0};
  std::mutex showing_;
};

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

int factor(const SpringSystem& system, const Supernodes& all, const Subtrees& cut, const OpenMP& executor,
           const TakePanel& take, const ShowProgress& progress) {
  return Factorisation(system, all, executor, take, progress)(cut);
}

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
