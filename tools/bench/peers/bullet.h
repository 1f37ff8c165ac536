// SPDX-License-Identifier: Apache-2.0
// The peer that everyone can install, where the build found it: the cloth as a soft body of Bullet (btSoftBody), links
// only.
#pragma once
#include <memory>
#include <string>

#include "tools/bench/cloth.h"

class btSoftBody;
class btVector3;

namespace malha::bench {

btVector3 in_bullet(const Vec3& a);

/// Gives an empty body the cloth's particles and its links, of full stiffness, as long as they are now. No collisions,
/// no damping; `iterations`: projections of each link in a step (Bullet's piterations).
void add_cloth(btSoftBody& body, const Cloth& cloth, int iterations);

/// No collisions, no damping, no bending, no wind; links of full stiffness. One thread: Bullet has no other way.
class BulletCloth {
 public:
  /// `iterations`: projections of each link in a step (Bullet's piterations). `gravity` in m/s^2.
  BulletCloth(const Cloth& cloth, const Vec3& gravity, int iterations);
  ~BulletCloth();
  BulletCloth(const BulletCloth&) = delete;
  BulletCloth& operator=(const BulletCloth&) = delete;

  void step(double dt);                 // s
  std::vector<Vec3> positions() const;  // m
  const btSoftBody& body() const;       // to look closer

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// "3.24"; empty: it was not there when malha was built.
std::string bullet_version();

}  // namespace malha::bench
