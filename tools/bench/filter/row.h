// SPDX-License-Identifier: Apache-2.0
// A row of malha bench filter: one variant of the filter product, on a number of threads, at one size.
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace malha::bench {

struct FilterRow {
  int side = 0;  // particles a side of the grid
  std::int64_t particles = 0;
  int n = 0;  // unknowns
  int threads = 1;
  std::string kernel;           // "dense", "sparse", "sgemm", "ssymm", "ssymv"; "dense step", "sparse step"
  std::string storage;          // type of the filter's values: "float", "double", "int16"
  std::string layout;           // of OpenBLAS's matrix: the fastest one
  std::vector<double> seconds;  // of a product in each turn, or of each step
  double bytes = 0;             // of the filter that a product reads; a sparse one reads each value twice
  double memory_bytes = 0;
  double noise_error = 0, elastic_error = 0;  // relative, see host/measure/solver_stats.h
  double setup_seconds = 0;
  std::vector<double> read_seconds, triad_seconds;  // for moving as many bytes, in the same turns; empty: OpenBLAS
  bool at_cap = false;                              // of a step: no larger size was tried

  bool is_step() const { return kernel.ends_with(" step"); }
  double ms() const;  // median
  double ms_min() const;
  double ms_max() const;
  double gb_per_s() const;
  double part_of_read_bandwidth() const;  // bandwidth over that of reading alone: the median over the turns
  double times_triad() const;             // time over that of a triad over as many bytes
};

/// How many times as fast `row` is as `other`: the median over the turns.
double times_as_fast(const FilterRow& row, const FilterRow& other);

/// The row of another kernel at the same size, on as many threads, stored as float; null if it was not measured.
const FilterRow* row_of_kernel(const std::vector<FilterRow>& rows, const FilterRow& row, const std::string& kernel);

/// The rows as a JSON array of objects.
nlohmann::ordered_json to_json(const std::vector<FilterRow>& rows);

}  // namespace malha::bench
