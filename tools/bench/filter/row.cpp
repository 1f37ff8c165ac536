// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/filter/row.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tools/bench/medians.h"

namespace malha::bench {

double FilterRow::ms() const { return median(seconds) * 1e3; }
double FilterRow::ms_min() const { return *std::min_element(seconds.begin(), seconds.end()) * 1e3; }
double FilterRow::ms_max() const { return *std::max_element(seconds.begin(), seconds.end()) * 1e3; }
double FilterRow::gb_per_s() const { return bytes / ms() / 1e6; }
double FilterRow::part_of_read_bandwidth() const { return median_ratio(read_seconds, seconds); }
double FilterRow::times_triad() const { return median_ratio(seconds, triad_seconds); }

double times_as_fast(const FilterRow& row, const FilterRow& other) { return median_ratio(other.seconds, row.seconds); }

const FilterRow* row_of_kernel(const std::vector<FilterRow>& rows, const FilterRow& row, const std::string& kernel) {
  for (const FilterRow& other : rows)
    if (other.n == row.n && other.threads == row.threads && other.kernel == kernel && other.storage == "float")
      return &other;
  return nullptr;
}

nlohmann::ordered_json to_json(const std::vector<FilterRow>& rows) {
  using Json = nlohmann::ordered_json;
  Json array = Json::array();
  for (const FilterRow& row : rows) {
    Json json{{"n", row.n},
              {"particles", row.particles},
              {"side", row.side},
              {"threads", row.threads},
              {"kernel", row.kernel},
              {"storage", row.storage},
              {"ms", row.ms()},
              {"ms_min", row.ms_min()},
              {"ms_max", row.ms_max()},
              {"gb_per_s", row.gb_per_s()},
              {"relative_error", row.noise_error},
              {"relative_error_elastic", row.elastic_error},
              {"setup_s", row.setup_seconds},
              {"memory_bytes", static_cast<std::int64_t>(row.memory_bytes)}};
    if (!row.layout.empty()) json["way"] = row.layout;
    if (row.is_step()) json["at_cap"] = row.at_cap;
    if (!row.read_seconds.empty()) {
      json["read_gb_per_s"] = row.bytes / median(row.read_seconds) / 1e9;
      json["of_read_bandwidth"] = row.part_of_read_bandwidth();
      json["times_triad"] = row.times_triad();
      for (const char* peer : {"sgemm", "ssymm", "ssymv"})
        if (const FilterRow* other = row_of_kernel(rows, row, peer))
          json["times_as_fast_as_" + std::string(peer)] = times_as_fast(row, *other);
    }
    array.push_back(json);
  }
  return array;
}

}  // namespace malha::bench
