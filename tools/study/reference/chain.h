// SPDX-License-Identifier: Apache-2.0
// Exact motion of an inextensible cloth that hangs by a row: its rows move as the joints of a chain of rigid links.
#pragma once
#include <array>
#include <vector>

namespace malha::study {

/// An inextensible chain of `length` m and equal links, pinned at its first joint and released from the horizontal. All
/// joints have equal masses except the last, which has half of it. Integrated by the leapfrog method with exact
/// constraints (SHAKE: Ryckaert, Ciccotti & Berendsen 1977), which Newton's method solves together in each step, in
/// double.
class ReferenceChain {
 public:
  using Position = std::array<double, 2>;  // m, upwards and away from the pinned joint

  ReferenceChain(int links, double length, double gravity);
  void step(double h);
  const std::vector<Position>& joints() const { return x_; }
  double kinetic() const;    // J, for a total mass of 1 kg, at the middle of the last step
  double potential() const;  // J

 private:
  double link_, gravity_, mass_;
  std::vector<double> w_;  // 1/kg
  std::vector<Position> x_, v_;
};

}  // namespace malha::study
