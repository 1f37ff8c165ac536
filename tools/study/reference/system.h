// SPDX-License-Identifier: Apache-2.0
// Equations of motion of a body of particles, in double and with Eigen only: the reference of the studies. It shares
// only the scene and its mesh with malha, no kernels and no solvers.
#pragma once
#include <Eigen/Dense>
#include <memory>
#include <vector>

#include "malha/scene.h"

namespace malha::study {

using Vector = Eigen::VectorXd;  // three coordinates per particle, in the order of Simulation::positions()

struct State {
  Vector x, v;  // m, m/s
};

/// Particles with internal forces and gravity.
class System {
 public:
  virtual ~System() = default;

  int count() const { return static_cast<int>(mass.size()); }
  virtual double elastic_energy(const Vector& x) const = 0;       // J
  virtual void add_forces(const Vector& x, Vector& f) const = 0;  // N
  virtual Vector strains(const Vector& x) const = 0;              // l / l0 - 1 of each edge
  Vector accelerations(const Vector& x) const;                    // m/s^2, 0 for pinned particles

  std::vector<double> mass;  // kg, of pinned particles too
  std::vector<bool> pinned;
  State start;
  Eigen::Vector3d gravity;
};

struct Spring {
  int i, j;
  double stiffness, rest;  // N/m, m
};

/// Quadratic bending at particle j: an energy of stiffness / 2 |x_i - 2 x_j + x_k|^2.
struct BendingElement {
  int i, j, k;
  double stiffness;  // N/m
};

/// f = -k (l - l0) along each spring, and bending.
class SpringSystem : public System {
 public:
  double elastic_energy(const Vector& x) const override;
  void add_forces(const Vector& x, Vector& f) const override;
  Vector strains(const Vector& x) const override;

  std::vector<Spring> springs;
  std::vector<BendingElement> bending;
};

/// Sets masses, pins, gravity and initial state from a scene's only body. `mesh`: of its shape.
void set_start(const Scene& scene, const Mesh& mesh, System& system);

/// l / l0 - 1 of each edge.
Vector edge_strains(const std::vector<Spring>& edges, const Vector& x);

/// The springs that correspond to the distance constraints of a scene's only body: k = 1 / compliance. All of them must
/// have a compliance. Constraints of a rigidity are bending of a grid, along its rows and columns.
std::unique_ptr<SpringSystem> spring_system(const Scene& scene);

/// The coordinates of points in one vector.
Vector flat(const std::vector<Vec3>& points);

/// Conversions from and to lists, for JSON.
std::vector<double> numbers_of(const Vector& a);
Vector vector_of(const std::vector<double>& numbers);

/// RMS distance of the particles, m.
double rms_distance(const Vector& a, const Vector& b);

/// Energies and momenta of a state.
struct ConservedQuantities {
  double kinetic, potential, elastic;          // J; gravity's potential is 0 at the origin
  Eigen::Vector3d momentum, angular_momentum;  // of movable particles, kg m/s and kg m^2/s about the origin
  double energy() const { return kinetic + potential + elastic; }
};
ConservedQuantities conserved_quantities(const System& system, const State& state);

/// The largest angular frequency omega_max (rad/s) of small motions about x: the square root of the largest eigenvalue
/// of M^-1 K, by power iteration, which converges from below. Symplectic Euler is stable up to steps of 2 / omega_max,
/// RK4 up to 2.83 / omega_max.
double largest_frequency(const System& system, const Vector& x);

}  // namespace malha::study
