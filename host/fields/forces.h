// SPDX-License-Identifier: Apache-2.0
// Looks: what bodies pull their pins with.
#pragma once
#include <string>
#include <vector>

#include "host/fields/of_model.h"
#include "host/model/model.h"
#include "malha/mesh.h"

namespace malha {

struct PinForce {
  int particle = -1;  // the user's number
  Vec3 force{};       // N, of the constraints on the pin
};

/// -grad U at each pin, of the constraints that have an energy U: springs, those with a compliance, materials, pressure
/// with a compliance. Left out are constraints without compliance, and those too stiff for their substeps: what
/// projections give a pin then depends on iterations and on their order. Too stiff: sum w |grad C|^2 h^2 / compliance >
/// 0.1, about the part of itself by which such a force is wrong (h: a substep, s). At rest the forces on all pins add
/// up to the weight of what is not pinned. Attachments, hands and contacts are left out.
class PinForces {
 public:
  explicit PinForces(const Model& model);
  /// Whether a force is known of any pin.
  bool any() const { return !pins_.empty(); }
  /// Constraints at pins that are left out.
  std::size_t left_out() const { return left_out_; }
  /// At x (m, the user's order) and `time` (s), by particle, of pins that are not let go yet. Throws
  /// std::invalid_argument for another number of particles.
  std::vector<PinForce> operator()(const std::vector<Vec3>& x, double time) const;

 private:
  struct Pin {
    int particle;
    double release_time;  // s
  };
  struct Set {
    std::string type;
    std::vector<int> particles;
    std::vector<double> rest;       // as many of each constraint as its kind has numbers
    std::vector<double> stiffness;  // of each: 1 / compliance
  };
  struct Pressed {
    Shell shell;
    double stiffness;  // N/m^5
  };
  void add(const Model& model, const ConstraintSet& set, const std::vector<double>& release_time);
  void add(const Model& model, const SpringSet& set, const std::vector<double>& release_time);
  void add(const Model& model, const PressureSet& set, const std::vector<double>& release_time);

  std::size_t particles_, left_out_ = 0;
  std::vector<Pin> pins_;
  std::vector<Set> sets_;
  std::vector<Pressed> pressed_;
};

}  // namespace malha
