// SPDX-License-Identifier: Apache-2.0
#include "tools/study/reference/system.h"

#include <cmath>

#include "host/mesh/generate.h"
#include "host/mesh/topology.h"
#include "host/model/model.h"
#include "host/model/pins.h"

namespace malha::study {

Vector System::accelerations(const Vector& x) const {
  Vector a = Vector::Zero(x.size());
  add_forces(x, a);
  for (int i = 0; i < count(); ++i)
    if (pinned[i])
      a.segment<3>(3 * i).setZero();
    else
      a.segment<3>(3 * i) = a.segment<3>(3 * i) / mass[i] + gravity;
  return a;
}

double SpringSystem::elastic_energy(const Vector& x) const {
  double sum = 0;
  for (const Spring& s : springs) {
    const double stretch = (x.segment<3>(3 * s.i) - x.segment<3>(3 * s.j)).norm() - s.rest;
    sum += s.stiffness * stretch * stretch / 2;
  }
  for (const BendingElement& b : bending)
    sum += b.stiffness / 2 * (x.segment<3>(3 * b.i) - 2 * x.segment<3>(3 * b.j) + x.segment<3>(3 * b.k)).squaredNorm();
  return sum;
}

void SpringSystem::add_forces(const Vector& x, Vector& f) const {
  for (const Spring& s : springs) {
    const Eigen::Vector3d d = x.segment<3>(3 * s.i) - x.segment<3>(3 * s.j);
    const Eigen::Vector3d pull = s.stiffness * (1 - s.rest / d.norm()) * d;
    f.segment<3>(3 * s.i) -= pull;
    f.segment<3>(3 * s.j) += pull;
  }
  for (const BendingElement& b : bending) {
    const Eigen::Vector3d push =
        b.stiffness * (x.segment<3>(3 * b.i) - 2 * x.segment<3>(3 * b.j) + x.segment<3>(3 * b.k));
    f.segment<3>(3 * b.i) -= push;
    f.segment<3>(3 * b.j) += 2 * push;
    f.segment<3>(3 * b.k) -= push;
  }
}

Vector SpringSystem::strains(const Vector& x) const { return edge_strains(springs, x); }

Vector edge_strains(const std::vector<Spring>& edges, const Vector& x) {
  Vector strain(edges.size());
  for (std::size_t s = 0; s < edges.size(); ++s) {
    const double length = (x.segment<3>(3 * edges[s].i) - x.segment<3>(3 * edges[s].j)).norm();
    strain[static_cast<int>(s)] = length / edges[s].rest - 1;
  }
  return strain;
}

void set_start(const Scene& scene, const Mesh& mesh, System& system) {
  const BodySpec& body = scene.bodies.front();
  system.pinned = find_boundary_conditions(scene, 0, mesh).pinned;
  system.gravity = Eigen::Vector3d::Map(scene.gravity.data());
  const Model model = build_model(scene);
  Mesh placed = mesh;
  std::vector<Vec3> velocities(model.x.size());
  for (std::size_t i = 0; i < model.x.size(); ++i) {
    placed.points[model.user_index[i]] = model.x[i];
    velocities[model.user_index[i]] = model.v[i];
  }
  system.start = {flat(placed.points), flat(velocities)};
  system.mass = body.mass ? masses_by_total(placed, *body.mass) : masses_by_density(placed, body.density.value());
  for (int i = 0; i < system.count(); ++i)
    if (system.pinned[i]) system.start.v.segment<3>(3 * i).setZero();
}

namespace {

/// Bending of a flexural rigidity D (N m): each row and column bends as a beam of its share of the width. What is
/// pinned does not bend, so that at the edge of a clamp half a cell has the bending of a whole one.
void add_bending(const GridShape& grid, double D, SpringSystem& system) {
  const std::array<int, 2> n = grid.cells, stride{1, n[0] + 1};
  for (const int axis : {0, 1}) {
    const int other = 1 - axis, next = stride[axis];
    const double l = grid.size[axis] / n[axis], width = grid.size[other] / n[other];
    for (int i = 1; i < n[axis]; ++i)
      for (int j = 0; j <= n[other]; ++j) {
        const int at = i * next + j * stride[other];
        const bool is_clamp = system.pinned[at] && (system.pinned[at - next] || system.pinned[at + next]);
        const double share = width / (j % n[other] == 0 ? 2 : 1);
        system.bending.push_back({at - next, at, at + next, (is_clamp ? 2 : 1) * D * share / (l * l * l)});
      }
  }
}

}  // namespace

std::unique_ptr<SpringSystem> spring_system(const Scene& scene) {
  auto system = std::make_unique<SpringSystem>();
  const BodySpec& body = scene.bodies.front();
  const Mesh mesh = make_mesh(body.shape);
  set_start(scene, mesh, *system);
  const Vector& x = system->start.x;
  for (const ConstraintSpec& spec : body.constraints) {
    if (spec.rigidity) add_bending(std::get<GridShape>(body.shape), *spec.rigidity, *system);
    for (const std::string& on : spec.elements)
      for (const auto& [i, j] : on == "shear" ? shear(mesh) : edges(mesh)) {
        if (system->pinned[i] && system->pinned[j]) continue;
        const double length = (x.segment<3>(3 * i) - x.segment<3>(3 * j)).norm();
        system->springs.push_back({i, j, 1 / spec.compliance.value(), spec.parameter * length});
      }
  }
  return system;
}

double rms_distance(const Vector& a, const Vector& b) {
  return (a - b).norm() / std::sqrt(static_cast<double>(a.size()) / 3);
}

Vector flat(const std::vector<Vec3>& points) {
  Vector a(3 * static_cast<int>(points.size()));
  for (int k = 0; k < a.size(); ++k) a[k] = points[k / 3][k % 3];
  return a;
}

std::vector<double> numbers_of(const Vector& a) { return {a.data(), a.data() + a.size()}; }
Vector vector_of(const std::vector<double>& numbers) {
  return Vector::Map(numbers.data(), static_cast<int>(numbers.size()));
}

ConservedQuantities conserved_quantities(const System& system, const State& state) {
  ConservedQuantities sum{0, 0, system.elastic_energy(state.x), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  for (int i = 0; i < system.count(); ++i) {
    if (system.pinned[i]) continue;
    const Eigen::Vector3d x = state.x.segment<3>(3 * i), p = system.mass[i] * state.v.segment<3>(3 * i);
    sum.kinetic += p.squaredNorm() / system.mass[i] / 2;
    sum.potential -= system.mass[i] * system.gravity.dot(x);
    sum.momentum += p;
    sum.angular_momentum += x.cross(p);
  }
  return sum;
}

double largest_frequency(const System& system, const Vector& x) {
  Vector weight(x.size());  // in sqrt(m) x the matrix is symmetric, and its powers converge to the largest eigenvalue
  for (int k = 0; k < weight.size(); ++k) weight[k] = system.pinned[k / 3] ? 0 : 1 / std::sqrt(system.mass[k / 3]);
  Vector direction(x.size());
  for (int k = 0; k < direction.size(); ++k) direction[k] = std::sin(1 + 7.3 * k) * (weight[k] > 0);
  double squared = 0;
  const double size = 1e-6 * x.cwiseAbs().maxCoeff();  // m: small compared with an edge, large compared with rounding
  constexpr int turns = 300;
  for (int turn = 0; turn < turns; ++turn) {
    direction.normalize();
    Vector move = weight.cwiseProduct(direction);
    const double scale = size / move.cwiseAbs().maxCoeff();
    move *= scale;
    const Vector turned = (system.accelerations(x - move) - system.accelerations(x + move)) / (2 * scale);
    direction =
        turned.cwiseQuotient(weight.cwiseMax(1e-300)).cwiseProduct((weight.array() > 0).cast<double>().matrix());
    squared = direction.norm();
  }
  return std::sqrt(squared);
}

}  // namespace malha::study
