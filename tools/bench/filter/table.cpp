// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/filter/table.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "host/base/memory_size.h"
#include "malha/text.h"
#include "tools/bench/filter/step.h"
#include "tools/bench/output.h"

namespace malha::bench {

namespace {

std::string memory(double bytes) { return bytes < 1 << 30 ? formatted("%.3g MiB", bytes / (1 << 20)) : in_gib(bytes); }

std::string times_over(const std::vector<FilterRow>& rows, const FilterRow& row, const std::string& peer) {
  const FilterRow* other = row.layout.empty() ? row_of_kernel(rows, row, peer) : nullptr;
  return formatted(" %7s", other == nullptr ? "" : formatted("%.2f", times_as_fast(row, *other)).c_str());
}

std::string line(const std::vector<FilterRow>& rows, const FilterRow& row) {
  const bool limited = !row.read_seconds.empty();
  std::string text = formatted("  %-7s %-7s %7d %9.4g %-20s %7.1f %7s %7s %9.2g %9.2g %8.3g %9s", row.kernel.c_str(),
                               row.storage.c_str(), row.threads, row.ms(),
                               formatted("(%.4g .. %.4g)", row.ms_min(), row.ms_max()).c_str(), row.gb_per_s(),
                               limited ? formatted("%.0f %%", 100 * row.part_of_read_bandwidth()).c_str() : "",
                               limited ? formatted("%.2f", row.times_triad()).c_str() : "", row.noise_error,
                               row.elastic_error, row.setup_seconds, memory(row.memory_bytes).c_str());
  for (const char* peer : {"sgemm", "ssymm", "ssymv"}) text += times_over(rows, row, peer);
  text.erase(text.find_last_not_of(' ') + 1);
  return text + (row.layout.empty() ? "" : "  " + row.layout) + "\n";
}

std::string verdict(bool met) { return met ? "met\n" : "NOT MET\n"; }

std::string named(const FilterRow& row) {
  return row.kernel + " " + row.storage + ", n = " + std::to_string(row.n) + ", " + counted(row.threads, "thread");
}

std::string promise_line(const FilterRow& row, const std::string& what) {
  return formatted("  %-36s %s: ", named(row).c_str(), what.c_str());
}

/// Lines about the speed relative to OpenBLAS; it is promised at N = 46 and 100.
std::string blas_promise_lines(const std::vector<FilterRow>& rows, const FilterRow& row) {
  const FilterRow *gemm = row_of_kernel(rows, row, "sgemm"), *symm = row_of_kernel(rows, row, "ssymm"),
                  *symv = row_of_kernel(rows, row, "ssymv");
  if (gemm == nullptr || symm == nullptr || symv == nullptr) return "";
  const double best = std::min(times_as_fast(row, *gemm), times_as_fast(row, *symm)), three = times_as_fast(row, *symv);
  return promise_line(row, formatted("%5.2f x as fast as the better of sgemm and ssymm, at least 5", best)) +
         verdict(best >= 5) + promise_line(row, formatted("%5.2f x as fast as three ssymv, at least 3", three)) +
         verdict(three >= 3);
}

}  // namespace

std::string filter_table(const std::vector<FilterRow>& rows, const std::vector<std::string>& left_out) {
  std::string text;
  if (!rows.empty()) {
    text = formatted("\nN = %d: %d unknowns, %lld particles\n", rows.front().side, rows.front().n,
                     static_cast<long long>(rows.front().particles));
    text += formatted("  %-7s %-7s %7s %9s %-20s %7s %7s %7s %9s %9s %8s %9s %7s %7s %7s\n", "kernel", "storage",
                      "threads", "ms", "(min .. max)", "GB/s", "of read", "x triad", "error", "elastic", "setup s",
                      "memory", "/ sgemm", "/ ssymm", "/ ssymv");
  }
  for (const FilterRow& row : rows) text += line(rows, row);
  for (const std::string& what : left_out) text += "  left out: " + what + "\n";
  return text;
}

std::string step_table(const std::vector<FilterRow>& rows) {
  std::string text =
      formatted("\nLargest number of particles whose whole step takes at most %g ms (60 Hz), to 4 %%\n", kFrameMs);
  text += formatted("  %-12s %-7s %7s %9s %9s %9s %8s %9s\n", "kernel", "storage", "threads", "particles", "N",
                    "step ms", "setup s", "memory");
  for (const FilterRow& row : rows)
    text += formatted("  %-12s %-7s %7d %9lld %9d %9.4g %8.3g %9s%s\n", row.kernel.c_str(), row.storage.c_str(),
                      row.threads, static_cast<long long>(row.particles), row.side, row.ms(), row.setup_seconds,
                      memory(row.memory_bytes).c_str(), row.at_cap ? "  no larger size was tried" : "");
  return text;
}

std::string crossover(const std::vector<FilterRow>& rows) {
  std::map<int, std::map<int, double>> times;  // dense over sparse, by threads and size
  for (const FilterRow& row : rows)
    if (const FilterRow* dense = row_of_kernel(rows, row, "dense");
        row.kernel == "sparse" && row.storage == "float" && dense)
      times[row.threads][row.n] = times_as_fast(row, *dense);
  std::string text;
  for (const auto& [threads, by_size] : times) {
    text += "  on " + counted(threads, "thread") + " ";
    auto at = by_size.begin();
    while (at != by_size.end() && at->second < 1) ++at;
    if (at == by_size.end()) {
      text += "dense is the faster one at every size\n";
    } else if (at == by_size.begin()) {
      text += "sparse is the faster one from the smallest size on\n";
    } else {
      const auto before = std::prev(at);
      const double part = -std::log(before->second) / std::log(at->second / before->second);
      const double n = before->first * std::pow(double(at->first) / before->first, part);
      text += formatted("sparse is the faster one from about %.2g unknowns on (measured at %d and %d)\n", n,
                        before->first, at->first);
    }
  }
  return text.empty() ? "" : "\nDense or sparse, in float\n" + text;
}

std::string promise_lines(const std::vector<FilterRow>& rows, double cache_bytes) {
  constexpr double kReadPart = 0.85, kSparseMs = 4;
  std::string text;
  for (const FilterRow& row : rows) {
    if (row.kernel == "dense" && row.storage == "float" && (row.side == 46 || row.side == 100))
      text += blas_promise_lines(rows, row);
    if (row.kernel == "dense" && cache_bytes > 0 && row.bytes > cache_bytes)
      text += promise_line(row, formatted("%.0f %% of the bandwidth of reading, at least 85",
                                          100 * row.part_of_read_bandwidth())) +
              verdict(row.part_of_read_bandwidth() >= kReadPart);
    if (row.kernel == "sparse" && row.storage == "float" && row.side == 316 && row.threads == 2)
      text += promise_line(row, formatted("%.2f ms, at most %g (%.2f x a triad over as many bytes)", row.ms(),
                                          kSparseMs, row.times_triad())) +
              verdict(row.ms() <= kSparseMs);
  }
  return text.empty() ? "" : "\nPromises\n" + text;
}

}  // namespace malha::bench
