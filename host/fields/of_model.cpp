// SPDX-License-Identifier: Apache-2.0
#include "host/fields/of_model.h"

#include <stdexcept>
#include <string>

namespace malha {

std::vector<int> to_user_indices(const Model& model, const int* particles, std::size_t count) {
  std::vector<int> user;
  user.reserve(count);
  for (std::size_t j = 0; j < count; ++j) user.push_back(model.user_index[particles[j]]);
  return user;
}

void require_particles(std::size_t found, std::size_t allowed) {
  if (found != allowed)
    throw std::invalid_argument("a visual field: found " + std::to_string(found) + " particles; allowed: the " +
                                std::to_string(allowed) + " that it was made for");
}

ClosedSurface::ClosedSurface(const Model& model, const PressureSet& set)
    : particles(to_user_indices(model, set.particles.data(), set.particles.size())) {
  std::vector<int> place(model.x.size(), -1);
  for (std::size_t i = 0; i < set.particles.size(); ++i) place[set.particles[i]] = static_cast<int>(i);
  const std::vector<Vec3>& X = model.at_rest(set);
  const Vector3<double> o = vector(X[set.particles[0]]);
  for (const Triangle& t : set.triangles) {
    triangles.push_back({place[t[0]], place[t[1]], place[t[2]]});
    target += dot(vector(X[t[0]]) - o, cross(vector(X[t[1]]) - o, vector(X[t[2]]) - o)) / 6;
  }
  target *= set.volume_ratio;
}

double ClosedSurface::evaluate(const std::vector<Vec3>& x, std::vector<Vector3<double>>& gradient) const {
  gradient.assign(particles.size(), {0, 0, 0});
  std::vector<Vector3<double>> p;
  for (const int i : particles) p.push_back(vector(x[i]) - vector(x[particles[0]]));
  double volume = 0;
  for (const auto& [a, b, c] : triangles) {
    volume += dot(p[a], cross(p[b], p[c])) / 6;
    gradient[a] = gradient[a] + cross(p[b], p[c]), gradient[b] = gradient[b] + cross(p[c], p[a]);
    gradient[c] = gradient[c] + cross(p[a], p[b]);
  }
  for (auto& g : gradient) g = g * (1.0 / 6);
  return volume - target;
}

}  // namespace malha
