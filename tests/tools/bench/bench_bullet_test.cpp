// SPDX-License-Identifier: Apache-2.0
// The benchmark's cloth in Bullet is the same as in malha. Built only if Bullet was found.
#include <BulletSoftBody/btSoftBody.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tools/bench/peers/bullet.h"

namespace malha::bench {
namespace {

class BulletClothes : public testing::TestWithParam<bool> {
 protected:
  BulletClothes() : which_(GetParam() ? grid_case(17) : irregular_case(400)), scene_(hanging_cloth(which_, {1, 10})) {}
  Case which_;
  Scene scene_;
};
INSTANTIATE_TEST_SUITE_P(Both, BulletClothes, testing::Bool(),
                         [](const auto& now) { return now.param ? "Grid" : "Irregular"; });

TEST_P(BulletClothes, HaveThePointsAndLinksOfMalha) {
  const Cloth cloth = cloth_of(scene_);
  BulletCloth bullet(cloth, scene_.gravity, 10);
  bullet.step(scene_.solver.dt);  // Bullet sets its rest lengths in the first step
  const btSoftBody& body = bullet.body();
  ASSERT_EQ(body.m_nodes.size(), static_cast<int>(cloth.points.size()));
  ASSERT_EQ(body.m_links.size(), static_cast<int>(cloth.links.size()));
  EXPECT_EQ(body.m_faces.size(), 0);
  for (int i = 0; i < body.m_nodes.size(); ++i)
    EXPECT_EQ(body.m_nodes[i].m_im, cloth.pinned[i] ? 0.0f : 1 / static_cast<float>(cloth.mass[i]));
  for (int k = 0; k < body.m_links.size(); ++k) {
    const auto& link = body.m_links[k];
    const auto [a, b] = cloth.links[k];
    EXPECT_EQ(link.m_n[0] - &body.m_nodes[0], a);
    EXPECT_EQ(link.m_n[1] - &body.m_nodes[0], b);
    EXPECT_NEAR(link.m_rl, std::hypot(cloth.points[a][0] - cloth.points[b][0], cloth.points[a][2] - cloth.points[b][2]),
                1e-6);  // float coordinates up to 2
  }
}

TEST_P(BulletClothes, FallFreelyWithoutPins) {
  Cloth cloth = cloth_of(scene_);
  cloth.pinned.assign(cloth.pinned.size(), false);
  BulletCloth bullet(cloth, scene_.gravity, 10);
  const double dt = scene_.solver.dt;
  double momentum = 0;
  for (int step = 0; step < 10; ++step) bullet.step(dt);
  for (std::size_t i = 0; i < cloth.mass.size(); ++i) {
    const btSoftBody::Node& node = bullet.body().m_nodes[static_cast<int>(i)];
    momentum += node.m_v.y() / double(node.m_im);
  }
  EXPECT_NEAR(momentum, -9.81 * 10 * dt,
              1e-3);  // kg m/s: 1 kg, no damping; rounding of float positions over dt is 1e-5
}

}  // namespace
}  // namespace malha::bench
