// SPDX-License-Identifier: Apache-2.0
#include "tools/study/reference/tetrahedra.h"

#include <cmath>

#include "host/mesh/generate.h"
#include "host/mesh/topology.h"

namespace malha::study {

namespace {

Eigen::Matrix3d edges_of(const Vector& x, const std::array<int, 4>& corners) {
  Eigen::Matrix3d D;
  for (int k = 0; k < 3; ++k) D.col(k) = x.segment<3>(3 * corners[k + 1]) - x.segment<3>(3 * corners[0]);
  return D;
}

Eigen::Matrix3d cofactors(const Eigen::Matrix3d& F) {
  Eigen::Matrix3d c;
  for (int k = 0; k < 3; ++k) c.col(k) = F.col((k + 1) % 3).cross(F.col((k + 2) % 3));
  return c;
}

}  // namespace

double TetrahedronSystem::elastic_energy(const Vector& x) const {
  const double gamma = 1 + 0.75 * mu / lambda;
  const double at_rest = mu / 2 * (3 - std::log(4)) + lambda / 2 * (1 - gamma) * (1 - gamma);
  double sum = 0;
  for (const Element& e : elements) {
    const Eigen::Matrix3d F = edges_of(x, e.corners) * e.rest;
    const double I = F.squaredNorm(), J = F.determinant();
    sum += e.volume * (mu / 2 * (I - std::log1p(I)) + lambda / 2 * (J - gamma) * (J - gamma) - at_rest);
  }
  return sum;
}

void TetrahedronSystem::add_forces(const Vector& x, Vector& f) const {
  const double gamma = 1 + 0.75 * mu / lambda;
  for (const Element& e : elements) {
    const Eigen::Matrix3d F = edges_of(x, e.corners) * e.rest;
    const Eigen::Matrix3d stress =
        mu * (1 - 1 / (1 + F.squaredNorm())) * F + lambda * (F.determinant() - gamma) * cofactors(F);
    const Eigen::Matrix3d pull = -e.volume * stress * e.rest.transpose();
    for (int k = 0; k < 3; ++k) {
      f.segment<3>(3 * e.corners[k + 1]) += pull.col(k);
      f.segment<3>(3 * e.corners[0]) -= pull.col(k);
    }
  }
}

Vector TetrahedronSystem::strains(const Vector& x) const { return edge_strains(edges, x); }

std::unique_ptr<TetrahedronSystem> tetrahedron_system(const Scene& scene) {
  auto system = std::make_unique<TetrahedronSystem>();
  const BodySpec& body = scene.bodies.front();
  const Mesh mesh = make_mesh(body.shape);
  set_start(scene, mesh, *system);
  const ConstraintSpec& spec = body.constraints.front();
  const double E = spec.young_modulus.value(), nu = spec.parameter;
  const double shear = E / (2 * (1 + nu)), lame = E * nu / ((1 + nu) * (1 - 2 * nu));
  system->mu = 4.0 / 3 * shear, system->lambda = lame + 5.0 / 6 * shear;
  for (const Tetrahedron& t : mesh.tetrahedra) {
    const Eigen::Matrix3d D = edges_of(system->start.x, t);
    system->elements.push_back({t, D.inverse(), std::abs(D.determinant()) / 6});
  }
  for (const auto& [i, j] : edges(mesh))
    system->edges.push_back({i, j, 0, (system->start.x.segment<3>(3 * i) - system->start.x.segment<3>(3 * j)).norm()});
  return system;
}

Vector relax_to_rest(const System& system, double tolerance) {
  State state = system.start;
  const double h = 1 / largest_frequency(system, state.x);  // half of the stability limit
  double before = 0;
  constexpr int max_iterations = 2'000'000;
  for (int k = 0; k < max_iterations; ++k) {
    const Vector a = system.accelerations(state.x);
    if (a.cwiseAbs().maxCoeff() < tolerance * system.gravity.norm()) break;
    state.v += h * a;
    const double energy = state.v.squaredNorm();
    if (energy < before) state.v.setZero();
    before = state.v.squaredNorm();
    state.x += h * state.v;
  }
  return state.x;
}

}  // namespace malha::study
