// SPDX-License-Identifier: Apache-2.0
// The true motion of a cloth that hangs by a row: nothing in it stretches, so that each row goes as a link of a chain.
#pragma once
#include <array>
#include <vector>

namespace malha::study {

/// An inextensible chain of `length` m, of links as long as each other, held at its first joint and let go from the
/// level: joints weigh alike but the last, which has half a link. By the leapfrog method with exact constraints (SHAKE:
/// Ryckaert, Ciccotti & Berendsen 1977), all of a step's solved at once by Newton's method. Double.
class ReferenceChain {
 public:
  using Place = std::array<double, 2>;  // m, up and away from the held joint

  ReferenceChain(int links, double length, double gravity);
  void step(double h);
  const std::vector<Place>& joints() const { return x_; }
  double kinetic() const;    // J, of 1 kg in all; at the middle of the last step
  double potential() const;  // J
  /// At a distance along the chain, m.
  Place at(double along) const;

 private:
  double link_, gravity_, mass_;
  std::vector<double> w_;  // 1/kg
  std::vector<Place> x_, v_;
};

}  // namespace malha::study
