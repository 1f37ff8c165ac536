// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/peers/bullet.h"

#include <BulletSoftBody/btSoftBody.h>

namespace malha::bench {

btVector3 to_bullet(const Vec3& a) { return {btScalar(a[0]), btScalar(a[1]), btScalar(a[2])}; }

namespace {

btSoftBodyWorldInfo world(const Vec3& gravity) {
  btSoftBodyWorldInfo info;
  info.m_gravity = to_bullet(gravity);
  info.air_density = 0;
  return info;
}

}  // namespace

struct BulletCloth::Parts {
  btSoftBodyWorldInfo info;
  btSoftBody body;  // stores a pointer to info

  explicit Parts(const Vec3& gravity) : info(world(gravity)), body(&info) {}
};

void add_cloth(btSoftBody& body, const Cloth& cloth, int iterations) {
  btSoftBody::Material* full = body.appendMaterial();  // before the nodes: each takes the last material
  full->m_kLST = 1;
  for (std::size_t i = 0; i < cloth.points.size(); ++i)
    body.appendNode(to_bullet(cloth.points[i]), cloth.pinned[i] ? 0 : btScalar(cloth.mass[i]));
  body.m_links.reserve(static_cast<int>(cloth.links.size()));
  for (const auto& [a, b] : cloth.links) body.appendLink(a, b, full);
  btSoftBody::Config& config = body.m_cfg;
  config.piterations = iterations;
  config.viterations = config.diterations = config.citerations = 0;
  config.collisions = 0;
  config.kDP = 0;
}

BulletCloth::BulletCloth(const Cloth& cloth, const Vec3& gravity, int iterations)
    : parts_(std::make_unique<Parts>(gravity)) {
  bench::add_cloth(parts_->body, cloth, iterations);
}

BulletCloth::~BulletCloth() = default;

/// Calls what btSoftRigidDynamicsWorld calls for each of its bodies, without collision detection, which malha leaves
/// out here as well.
void BulletCloth::step(double dt) {
  btSoftBody& body = parts_->body;
  body.predictMotion(btScalar(dt));
  body.solveConstraints();
  body.integrateMotion();
}

std::vector<Vec3> BulletCloth::positions() const {
  const btSoftBody& body = parts_->body;
  std::vector<Vec3> positions;
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    const btVector3& x = body.m_nodes[i].m_x;
    positions.push_back({x.x(), x.y(), x.z()});
  }
  return positions;
}

const btSoftBody& BulletCloth::body() const { return parts_->body; }

std::string bullet_version() {
  const int version = btGetVersion();
  return std::to_string(version / 100) + "." + std::to_string(version % 100);
}

}  // namespace malha::bench
