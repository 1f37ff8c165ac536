// SPDX-License-Identifier: Apache-2.0
// Looks: where particles touch the environment. With meshes of its own to ask, so that the solver's stay as they are.
#pragma once
#include <deque>
#include <optional>
#include <vector>

#include "host/environment/surface.h"
#include "host/model/model.h"

namespace malha {

/// A particle that touches an object of the environment.
struct Touch {
  int particle = -1, object = -1;  // the user's number; in the scene's environment
  Vec3 at{}, normal{};             // on the surface (m); unit, outwards: the way in which the object pushes
  double distance = 0;             // m, of the particle from the surface; below 0: behind it
};

/// Of a model with an environment; nothing is built without one.
class Contacts {
 public:
  explicit Contacts(const Model& model, int threads = 1);

  /// The particles at x (m, the user's order) that are no farther from an object at `time` (s) than its thickness and
  /// `slack` of it more: what lies still lies at the thickness, but for rounding and for what its neighbours pull. What
  /// is behind the surface touches as far as that, too. By object, then by particle.
  std::vector<Touch> operator()(const std::vector<Vec3>& x, double time, double slack = 0.1) const;

 private:
  struct Object {
    Object(const Device& device, const EnvironmentMesh& mesh) : surface(device, mesh.mesh), spec(mesh.spec) {}
    Surface surface;
    EnvironmentSpec spec;
  };
  std::optional<Device> device_;
  std::deque<Object> objects_;  // they do not move
  int threads_;
};

}  // namespace malha
