// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/projection/row.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "malha/text.h"
#include "tools/bench/medians.h"

namespace malha::bench {

namespace {

template <class Test>
const Row* find(const std::vector<Row>& rows, const Row& like, int threads, Test test) {
  for (const Row& row : rows)
    if (row.case_name == like.case_name && row.n == like.n && row.threads == threads && test(row)) return &row;
  return nullptr;
}

}  // namespace

double Row::ns(double seconds) const { return seconds * 1e9 / static_cast<double>(projections); }
double Row::step_ms() const { return median(step_seconds) * 1e3; }
double Row::ns_per_projection() const { return ns(median(step_seconds)); }
double Row::ns_min() const { return ns(*std::min_element(step_seconds.begin(), step_seconds.end())); }
double Row::ns_max() const { return ns(*std::max_element(step_seconds.begin(), step_seconds.end())); }
double Row::floor_ns() const { return std::max(floor_memory_ns, floor_operations_ns); }

std::string executor_of(const Row& row) { return row.on_device() ? "the device" : counted(row.threads, "thread"); }

double times_as_fast(const Row& row, const Row& other) {
  std::vector<double> ratios;
  for (std::size_t r = 0; r < row.step_seconds.size(); ++r)
    ratios.push_back(other.ns(other.step_seconds[r]) / row.ns(row.step_seconds[r]));
  return median(ratios);
}

double times_as_long(const Row& row, const Row& other) { return median_ratio(row.step_seconds, other.step_seconds); }

const Row* on_one_thread(const std::vector<Row>& rows, const Row& row) {
  return find(rows, row, 1, [&row](const Row& r) { return r.library == row.library && r.schedule == row.schedule; });
}

const Row* bullet_of(const std::vector<Row>& rows, const Row& row) {
  return find(rows, row, 1, [](const Row& r) { return r.library == "bullet"; });
}

const Row* without_levels(const std::vector<Row>& rows, const Row& row) {
  if (!row.schedule.levels) return nullptr;
  Schedule schedule = row.schedule;
  schedule.levels = false;
  return find(rows, row, row.threads, [&](const Row& r) { return r.library == "malha" && r.schedule == schedule; });
}

nlohmann::ordered_json to_json(const std::vector<Row>& rows) {
  using Json = nlohmann::ordered_json;
  Json array = Json::array();
  for (const Row& row : rows) {
    Json json{{"case", row.case_name},
              {"n", row.n},
              {"particles", row.particles},
              {"constraints", row.constraints},
              {"threads", row.threads},
              {"schedule", row.schedule.name()},
              {"levels", row.levels},
              {"library", row.library},
              {"library_version", row.version},
              {"ns_per_projection", row.ns_per_projection()},
              {"ns_min", row.ns_min()},
              {"ns_max", row.ns_max()},
              {"step_ms", row.step_ms()},
              {"strain_rms", row.strain.rms},
              {"strain_max", row.strain.max},
              {"state_hash", hex(row.state_hash)},
              {"working_set_bytes", row.working_set_bytes},
              {"triad_gb_per_s", row.triad_gb_per_s},
              {"floor_memory_ns", row.floor_memory_ns},
              {"floor_operations_ns", row.floor_operations_ns},
              {"floor_ns", row.floor_ns()},
              {"times_floor", row.ns_per_projection() / row.floor_ns()}};
    if (row.library == "malha") json["backend"] = row.backend;
    for (const auto& [part, seconds] : row.setup_seconds) json["setup_s"][part] = seconds;
    for (const auto& [owner, bytes] : row.memory) json["memory_bytes"][owner] = static_cast<std::int64_t>(bytes);
    if (const Row* one = on_one_thread(rows, row)) json["times_as_fast_as_one_thread"] = times_as_fast(row, *one);
    if (const Row* plain = without_levels(rows, row))
      json["times_the_step_without_levels"] = times_as_long(row, *plain);
    if (const Row* peer = bullet_of(rows, row)) json["times_as_fast_as_bullet"] = times_as_fast(row, *peer);
    array.push_back(json);
  }
  return array;
}

}  // namespace malha::bench
