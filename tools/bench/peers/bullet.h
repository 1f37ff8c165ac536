// SPDX-License-Identifier: Apache-2.0
// Bullet as a peer, if the build found it: the cloth as a soft body (btSoftBody) with links only.
#pragma once
#include <memory>
#include <string>

#include "tools/bench/cloth.h"

class btSoftBody;
class btVector3;

namespace malha::bench {

btVector3 to_bullet(const Vec3& a);

/// Adds the cloth's particles to an empty body, and its links, of full stiffness and their present length. Without
/// collisions and damping. `iterations`: projections of each link in a step (Bullet's piterations).
void add_cloth(btSoftBody& body, const Cloth& cloth, int iterations);

/// A cloth of links of full stiffness, without collisions, damping, bending or wind. Bullet runs it on one thread.
class BulletCloth {
 public:
  /// `iterations`: projections of each link in a step (Bullet's piterations). `gravity` in m/s^2.
  BulletCloth(const Cloth& cloth, const Vec3& gravity, int iterations);
  ~BulletCloth();
  BulletCloth(const BulletCloth&) = delete;
  BulletCloth& operator=(const BulletCloth&) = delete;

  void step(double dt);                 // s
  std::vector<Vec3> positions() const;  // m
  const btSoftBody& body() const;       // for tests

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// "3.24"; empty if it was not installed when malha was built.
std::string bullet_version();

}  // namespace malha::bench
