// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/filter/filter_case.h"

#include <cstdlib>

#include "host/base/memory_size.h"
#include "host/base/point_array.h"
#include "host/base/stopwatch.h"
#include "host/filter/dense_filter.h"
#include "host/filter/factor.h"
#include "host/filter/filter.h"
#include "malha/error.h"
#include "malha/text.h"
#include "tools/bench/cloth.h"
#include "tools/bench/peers/openblas.h"

namespace malha::bench {

#if !defined(MALHA_HAS_OPENBLAS)
std::vector<BlasProduct> blas_products(int, const float*, int) { return {}; }
std::string openblas_version() { return ""; }
#endif

namespace {

int bytes_of(Storage storage) { return storage == Storage::Double ? 8 : storage == Storage::Float ? 4 : 2; }

bool fits(double bytes) { return bytes < 0.8 * double(available_memory()); }

std::string memory_shortage(double bytes) {
  return "it takes " + in_gib(bytes) + ", and " + in_gib(double(available_memory())) + " are free";
}

/// The reason why OpenBLAS has no rows; empty if it has some.
std::string blas_left_out(int threads) {
  if (openblas_version().empty())
    return "it was not installed when malha was built, or is no longer (Debian: libopenblas-dev)";
  const char* bound = std::getenv("OMP_PROC_BIND");
  if (threads > 1 && bound != nullptr && std::string(bound) != "false")
    return "OMP_PROC_BIND would keep all its threads on one core";
  return "";
}

}  // namespace

Scene spring_cloth(int side) {
  Scene scene = hanging_cloth(grid_case(side), {1, 1});
  scene.solver.type = "desbrun";
  return scene;
}

FilterCase::FilterCase(int side, int threads)
    : side_(side),
      setup_threads_(threads),
      model_(build_model(spring_cloth(side))),
      system_(spring_system(model_, model_.scene.solver.dt)) {
  noise_ = noise_forces(system_), elastic_ = elastic_forces(system_);
  const ProductVariant exact = filter<double>(FilterKind::Sparse, Storage::Double, threads);
  noise_solution_ = refined(system_, exact.apply, noise_).accelerations;
  elastic_solution_ = refined(system_, exact.apply, elastic_).accelerations;
}

template <class R>
ProductVariant FilterCase::filter(FilterKind kind, Storage storage, int threads) {
  model_.scene.solver.desbrun.filter = kind, model_.scene.solver.desbrun.storage = storage;
  std::shared_ptr<const Filter<R>> filter;
  ProductVariant made;
  made.row.setup_seconds =
      seconds([&] { filter = make_filter<OpenMP, R>(OpenMP{threads}, threads, model_, system_, {}); });
  const FilterStats& facts = filter->facts();
  made.stored_bytes = double(facts.numbers) * bytes_of(storage);
  made.row.bytes = made.stored_bytes * (kind == FilterKind::Sparse ? 2 : 1);
  made.row.kernel = facts.kind, made.row.storage = facts.storage;
  made.row.memory_bytes = double(facts.bytes);
  const auto force = std::make_shared<PointArray<OpenMP, R>>(model_.x.size());
  const auto acceleration = std::make_shared<PointArray<OpenMP, R>>(model_.x.size());
  made.product = [=] { filter->apply({force->points(), acceleration->points(), false}); };
  made.apply = [=, product = made.product, this](const std::vector<double>& forces) {
    return through_points(*force, *acceleration, system_.particle, product, forces);
  };
  return made;
}

void FilterCase::measure_errors(ProductVariant& one) const {
  one.row.noise_error = relative_difference(one.apply(noise_), noise_solution_);
  one.row.elastic_error = relative_difference(one.apply(elastic_), elastic_solution_);
}

void FilterCase::add_blas(int threads, std::vector<ProductVariant>& all, std::vector<std::string>& left_out) {
  const int n = system_.count();
  const double bytes = double(n) * n * sizeof(float);
  std::string why = blas_left_out(threads);
  if (why.empty() && full_matrix_.size() == 0 && !fits(bytes)) why = memory_shortage(bytes);
  if (!why.empty()) return left_out.push_back("OpenBLAS on " + counted(threads, "thread") + ": " + why);
  if (full_matrix_.size() == 0) {
    full_matrix_ = Array<OpenMP, float>(std::size_t(n) * n, 0.0f);
    float* s = full_matrix_.data();
    const auto store_columns = [&](int first, const Vec4<double>* columns) {
      for (int k = 0; k < 4 && first + k < n; ++k)
        for (int i = first + k; i < n; ++i) {
          const auto number = static_cast<float>((&columns[i].x)[k]);
          s[std::size_t(n) * i + first + k] = s[std::size_t(n) * (first + k) + i] = number;
        }
    };
    full_matrix_seconds_ = seconds([&] {
      const ExactFactor exact(system_, OpenMP{setup_threads_});
      if (exact.singular >= 0) throw std::runtime_error("the cloth's system is singular");
      dense_columns(exact, OpenMP{setup_threads_}, store_columns, {});
    });
  }
  for (BlasProduct& product : blas_products(n, full_matrix_.data(), threads)) {
    ProductVariant one;
    one.row.kernel = product.routine, one.row.storage = "float", one.row.layout = product.layout;
    one.row.bytes = product.bytes, one.row.memory_bytes = bytes, one.row.setup_seconds = full_matrix_seconds_;
    one.product = std::move(product.multiply), one.apply = std::move(product.apply);
    all.push_back(std::move(one));
  }
}

std::vector<ProductVariant> FilterCase::variants(int threads, bool dense, bool sparse,
                                                 std::vector<std::string>& left_out) {
  std::vector<ProductVariant> all;
  const auto add = [&](FilterKind kind, Storage storage, const std::string& name) {
    try {
      all.push_back(storage == Storage::Double ? filter<double>(kind, storage, threads)
                                               : filter<float>(kind, storage, threads));
    } catch (const InputError& error) {  // too little memory
      left_out.push_back(name + ": " + error.what());
    }
  };
  if (dense && system_.count() > kMostDense) {
    left_out.push_back("dense, OpenBLAS: " + std::to_string(system_.count()) + " unknowns are more than " +
                       std::to_string(kMostDense));
  } else if (dense) {
    for (const auto& [storage, name] : {std::pair{Storage::Float, "dense float"},
                                        {Storage::Double, "dense double"},
                                        {Storage::Int16, "dense int16"}}) {
      const double bytes = double(dense_values(system_)) * bytes_of(storage);
      if (fits(bytes))
        add(FilterKind::Dense, storage, name);
      else
        left_out.push_back(std::string(name) + ": " + memory_shortage(bytes));
    }
    add_blas(threads, all, left_out);
  }
  if (sparse) {
    add(FilterKind::Sparse, Storage::Float, "sparse float");
    add(FilterKind::Sparse, Storage::Double, "sparse double");
  }
  for (ProductVariant& one : all) {
    one.row.side = side_, one.row.particles = model_.count(), one.row.n = system_.count(), one.row.threads = threads;
    measure_errors(one);
  }
  return all;
}

}  // namespace malha::bench
