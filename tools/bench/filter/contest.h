// SPDX-License-Identifier: Apache-2.0
// Who has a product of the filter at one size: malha's filters, and OpenBLAS.
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

/// Larger dense filters are left out: what sets them up grows faster than they do, and sparse ones win long before.
inline constexpr int kMostDense = 25'000;  // unknowns

/// The cloth of malha bench projection by Desbrun's method: springs of 1e4 N/m, one substep of 1/60 s.
Scene sprung(int side);

/// A row to fill, and its product.
struct Contestant {
  FilterRow row;
  std::function<void()> product;
  ApplyFilter apply;
  double stored_bytes = 0;  // read row.bytes / stored_bytes times; 0: not compared with the limits of the machine
};

/// A cloth, its system, and what filters make of two kinds of forces, to rounding.
class FilterCase {
 public:
  /// `threads`: of set-up.
  FilterCase(int side, int threads);

  /// Those on so many threads. Adds to `left_out` who cannot take part, and why. The case must outlive them.
  std::vector<Contestant> contestants(int threads, bool dense, bool sparse, std::vector<std::string>& left_out);
  const SpringSystem& system() const { return system_; }

 private:
  template <class R>
  Contestant filter(FilterKind kind, Storage storage, int threads);
  void add_blas(int threads, std::vector<Contestant>& all, std::vector<std::string>& left_out);
  void measure_errors(Contestant& one) const;

  int side_, setup_threads_;
  Model model_;
  SpringSystem system_;
  std::vector<double> noise_, elastic_, of_noise_, of_elastic_;  // forces, and accelerations from them
  Array<OpenMP, float> whole_;                                   // S, for OpenBLAS; empty: not made yet
  double whole_seconds_ = 0;
};

}  // namespace malha::bench
