// SPDX-License-Identifier: Apache-2.0
// Construction of a filter, for any executor; filter.cpp instantiates it for those of the host.
#pragma once
#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "host/base/memory_size.h"
#include "host/base/stopwatch.h"
#include "host/filter/dense_filter.h"
#include "host/filter/factor.h"
#include "host/filter/filter.h"
#include "host/filter/filter_errors.h"
#include "host/filter/sparse_filter.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {

namespace detail {

/// Predicted time of a product on one thread, ns, from measurements in the caches of a Zen 4 core with AVX-512.
inline double dense_ns(std::int64_t numbers, int particles, Storage storage) {
  return (0.13 * double(numbers) + 5.0 * particles) * (storage == Storage::Double ? 2 : 1);
}
inline double sparse_ns(std::int64_t numbers, int supernodes, Storage storage) {
  return 0.35 * double(numbers) * (storage == Storage::Double ? 2 : 1) + 60.0 * supernodes;
}

inline std::string microseconds(double ns) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3g us", ns / 1000);
  return text;
}

/// Largest number of entries of update matrices that wait for their parents while one thread factors.
inline double most_waiting(const Supernodes& all) {
  const auto update = [&](int s) { return double(all.below(s)) * all.below(s); };
  std::vector<double> children(all.count(), 0);
  double waiting = 0, most = 0;
  for (int s = 0; s < all.count(); ++s) {
    waiting += update(s);
    most = std::max(most, waiting + double(all.columns(s)) * all.height(s));
    waiting -= children[s];
    if (all.parent[s] >= 0) children[all.parent[s]] += update(s);
  }
  return most;
}

template <class R, class Engine>
class FilterOf final : public Filter<R> {
 public:
  template <class... Arguments>
  explicit FilterOf(Arguments&&... arguments) : engine(std::forward<Arguments>(arguments)...) {}
  void apply(const FilterIo<R>& io) const override { engine.apply(io); }
  Engine engine;
  FilterStats& facts() { return this->facts_; }
};

template <class Executor, class R>
class Maker {
 public:
  Maker(const Executor& executor, int threads, const Model& model, const SpringSystem& system,
        const ShowProgress& progress)
      : executor_(executor),
        host_{threads, on_host(executor).instructions},
        model_(model),
        system_(system),
        progress_(progress),
        spec_(model.scene.solver.desbrun) {
    storage_ = spec_.storage.value_or(std::is_same_v<R, double> ? Storage::Double : Storage::Float);
  }

  std::unique_ptr<Filter<R>> operator()() {
    if (spec_.filter == FilterKind::Dense || storage_ == Storage::Int16) {
      why_ = spec_.filter == FilterKind::Dense ? "the scene asks for it" : "the only one that is stored so";
      return dense();
    }
    facts_.order_seconds = seconds([&] { all_ = supernodes(system_); });
    if (spec_.filter == FilterKind::Sparse) {
      why_ = "the scene asks for it";
      return sparse();
    }
    const double a = dense_ns(dense_values(system_), system_.count(), storage_);
    const double b = sparse_ns(all_.entries(), all_.count(), storage_);
    why_ = "predicted for a product on one thread: dense " + microseconds(a) + ", sparse " + microseconds(b);
    return a < b ? dense() : sparse();
  }

 private:
  std::unique_ptr<Filter<R>> dense() {
    switch (storage_) {
      case Storage::Double:
        return dense<double, double>();
      case Storage::Float:
        return dense<float, float>();
      case Storage::Int16:
        return dense<short, float>();
    }
    return nullptr;
  }

  /// Throws InputError if the filter needs more memory than there is.
  void require(double bytes, const std::string& place, const std::string& found, const std::string& instead) const {
    const double free = double(available_memory());
    if (bytes > 0.9 * free)
      refuse<OutOfMemory>(model_.scene.file, place, found,
                          "what fits into the " + in_gib(free) + " that are free here" + instead);
  }

