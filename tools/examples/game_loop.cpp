// SPDX-License-Identifier: Apache-2.0
// The loop of a game with a pool of its own: while the cloth of the next frame is simulated, other jobs of the frame
// run in the same pool. The cloth feels forces from an array, and is copied to memory as a renderer maps it, without an
// allocation. The results have the bits of OpenMP.
#include <malha/scene.h>
#include <malha/simulation.h>
#include <thread_pool.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <thread>
#include <vector>

namespace {

struct Vertex {
  float position[3], normal[3], texture[2];
};

/// A gust that comes and goes, N a particle.
void set_gust(double time, std::vector<malha::Vec3>& forces) {
  for (malha::Vec3& force : forces) force = {0, 0, 1e-4 * std::sin(4 * time)};
}

/// Takes a frame's share of the simulated time.
void simulate(malha::Simulation& simulation, double until, std::vector<malha::Vec3>& forces) {
  while (simulation.time() < until) {
    set_gust(simulation.time(), forces);
    simulation.set_forces(forces);
    simulation.step();
  }
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) return std::fprintf(stderr, "usage: %s SCENE\n", arguments[0]), 2;
  try {
    const malha::Scene scene = malha::load_scene(arguments[1]);
    ThreadPool pool(2);
    malha::SimulationOptions options;
    options.threads = 3;  // groups of a launch
    options.parallel_for = [&pool](int groups, const auto& function) { pool.parallel_for(groups, function); };
    malha::Simulation cloth(scene, options), reference(scene, {.threads = 2});
    const std::size_t particles = cloth.positions().size();
    std::vector<malha::Vec3> forces(particles), forces_of_reference(particles);
    std::vector<Vertex> buffer(particles);  // as a renderer maps it
    std::vector<double> others(64, 0);      // what the other jobs of the game compute
    constexpr std::size_t stride = sizeof(Vertex) / sizeof(float);
    for (int frame = 1; frame <= 30; ++frame) {
      const double until = frame / 60.0 - 1e-9;  // s
      std::thread physics([&] { simulate(cloth, until, forces); });
      pool.parallel_for(static_cast<int>(others.size()), [&](int job) {
        for (int i = 1; i < 2000; ++i) others[job] += std::sin(i * job) / i;
      });
      physics.join();
      cloth.copy_positions(buffer[0].position, stride);
      cloth.copy_normals(buffer[0].normal, stride);
      simulate(reference, until, forces_of_reference);
    }
    const float* const at = buffer[particles / 2].position;
    std::printf("after 30 frames particle %zu is at %g %g %g m; the other jobs found %g\n", particles / 2, at[0], at[1],
                at[2], others[1]);
    if (cloth.state_hash() != reference.state_hash()) return std::fprintf(stderr, "not the bits of OpenMP\n"), 1;
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 1;
  }
}
