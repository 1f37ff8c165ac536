// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/filter/measure.h"

#include <algorithm>
#include <chrono>
#include <thread>

#include "malha/text.h"
#include "tools/bench/filter/contest.h"
#include "tools/bench/machine.h"
#include "tools/bench/medians.h"
#include "tools/bench/pinned.h"
#include "tools/bench/stream.h"

namespace malha::bench {

namespace {

/// Workers of OpenMP and of OpenBLAS look for work for a while after a product (27 ms): not on the next one's cores.
void let_workers_sleep() { std::this_thread::sleep_for(std::chrono::milliseconds(40)); }

}  // namespace

FilterRows measure_filters(int side, const FilterTiming& timing,
                           const std::function<void(const std::string&, double)>& doing) {
  FilterRows result;
  doing("setting up", 0);
  FilterCase which(side, timing.threads.back());
  for (std::size_t t = 0; t < timing.threads.size(); ++t) {
    const int threads = timing.threads[t];
    const double parts = static_cast<double>(timing.threads.size()), first = static_cast<double>(t) / parts;
    doing("setting up on " + counted(threads, "thread"), first);
    std::vector<Contestant> all = which.contestants(threads, timing.dense, timing.sparse, result.left_out);
    // Reading and the triad move the same bytes, from an array of the same size: or of one that is no less out of the
    // caches, but smaller.
    double most = 0;
    const auto size = [](const Contestant& one) { return std::min(one.stored_bytes, double(kMemoryBytes)); };
    for (const Contestant& one : all) most = std::max(most, size(one));
    const Streams streams(static_cast<std::size_t>(most), threads);
    for (int repeat = 1; repeat <= timing.repeats; ++repeat)
      for (Contestant& one : all) {
        doing("repeat " + std::to_string(repeat) + ": " + one.row.kernel + " " + one.row.storage + " on " +
                  counted(threads, "thread"),
              first + (repeat - 1.0) / timing.repeats / parts);
        let_workers_sleep();
        const Pinned pinned(one.stored_bytes == 0 ? 1 : threads);  // OpenBLAS's are its own
        one.product();                                             // caches hold what it leaves there
        one.row.seconds.push_back(seconds_each(one.product, timing.seconds));
        if (one.stored_bytes == 0) continue;
        const auto bytes = static_cast<std::size_t>(size(one));
        const double times = one.row.bytes / double(bytes);
        one.row.read_seconds.push_back(times * streams.read(bytes, timing.seconds));
        one.row.triad_seconds.push_back(times * streams.triad(bytes, timing.seconds));
      }
    for (Contestant& one : all) result.rows.push_back(std::move(one.row));
  }
  return result;
}

}  // namespace malha::bench
