// SPDX-License-Identifier: Apache-2.0
// A simulation in an arena of oneTBB, as in a program whose other work runs there too. The results have the bits of
// OpenMP.
#include <malha/scene.h>
#include <malha/simulation.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <cstdint>
#include <cstdio>

int main(int count, char** arguments) {
  if (count != 2) return std::fprintf(stderr, "usage: %s SCENE\n", arguments[0]), 2;
  try {
    const malha::Scene scene = malha::load_scene(arguments[1]);
    const auto run = [&scene](const malha::SimulationOptions& options) {
      malha::Simulation simulation(scene, options);
      for (int step = 0; step < 30; ++step) simulation.step();
      return simulation.state_hash();
    };
    tbb::task_arena arena(2);
    malha::SimulationOptions options;
    options.threads = arena.max_concurrency();
    options.parallel_for = [&arena](int groups, const auto& function) {
      arena.execute([&] { tbb::parallel_for(0, groups, function, tbb::simple_partitioner{}); });
    };
    const std::uint64_t by_tbb = run(options), by_openmp = run({.threads = 2});
    std::printf("state %016llx by oneTBB, %016llx by OpenMP\n", static_cast<unsigned long long>(by_tbb),
                static_cast<unsigned long long>(by_openmp));
    if (by_tbb != by_openmp) return 1;
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 1;
  }
}
