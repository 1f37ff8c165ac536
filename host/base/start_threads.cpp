// SPDX-License-Identifier: Apache-2.0
#include "host/base/start_threads.h"

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "malha/error.h"

namespace malha {

void require_threads(int threads) {
  static std::atomic<int> started{1};
  if (threads <= started) return;
  std::atomic<bool> done{false};
  std::vector<std::thread> all;
  const auto end = [&] {
    done = true, done.notify_all();
    for (std::thread& one : all) one.join();
  };
  try {
    all.reserve(static_cast<std::size_t>(threads));
    while (static_cast<int>(all.size()) < threads - 1) all.emplace_back([&done] { done.wait(false); });
  } catch (const std::exception&) {  // there is no memory for its stack, or the user may start no more
    end();
    refuse<OutOfMemory>("malha", "threads",
                        std::to_string(threads) + ", of which only " + std::to_string(all.size() + 1) + " can start",
                        "as many as there is memory for (--threads 1)");
  }
  end();
  started = threads;
}

}  // namespace malha
