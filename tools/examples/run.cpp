// SPDX-License-Identifier: Apache-2.0
// Runs a scene and prints a position, the largest strain and the energy, with both kinds of errors handled.
#include <malha/scene.h>
#include <malha/simulation.h>

#include <cstdio>

int main(int count, char** arguments) {
  if (count != 2) return std::fprintf(stderr, "usage: %s SCENE\n", arguments[0]), 2;
  try {
    const malha::Scene scene = malha::load_scene(arguments[1]);
    malha::Simulation simulation(scene);
    for (int step = 0; step < 30; ++step) simulation.step();
    const malha::Measures measures = simulation.measure();
    const std::vector<malha::Vec3> x = simulation.positions();
    std::printf("%zu particles after %g s, the first at %g %g %g m\n", x.size(), simulation.time(), x[0][0], x[0][1],
                x[0][2]);
    std::printf("largest strain %g, energy %g J\n", measures.strain_max, measures.energy());
  } catch (const malha::Diverged& error) {  // the state is no longer finite, or has gained energy without cause
    return std::fprintf(stderr, "diverged: %s\n", error.what()), 3;
  } catch (const malha::InputError& error) {  // the message names file, place, the value found and allowed values
    return std::fprintf(stderr, "%s\n", error.what()), 2;
  }
}
