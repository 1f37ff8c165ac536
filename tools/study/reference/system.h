// SPDX-License-Identifier: Apache-2.0
// What the studies compare malha with: a body of particles as plain equations of motion, in double and by Eigen alone.
// Nothing here is shared with malha's kernels or solvers but the scene and its mesh.
#pragma once
#include <Eigen/Dense>
#include <memory>
#include <vector>

#include "malha/scene.h"

namespace malha::study {

using Vector = Eigen::VectorXd;  // three numbers a particle, in the order of Simulation::positions()

struct State {
  Vector x, v;  // m, m/s
};

/// Particles with forces between them, in gravity.
class System {
 public:
  virtual ~System() = default;

  int count() const { return static_cast<int>(mass.size()); }
  virtual double elastic_energy(const Vector& x) const = 0;       // J
  virtual void add_forces(const Vector& x, Vector& f) const = 0;  // N
  virtual Vector strains(const Vector& x) const = 0;              // l / l0 - 1 of each edge
  Vector accelerations(const Vector& x) const;                    // m/s^2, 0 where pinned

  std::vector<double> mass;  // kg, of pinned particles too
  std::vector<bool> pinned;
  State start;
  Eigen::Vector3d gravity;
};

struct Spring {
  int i, j;
  double stiffness, rest;  // N/m, m
};

/// f = -k (l - l0) along each spring.
class SpringSystem : public System {
 public:
  double elastic_energy(const Vector& x) const override;
  void add_forces(const Vector& x, Vector& f) const override;
  Vector strains(const Vector& x) const override;

  std::vector<Spring> springs;
};

/// Masses, pins, gravity, and the start of a scene's only body; `mesh`: of its shape.
void set_start(const Scene& scene, const Mesh& mesh, System& system);

/// l / l0 - 1 of each.
Vector edge_strains(const std::vector<Spring>& edges, const Vector& x);

/// The springs that the distance constraints with a compliance of a scene's only body stand for: k = 1 / compliance.
std::unique_ptr<SpringSystem> spring_system(const Scene& scene);

/// Points as three numbers each.
Vector flat(const std::vector<Vec3>& points);

/// As JSON takes them, and back.
std::vector<double> numbers_of(const Vector& a);
Vector vector_of(const std::vector<double>& numbers);

/// Over the particles, m.
double rms_distance(const Vector& a, const Vector& b);

/// What a motion keeps, or should.
struct ConservedQuantities {
  double kinetic, potential, elastic;          // J; gravity's potential is 0 at the origin
  Eigen::Vector3d momentum, angular_momentum;  // kg m/s, kg m^2/s about the origin; of movable particles
  double energy() const { return kinetic + potential + elastic; }
};
ConservedQuantities conserved_quantities(const System& system, const State& state);

/// The largest angular frequency (rad/s) of small motions about x: the root of the largest eigenvalue of M^-1 K, by
/// power iteration, from below. Explicit (symplectic) Euler is stable up to steps of 2 / omega_max, RK4 up to 2.83.
double largest_frequency(const System& system, const Vector& x);

}  // namespace malha::study
