// SPDX-License-Identifier: Apache-2.0
// A program with its own main loop, as in a game: frames have different lengths, the scene's steps are equal, and drawn
// positions are interpolated between two steps. The program pulls a particle for a while and then releases it.
#include <malha/scene.h>
#include <malha/simulation.h>

#include <cmath>
#include <cstdio>
#include <vector>

int main(int count, char** arguments) {
  if (count != 2) return std::fprintf(stderr, "usage: %s SCENE\n", arguments[0]), 2;
  try {
    malha::Scene scene = malha::load_scene(arguments[1]);
    malha::Simulation simulation(scene, {.interactive = true});
    std::vector<malha::Vec3> before = simulation.positions(), now = before, drawn = before;
    const int pulled = static_cast<int>(now.size()) / 2;
    const malha::Vec3 start = now[pulled];
    double clock = 0;  // s, of the program
    for (int frame = 0; frame < 60; ++frame) {
      clock += frame % 3 == 0 ? 1 / 30.0 : 1 / 90.0;
      if (frame < 40)
        simulation.pull(pulled, {start[0] + 0.3 * std::sin(clock), start[1] + 0.2, start[2]}, 1e-3);  // m, m/N
      else
        simulation.release(pulled);
      for (; simulation.time() < clock; now = simulation.positions()) before = now, simulation.step();
      const double part = 1 - (simulation.time() - clock) / scene.solver.dt;
      for (std::size_t i = 0; i < now.size(); ++i)
        for (int k = 0; k < 3; ++k) drawn[i][k] = before[i][k] + part * (now[i][k] - before[i][k]);
    }
    std::printf("clock %g s, simulated %g s; particle %d is drawn at %g %g %g m\n", clock, simulation.time(), pulled,
                drawn[pulled][0], drawn[pulled][1], drawn[pulled][2]);
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 1;
  }
}