  template <class V, class T>
  std::unique_ptr<Filter<R>> dense() {
    const double bytes = double(dense_values(system_)) * sizeof(V);
    require(bytes, "/solver/filter",
            "a dense filter of " + in_gib(bytes) + " for " + counted(system_.count(), "particle") + " in " +
                counted(system_.blocks.size(), "body", "bodies"),
            std::string("; \"sparse\" ") + (storage_ == Storage::Int16 ? "with the storage \"float\"" : "or \"auto\"") +
                " needs far less");
    auto made = std::make_unique<FilterOf<R, DenseFilter<Executor, V, T>>>(executor_, host_.threads, system_);
    auto& engine = made->engine;
    facts_.column_seconds = seconds([&] {
      for (std::size_t b = 0; b < system_.blocks.size(); ++b) {
        const int body = static_cast<int>(b), count = system_.blocks[b].count;
        const ExactFactor exact(body_system(system_, body), host_);
        if (exact.singular >= 0) refuse_singular(model_, system_.particle[system_.blocks[b].first + exact.singular]);
        const auto each_column = [&](const auto& work) {
          dense_columns(
              exact, host_,
              [&](int first, const Vec4<double>* columns) {
                for (int k = 0; k < 4 && first + k < count; ++k)
                  work(first + k, [&](int i) { return (&columns[i].x)[k]; });
              },
              [&](const char* what, double part) {
                if (progress_) progress_(what, (body + part) / double(system_.blocks.size()));
              });
        };
        if (std::is_integral_v<V>)  // a second pass, because all scales are needed first
          each_column([&](int j, const auto& column) { engine.take_diagonal(body, j, column(j)); });
        each_column([&](int j, const auto& column) { engine.take(body, j, count, column); });
      }
    });
    return synchronize(std::move(made), "dense");
  }

  std::unique_ptr<Filter<R>> sparse() { return storage_ == Storage::Double ? sparse<double>() : sparse<float>(); }

  template <class T>
  std::unique_ptr<Filter<R>> sparse() {
    const double bytes = double(all_.entries()) * sizeof(T) + most_waiting(all_) * sizeof(double);
    require(bytes, "/bodies", "a sparse filter that takes " + in_gib(bytes) + " to factor", "");
    const Subtrees cut = subtrees(all_);
    auto made = std::make_unique<FilterOf<R, SparseFilter<Executor, T>>>(executor_, host_.threads, system_, all_, cut);
    auto& engine = made->engine;
    int failed = -1;
    facts_.factor_seconds = seconds([&] {
      failed = factor(
          system_, all_, cut, host_, [&](int s, const double* panel) { engine.take(s, panel); }, progress_);
    });
    if (failed >= 0) refuse_singular(model_, system_.particle[all_.order[failed]]);
    return synchronize(std::move(made), "sparse");
  }

  template <class Made>
  std::unique_ptr<Filter<R>> synchronize(std::unique_ptr<Made> made, const std::string& kind) {
    facts_.kind = kind;
    facts_.storage = storage_ == Storage::Double ? "double" : storage_ == Storage::Float ? "float" : "int16";
    facts_.why = why_;
    facts_.unknowns = system_.count(), facts_.bodies = static_cast<int>(system_.blocks.size());
    made->engine.send();
    facts_.numbers = made->engine.numbers(), facts_.bytes = made->engine.bytes();
    facts_.launches = made->engine.launches();
    made->facts() = facts_;
    return made;
  }

  Executor executor_;
  OpenMP host_;
  const Model& model_;
  const SpringSystem& system_;
  const ShowProgress& progress_;
  const DesbrunSpec& spec_;
  Storage storage_;
  std::string why_;
  Supernodes all_;
  FilterStats facts_;
};

}  // namespace detail

template <class Executor, class R>
std::unique_ptr<Filter<R>> make_filter(const Executor& executor, int threads, const Model& model,
                                       const SpringSystem& system, const ShowProgress& progress) {
  return detail::Maker<Executor, R>(executor, threads, model, system, progress)();
}

template <class Executor, class R>
FilterErrors filter_errors(const Filter<R>& filter, const Model& model, const SpringSystem& system) {
  PointArray<Executor, R> force(model.x.size()), acceleration(model.x.size());
  const ApplyFilter apply = [&](const std::vector<double>& forces) {
    std::vector<double> a = through_points(
        force, acceleration, system.particle,
        [&] {
          filter.apply({force.points(), acceleration.points(), false});
        },
        forces);
    remove_mean(system, a);
    return a;
  };
  ApplyFilter
      exact;  // needs a factorisation: used only if refinement with the filter under test does not converge to S
  const auto error = [&](const std::vector<double>& forces) {
    constexpr double small = 1e-9;
    Refined reference = refined(system, apply, forces);
    if (!(reference.step < small)) {
      if (!exact) exact = exact_filter(system);
      reference = refined(system, exact, forces);
    }
    return relative_difference(apply(forces), reference.accelerations);
  };
  const double noise = error(noise_forces(system));
  return {noise, error(elastic_forces(system))};
}

}  // namespace malha
