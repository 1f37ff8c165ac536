// SPDX-License-Identifier: Apache-2.0
// One line of the results: one library, on so many threads, with one schedule, on one case.
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
  int n = 0;        // particles a side, or particles where irregular
  double side = 0;  // particles a side
  std::int64_t particles = 0, constraints = 0;
  std::int64_t projections = 0;  // single constraints, of a step
  std::string library, version;
  std::string backend = "openmp";  // of malha
  bool on_device() const { return backend == "cuda"; }
  Schedule schedule;
  int levels = 0;  // that the case has
  int threads = 1;
  Strain strain;  // after the warm-up
  std::uint64_t state_hash = 0;
  std::vector<double> step_seconds;    // of each repeat
  NamedNumbers setup_seconds, memory;  // with "total"; bytes by owner; malha's alone

  double working_set_bytes = 0, triad_gb_per_s = 0;  // the triad's at that size and on these threads
  double floor_memory_ns = 0, floor_operations_ns = 0;

  double step_ms() const;            // median over the repeats
  double ns_per_projection() const;  // of the whole step, median
  double ns_min() const;
  double ns_max() const;
  double floor_ns() const;
  double ns(double step_seconds) const;  // a projection of a step that takes so long
};

/// "2 threads", "the device".
std::string where_of(const Row& row);

/// How many times as fast `row` is as `other`, a projection: the median over the repeats, which took turns.
double times_as_fast(const Row& row, const Row& other);

/// How long a step of `row` takes, in steps of `other`: likewise.
double times_as_long(const Row& row, const Row& other);

/// The row of the same case, library and schedule on one thread, and Bullet's row of the case; null where not measured.
const Row* on_one_thread(const std::vector<Row>& rows, const Row& row);
const Row* bullet_of(const std::vector<Row>& rows, const Row& row);
/// Of a row with levels, that on as many threads without them; null of others.
const Row* without_levels(const std::vector<Row>& rows, const Row& row);

/// The rows as a JSON array, an object a row.
nlohmann::ordered_json to_json(const std::vector<Row>& rows);

}  // namespace malha::bench
