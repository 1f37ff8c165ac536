// SPDX-License-Identifier: Apache-2.0
// The variants of the filter product that are compared at one size: malha's filters, and OpenBLAS.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "host/base/array.h"
#include "host/filter/filter_errors.h"
#include "host/model/model.h"
#include "kernels/parallel/compute.h"
#include "tools/bench/filter/row.h"

namespace malha::bench {

/// Larger dense filters are left out: their set-up grows faster than the product, and sparse filters are faster long
/// before.
inline constexpr int kMostDense = 25'000;  // unknowns

/// The hanging cloth solved by Desbrun's method: springs of 1e4 N/m, one substep of 1/60 s.
Scene spring_cloth(int side);

/// A way to compute the filter product, and its row of the table.
struct ProductVariant {
  FilterRow row;
  std::function<void()> product;
  ApplyFilter apply;
  double stored_bytes = 0;  // size of the filter's values, which a product reads row.bytes / stored_bytes times; 0: not
  // compared with the machine's bandwidth
};

/// A cloth, its linear system, and the solutions for two kinds of forces, accurate to rounding.
class FilterCase {
 public:
  /// `threads`: how many threads set the filters up.
  FilterCase(int side, int threads);

  /// The variants on `threads` threads. Adds those that cannot run, with the reason, to `left_out`. The case must
  /// outlive the variants.
  std::vector<ProductVariant> variants(int threads, bool dense, bool sparse, std::vector<std::string>& left_out);
  const SpringSystem& system() const { return system_; }

 private:
  template <class R>
  ProductVariant filter(FilterKind kind, Storage storage, int threads);
  void add_blas(int threads, std::vector<ProductVariant>& all, std::vector<std::string>& left_out);
  void measure_errors(ProductVariant& one) const;

  int side_, setup_threads_;
  Model model_;
  SpringSystem system_;
  std::vector<double> noise_, elastic_;                    // forces
  std::vector<double> noise_solution_, elastic_solution_;  // accelerations that follow from them
  Array<OpenMP, float> full_matrix_;                       // S, for OpenBLAS; empty: not computed yet
  double full_matrix_seconds_ = 0;
};

}  // namespace malha::bench
