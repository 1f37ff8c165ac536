// SPDX-License-Identifier: Apache-2.0
// Visual field of contacts: the points where particles touch the environment. It queries its own copy of the meshes, so
// that the solver's stay unchanged, and exact shapes themselves.
#pragma once
#include <deque>
#include <optional>
#include <vector>

#include "host/environment/closest_point_index.h"
#include "host/model/model.h"

namespace malha {

/// Contact of a particle with an object of the environment.
struct ContactPoint {
  int particle = -1, object = -1;  // index in the user's order; index in the scene's environment
  Vec3 at{}, normal{};             // point on the surface (m); unit normal in the direction of the contact force
  double distance = 0;             // m, signed distance of the particle from the surface; negative behind it
};

/// Contact queries of a model; nothing is built without an environment.
class Contacts {
 public:
  explicit Contacts(const Model& model, int threads = 1);

  /// Returns the contacts of particles at x (m, the user's order) at `time` (s), sorted by object and particle. A
  /// particle touches an object within (1 + slack) times its thickness on either side of the surface: resting particles
  /// lie at the thickness, except for rounding and the pull of their neighbours. `environment`: the model's, whose
  /// motion the program may have changed.
  std::vector<ContactPoint> operator()(const std::vector<Vec3>& x, const std::vector<EnvironmentMesh>& environment,
                                       double time, double slack = 0.1) const;

 private:
  std::optional<Device> device_;
  std::deque<std::optional<ClosestPointIndex>> surfaces_;  // of objects that are rigid meshes
  int threads_;
};

}  // namespace malha
