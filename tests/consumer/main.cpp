// Loads the scene that it is given, steps it, and says where its first particle is.
#include <host/scene.h>
#include <host/simulation.h>

#include <cstdio>

int main(int, char** arguments) {
  const malha::Scene scene = malha::load_scene(arguments[1]);
  malha::Simulation simulation(scene);
  for (int i = 0; i < 3; ++i) simulation.step();
  const auto positions = simulation.positions();
  std::printf("%zu particles, the first at %g %g %g\n", positions.size(), positions[0][0], positions[0][1],
              positions[0][2]);
  return positions.empty();
}
