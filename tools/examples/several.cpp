// SPDX-License-Identifier: Apache-2.0
// Runs the same scene with several settings at once, one thread each, and prints the distances of the results after a
// second.
#include <malha/scene.h>
#include <malha/simulation.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <thread>
#include <vector>

int main(int count, char** arguments) {
  if (count != 2) return std::fprintf(stderr, "usage: %s SCENE\n", arguments[0]), 2;
  try {
    const malha::Scene scene = malha::load_scene(arguments[1]);
    const std::vector<int> substeps{5, 10, 20, 40};
    std::vector<std::vector<malha::Vec3>> x(substeps.size());
    std::vector<std::thread> threads;
    for (std::size_t k = 0; k < substeps.size(); ++k)
      threads.emplace_back([&, k] {
        malha::Scene own = scene;
        own.solver.substeps = substeps[k];
        malha::Simulation simulation(own, {.threads = 1});
        while (simulation.time() < 0.5 * own.solver.dt + 1 - own.solver.dt) simulation.step();
        x[k] = simulation.positions();
      });
    for (std::thread& thread : threads) thread.join();
    for (std::size_t k = 0; k + 1 < x.size(); ++k) {
      double most = 0;
      for (std::size_t i = 0; i < x[k].size(); ++i)
        most = std::max(
            most, std::hypot(x[k][i][0] - x[k + 1][i][0], x[k][i][1] - x[k + 1][i][1], x[k][i][2] - x[k + 1][i][2]));
      std::printf("%d and %d substeps: at most %.3g m apart\n", substeps[k], substeps[k + 1], most);
    }
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 1;
  }
}
