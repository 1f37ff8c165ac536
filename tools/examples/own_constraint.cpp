// SPDX-License-Identifier: Apache-2.0
// A user constraint in a program: the last particle of a scene moves on a sphere through its initial position. User
// constraints are for trying ideas; as a kernel (kernels/README.md) a constraint is a hundred times faster.
#include <malha/scene.h>
#include <malha/simulation.h>
#include <malha/user_constraint.h>

#include <cmath>
#include <cstdio>

int main(int count, char** arguments) {
  if (count != 2) return std::fprintf(stderr, "usage: %s SCENE\n", arguments[0]), 2;
  try {
    const malha::Scene scene = malha::load_scene(arguments[1]);
    const std::vector<malha::Vec3> start = malha::Simulation(scene).positions();
    const int last = static_cast<int>(start.size()) - 1;
    constexpr double radius = 0.05;  // m
    const malha::Vec3 centre{start[last][0], start[last][1] + radius, start[last][2]};

    malha::UserConstraint sphere;
    sphere.name = "sphere", sphere.arity = 1, sphere.particles = {last};
    sphere.evaluate = [&](const malha::UserBatch& batch) {
      for (int c = 0; c < batch.count; ++c) {
        const malha::Vec3& x = batch.x[c];
        const malha::Vec3 d{x[0] - centre[0], x[1] - centre[1], x[2] - centre[2]};
        const double distance = std::hypot(d[0], d[1], d[2]);
        batch.C[c] = distance - radius;
        for (int k = 0; k < 3; ++k) batch.gradient[c][k] = distance > 0 ? d[k] / distance : 0;
      }
    };
    malha::check_gradients(sphere, start);

    malha::Simulation simulation(scene, {.constraints = {sphere}});
    while (simulation.time() < 1) simulation.step();
    const malha::Vec3 x = simulation.positions()[last];
    const double off = std::hypot(x[0] - centre[0], x[1] - centre[1], x[2] - centre[2]) - radius;
    std::printf("after %g s particle %d is at %g %g %g m, %.1g m off the sphere\n", simulation.time(), last, x[0], x[1],
                x[2], off);
    return std::abs(off) < 1e-5 ? 0 : 1;
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 1;
  }
}
