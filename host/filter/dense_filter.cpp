// SPDX-License-Identifier: Apache-2.0
#include "host/filter/dense_filter.h"

#include <algorithm>
#include <cmath>

namespace malha {

namespace {

int row_blocks(const SystemBlock& body) { return (body.count + kDenseRows - 1) / kDenseRows; }

/// Partition of a body into chunks of about equal size, no more than is worth the summation of their results.
int chunks_of(int blocks) { return std::clamp(blocks / 6, 1, 32); }

}  // namespace

std::int64_t dense_values(const SpringSystem& system) {
  std::int64_t sum = 0;
  for (const SystemBlock& body : system.blocks) sum += dense_numbers(row_blocks(body));
  return sum;
}

DensePlan plan_dense(const SpringSystem& system) {
  DensePlan plan;
  for (const SystemBlock& body : system.blocks) {
    const int blocks = row_blocks(body), chunks = chunks_of(blocks), x = static_cast<int>(plan.rows.size());
    const auto first = static_cast<int>(plan.chunks.size());
    for (int c = 0, begin = 0, end; c < chunks; ++c, begin = end) {
      // The numbers before a row grow with its square.
      end = c + 1 == chunks ? blocks : static_cast<int>(std::lround(blocks * std::sqrt(double(c + 1) / chunks)));
      plan.chunks.push_back({begin, end, plan.values, x, plan.sums});
      plan.sums += end;
    }
    for (int b = 0, c = 0; b < blocks; ++b) {
      while (plan.chunks[first + c].end <= b) ++c;
      plan.rows.push_back({first + c, chunks - c, b});
    }
    for (int i = 0; i < kDenseRows * blocks; ++i)
      plan.particle.push_back(i < body.count ? system.particle[body.first + i] : -1);
    plan.at.push_back(plan.values);
    plan.first_row.push_back(kDenseRows * x);
    plan.values += dense_numbers(blocks);
  }
  return plan;
}

}  // namespace malha
