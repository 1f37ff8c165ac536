// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/filter/measure.h"

#include <algorithm>
#include <chrono>
#include <thread>

#include "malha/text.h"
#include "tools/bench/filter/filter_case.h"
#include "tools/bench/machine.h"
#include "tools/bench/medians.h"
#include "tools/bench/pinned.h"
#include "tools/bench/stream.h"

namespace malha::bench {

namespace {

/// Threads of OpenMP and of OpenBLAS spin for a while after a product (27 ms), and would occupy cores of the next one.
void wait_for_idle_workers() { std::this_thread::sleep_for(std::chrono::milliseconds(40)); }

}  // namespace

FilterRows measure_filters(int side, const FilterTiming& timing,
                           const std::function<void(const std::string&, double)>& show_progress) {
  FilterRows result;
  show_progress("setting up", 0);
  FilterCase which(side, timing.threads.back());
  for (std::size_t t = 0; t < timing.threads.size(); ++t) {
    const int threads = timing.threads[t];
    const double parts = static_cast<double>(timing.threads.size()), first = static_cast<double>(t) / parts;
    show_progress("setting up on " + counted(threads, "thread"), first);
    std::vector<ProductVariant> all = which.variants(threads, timing.dense, timing.sparse, result.left_out);
    // Reading and the triad move as many bytes, from an array of the same size, or from a smaller one that exceeds the
    // caches as well.
    double largest = 0;
    const auto size = [](const ProductVariant& one) { return std::min(one.stored_bytes, double(kMemoryBytes)); };
    for (const ProductVariant& one : all) largest = std::max(largest, size(one));
    const Streams streams(static_cast<std::size_t>(largest), threads);
    for (int repeat = 1; repeat <= timing.repeats; ++repeat)
      for (ProductVariant& one : all) {
        show_progress("repeat " + std::to_string(repeat) + ": " + one.row.kernel + " " + one.row.storage + " on " +
                          counted(threads, "thread"),
                      first + (repeat - 1.0) / timing.repeats / parts);
        wait_for_idle_workers();
        const Pinned pinned(one.stored_bytes == 0 ? 1 : threads);  // OpenBLAS has threads of its own
        one.product();                                             // fills the caches
        one.row.seconds.push_back(mean_seconds(one.product, timing.seconds));
        if (one.stored_bytes == 0) continue;
        const auto bytes = static_cast<std::size_t>(size(one));
        const double times = one.row.bytes / double(bytes);
        one.row.read_seconds.push_back(times * streams.read(bytes, timing.seconds));
        one.row.triad_seconds.push_back(times * streams.triad(bytes, timing.seconds));
      }
    for (ProductVariant& one : all) result.rows.push_back(std::move(one.row));
  }
  return result;
}

}  // namespace malha::bench
