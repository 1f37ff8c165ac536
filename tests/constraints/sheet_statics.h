// SPDX-License-Identifier: Apache-2.0
// Static solutions of flat sheets of unequal cells by linear algebra, without substeps.
#pragma once
#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>
#include <cmath>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "host/model/stencils.h"
#include "tests/small_scenes.h"

namespace malha {

/// Quads between grid lines at these coordinates along x and z (m), in the plane y = 0; rows along x come one after the
/// other.
inline MeshDataShape quads_between(const std::vector<double>& x, const std::vector<double>& z) {
  MeshDataShape shape;
  const int across = static_cast<int>(x.size());
  for (const double b : z)
    for (const double a : x) shape.points.push_back({a, 0, b});
  for (int j = 0; j + 1 < static_cast<int>(z.size()); ++j)
    for (int i = 0; i + 1 < across; ++i) {
      const int p = j * across + i;
      shape.faces.push_back({p, p + across, p + across + 1, p + 1});
    }
  return shape;
}

/// Grid lines from 0 to `length`: that many cells, of which the last is `ratio` times as long as the first.
inline std::vector<double> graded(double length, int cells, double ratio = 1) {
  std::vector<double> at{0};
  for (int k = 0; k < cells; ++k) at.push_back(at.back() + (cells > 1 ? std::pow(ratio, double(k) / (cells - 1)) : 1));
  for (double& a : at) a *= length / at.back();
  at[0] = 0;
  return at;
}

/// The triangles of an OBJ file's text.
inline MeshDataShape listed_of_obj(const std::string& text) {
  MeshDataShape shape;
  std::istringstream lines(text);
  for (std::string key; lines >> key;) {
    if (key == "v") {
      Vec3 at;
      lines >> at[0] >> at[1] >> at[2];
      shape.points.push_back(at);
    } else {
      Quad face{0, 0, 0, -1};
      for (int k = 0; k < 3; ++k) lines >> face[k], --face[k];
      shape.faces.push_back(face);
    }
  }
  return shape;
}

/// A term k / 2 (sum c_i y_i)^2 of an energy of the displacements y: its particles with c, and k.
struct LiftedTerm {
  std::vector<std::pair<int, double>> c;
  double k;
};

/// The bending terms of a flat model of Desbrun's method, with the user's numbers of particles.
inline std::vector<LiftedTerm> bending_terms(const Model& model) {
  std::vector<LiftedTerm> terms;
  for_each_stencil(model, [&](const auto& stencil) {
    for (const auto& c : stencil.weights) {
      terms.push_back({{}, 1 / stencil.alpha});
      for (int j = 0; j < stencil.n; ++j) terms.back().c.push_back({model.user_index[stencil.particles[j]], c[j]});
    }
  });
  return terms;
}

inline Model sheet_of_bending(const Shape& shape, const ConstraintSpec& bends, const std::vector<int>& held = {}) {
  BodySpec body;
  body.name = "sheet", body.shape = shape, body.density = 1, body.constraints = {bends};
  if (!held.empty()) body.pins = {ListPin{held}};
  Scene scene = scene_of({body}, {0, 0, 0}, 1.0 / 60);
  scene.solver.type = "desbrun";
  return build_model(scene);
}

/// The energy of the displacements y(x, z).
template <class Lift>
double energy_of_lifts(const Model& model, Lift lift) {
  double energy = 0;
  for (const LiftedTerm& term : bending_terms(model)) {
    double sum = 0;
    for (const auto& [i, c] : term.c) sum += c * lift(model.render_mesh.points[i][0], model.render_mesh.points[i][2]);
    energy += term.k / 2 * sum * sum;
  }
  return energy;
}

/// The static displacement of each particle under a load of 1 N a kilogram, with the particles in `held` fixed.
inline std::vector<double> lifts_by_weight(const Model& model, const std::vector<int>& held) {
  const int n = model.count();
  std::vector<int> unknown(n, 0);
  for (const int i : held) unknown[i] = -1;
  int count = 0;
  for (int& u : unknown)
    if (u == 0) u = count++;
  std::vector<Eigen::Triplet<double>> entries;
  for (const LiftedTerm& term : bending_terms(model))
    for (const auto& [i, a] : term.c)
      for (const auto& [j, b] : term.c)
        if (unknown[i] >= 0 && unknown[j] >= 0) entries.emplace_back(unknown[i], unknown[j], term.k * a * b);
  Eigen::SparseMatrix<double> K(count, count);
  K.setFromTriplets(entries.begin(), entries.end());
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(count);
  for (int s = 0; s < n; ++s)
    if (const int u = unknown[model.user_index[s]]; u >= 0) weight[u] = model.mass[s];
  const Eigen::VectorXd solved = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(K).solve(weight);
  std::vector<double> lifts(n, 0.0);
  for (int i = 0; i < n; ++i)
    if (unknown[i] >= 0) lifts[i] = solved[unknown[i]];
  return lifts;
}

}  // namespace malha
