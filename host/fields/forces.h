// SPDX-License-Identifier: Apache-2.0
// Visual field of the forces of bodies on their pins.
#pragma once
#include <string>
#include <vector>

#include "host/fields/of_model.h"
#include "host/model/model.h"
#include "malha/mesh.h"

namespace malha {

struct PinForce {
  int particle = -1;  // index in the user's order
  Vec3 force{};       // N, of the constraints on the pin
};

/// -grad U at each pin, of the constraints that have an energy U: springs, those with a compliance, materials, pressure
/// with a compliance. Constraints without compliance, and those too stiff for their substeps, are left out, because the
/// forces of their projections depend on the number and order of iterations. A constraint is too stiff if sum w |grad
/// C|^2 h^2 / compliance > 0.1 (h: a substep, s), which is about the relative error of such a force. At rest the forces
/// on all pins add up to the weight of the particles that are not pinned. Attachments, handles and contacts are left
/// out, too.
class PinForces {
 public:
  explicit PinForces(const Model& model);
  /// Returns whether any pin has a force that can be computed.
  bool any() const { return !pins_.empty(); }
  /// Returns the number of constraints at pins that are left out.
  std::size_t left_out() const { return left_out_; }
  /// Returns the forces at x (m, the user's order) and `time` (s), by particle, on pins that are not released yet.
  /// Throws std::invalid_argument for another number of particles.
  std::vector<PinForce> operator()(const std::vector<Vec3>& x, double time) const;

 private:
  struct Pin {
    int particle;
    double release_time;  // s
  };
  struct Set {
    std::string type;
    std::vector<int> particles;
    std::vector<double> rest;       // rest values, Kind::rest_values a constraint
    std::vector<double> stiffness;  // 1 / compliance of each constraint
  };
  struct PressureForce {
    ClosedSurface surface;
    double stiffness;  // N/m^5
  };
  void add(const Model& model, const ConstraintSet& set, const std::vector<double>& release_time);
  void add(const Model& model, const SpringSet& set, const std::vector<double>& release_time);
  void add(const Model& model, const PressureSet& set, const std::vector<double>& release_time);

  std::size_t particles_, left_out_ = 0;
  std::vector<Pin> pins_;
  std::vector<Set> sets_;
  std::vector<PressureForce> pressures_;
};

}  // namespace malha
