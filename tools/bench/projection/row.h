// SPDX-License-Identifier: Apache-2.0
// A row of malha bench projection: one library with one schedule on a number of threads, on one case.
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host/report/report.h"
#include "tools/bench/cloth.h"

namespace malha::bench {

struct Row {
  std::string case_name;
  int n = 0;        // particles a side of the grid, or particles of the irregular mesh
  double side = 0;  // particles a side
  std::int64_t particles = 0, constraints = 0;
  std::int64_t projections = 0;  // of single constraints in a step
  std::string library, version;
  std::string backend = "openmp";  // of malha
  bool on_device() const { return backend == "cuda"; }
  Schedule schedule;
  int levels = 0;  // number of levels that the solver made
  int threads = 1;
  Strain strain;  // after the warm-up
  std::uint64_t state_hash = 0;
  std::vector<double> step_seconds;    // of each repeat
  NamedNumbers setup_seconds, memory;  // of malha: seconds by part with "total", and bytes by owner

  double working_set_bytes = 0, triad_gb_per_s = 0;  // the triad's bandwidth at that size on as many threads
  double floor_memory_ns = 0, floor_operations_ns = 0;

  double step_ms() const;            // median over the repeats
  double ns_per_projection() const;  // of the whole step, median
  double ns_min() const;
  double ns_max() const;
  double floor_ns() const;
  double ns(double step_seconds) const;  // per projection, for a step of that duration
};

/// Where the row ran, in words: "2 threads" or "the device".
std::string executor_of(const Row& row);

/// How many times as fast `row` is as `other`, per projection: the median over the repeats, which were taken in turns.
double times_as_fast(const Row& row, const Row& other);

/// The time of a step of `row` over that of a step of `other`: the median over the repeats.
double times_as_long(const Row& row, const Row& other);

/// The row of the same case, library and schedule on one thread, and Bullet's row of the case; null if not measured.
const Row* on_one_thread(const std::vector<Row>& rows, const Row& row);
const Row* bullet_of(const std::vector<Row>& rows, const Row& row);
/// For a row with levels, the row on as many threads without them; null for other rows.
const Row* without_levels(const std::vector<Row>& rows, const Row& row);

/// The rows as a JSON array of objects.
nlohmann::ordered_json to_json(const std::vector<Row>& rows);

}  // namespace malha::bench
