// SPDX-License-Identifier: Apache-2.0
// Two simulations in one pool of std::threads, which malha uses instead of threads of its own. The results have the
// bits of OpenMP.
#include <malha/scene.h>
#include <malha/simulation.h>
#include <thread_pool.h>

#include <cstdint>
#include <cstdio>
#include <thread>
#include <vector>

int main(int count, char** arguments) {
  if (count != 2) return std::fprintf(stderr, "usage: %s SCENE\n", arguments[0]), 2;
  try {
    const malha::Scene scene = malha::load_scene(arguments[1]);
    const auto run = [&scene](const malha::SimulationOptions& options) {
      malha::Simulation simulation(scene, options);
      for (int step = 0; step < 30; ++step) simulation.step();
      return simulation.state_hash();
    };
    const std::uint64_t by_openmp = run({.threads = 2});

    ThreadPool pool(2);
    malha::SimulationOptions options;
    options.threads = 4;  // groups of a launch
    options.parallel_for = [&pool](int groups, const auto& function) { pool.parallel_for(groups, function); };
    std::uint64_t found[2] = {};
    std::thread other([&] { found[1] = run(options); });
    found[0] = run(options);
    other.join();
    for (const std::uint64_t hash : found) {
      std::printf("state %016llx in the pool, %016llx by OpenMP\n", static_cast<unsigned long long>(hash),
                  static_cast<unsigned long long>(by_openmp));
      if (hash != by_openmp) return 1;
    }
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 1;
  }
}
