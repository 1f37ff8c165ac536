// SPDX-License-Identifier: Apache-2.0
// Memory layout of a dense filter.
#pragma once
#include <cstdint>
#include <vector>

#include "host/filter/system.h"
#include "kernels/filter/dense_filter.h"

namespace malha {

/// The lists of DenseView. Bodies one after the other, each padded to whole blocks of rows.
struct DensePlan {
  std::vector<DenseChunk> chunks;  // body by body
  std::vector<DenseRow> rows;
  std::vector<int> particle;
  std::vector<std::int64_t> at;  // of each body's numbers of S
  std::vector<int> first_row;    // of each body
  std::int64_t values = 0;       // numbers of S
  int sums = 0;                  // blocks of sums of all chunks
};

DensePlan plan_dense(const SpringSystem& system);

/// Number of entries of S that plan_dense() would lay out.
std::int64_t dense_values(const SpringSystem& system);

}  // namespace malha
