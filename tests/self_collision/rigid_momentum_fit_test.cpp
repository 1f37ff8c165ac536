// SPDX-License-Identifier: Apache-2.0
// The rigid momentum fit: truncated particles get both momenta back by a rigid motion, as far as they had the energy.
#include "host/self_collision/rigid_momentum_fit.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/numbers.h"

namespace malha {
namespace {

struct HeldCloud {
  std::vector<Vector3<double>> from, to, before, after;  // positions (m) and velocities (m/s)
  std::vector<double> mass;
};

constexpr Vector3<double> kHeldOrigin{100, 0, 0};

TruncationSums sums_of(const HeldCloud& cloud) {
  TruncationSums sums;
  for (std::size_t i = 0; i < cloud.mass.size(); ++i) {
    const double m = cloud.mass[i];
    const Vector3<double> r = cloud.to[i] - kHeldOrigin;
    sums.before.add(m, cloud.from[i] - kHeldOrigin, cloud.before[i]);
    sums.after.add(m, r, cloud.after[i]);
    const double inertia[] = {
        r.y * r.y + r.z * r.z, r.x * r.x + r.z * r.z, r.x * r.x + r.y * r.y, -r.x * r.y, -r.x * r.z, -r.y * r.z};
    for (int k = 0; k < 6; ++k) sums.I[k] += m * inertia[k];
  }
  return sums;
}

/// 40 particles that move together by `common`, of which every second one is truncated to a `part` of its displacement.
HeldCloud held_cloud(Random& random, bool flat, const Vector3<double>& common, double part) {
  HeldCloud cloud;
  for (int i = 0; i < 40; ++i) {
    Vector3<double> x = random.in_cube();
    if (flat) x.y = 0;
    cloud.from.push_back(x + kHeldOrigin);
    cloud.before.push_back(random.in_cube() + common);
    cloud.after.push_back(cloud.before.back() * (i % 2 == 0 ? part : 1));
    cloud.to.push_back(cloud.from.back() + cloud.after.back() * 0.001);
    cloud.mass.push_back(random(0.5, 2));
  }
  return cloud;
}

struct HeldMomenta {
  Vector3<double> linear{0, 0, 0}, spin{0, 0, 0};  // the latter about the centre of mass
  double energy = 0;
};
HeldMomenta momenta_of(const HeldCloud& cloud, const std::vector<Vector3<double>>& x,
                       const std::vector<Vector3<double>>& v) {
  HeldMomenta sums;
  Vector3<double> centre{0, 0, 0};
  double mass = 0;
  for (std::size_t i = 0; i < x.size(); ++i) mass += cloud.mass[i], centre = centre + x[i] * cloud.mass[i];
  for (std::size_t i = 0; i < x.size(); ++i) {
    sums.linear = sums.linear + v[i] * cloud.mass[i];
    sums.spin = sums.spin + cross(x[i] - centre * (1 / mass), v[i]) * cloud.mass[i];
    sums.energy += cloud.mass[i] / 2 * dot(v[i], v[i]);
  }
  return sums;
}

std::vector<Vector3<double>> given_back(const HeldCloud& cloud, const RigidCorrection& gain) {
  std::vector<Vector3<double>> v;
  for (std::size_t i = 0; i < cloud.to.size(); ++i) {
    const Vector3<double> arm = cloud.to[i] - kHeldOrigin - gain.centre;
    v.push_back(cloud.after[i] * gain.kept + gain.velocity + cross(gain.omega, arm));
  }
  return v;
}

TEST(RigidMomentumFit, RestoresBothMomentaAndLeavesTheOtherMotion) {
  for (const bool flat : {false, true}) {
    Random random(3);
    const HeldCloud cloud = held_cloud(random, flat, {0.1, -0.2, 0}, 0);
    const RigidCorrection gain = fit_rigid_momentum(sums_of(cloud));
    EXPECT_EQ(gain.kept, 1);  // what moved at random has lost half of its energy
    const HeldMomenta before = momenta_of(cloud, cloud.from, cloud.before),
                      after = momenta_of(cloud, cloud.to, given_back(cloud, gain));
    EXPECT_LT(norm(after.linear - before.linear), 1e-12);
    EXPECT_LT(norm(after.spin - before.spin), 1e-10) << "100 m from the origin";
    EXPECT_LT(after.energy, before.energy);
  }
}

// In a fast frame truncated particles, which stay in world space, lag behind the others by its speed: more than the
// energy they had.
TEST(RigidMomentumFit, AddsNoEnergy) {
  for (const double speed : {1.0, 10.0, 1000.0}) {
    Random random(5);
    const HeldCloud cloud = held_cloud(random, false, {0, speed, 0}, 0.2);
    const RigidCorrection gain = fit_rigid_momentum(sums_of(cloud));
    const HeldMomenta before = momenta_of(cloud, cloud.from, cloud.before),
                      after = momenta_of(cloud, cloud.to, given_back(cloud, gain));
    if (speed > 1) {
      EXPECT_LT(gain.kept, 1) << speed << " m/s";
    }
    EXPECT_LT(norm(after.linear - before.linear), 1e-12 * (1 + norm(before.linear)));
    EXPECT_LT(norm(after.spin - before.spin), 1e-9 * (1 + norm(before.spin))) << speed << " m/s";
    EXPECT_LT(after.energy, before.energy * (1 + 1e-14)) << speed << " m/s";
  }
}

// Particles that were drawn together rotate faster with the same momentum, like a skater, for which there is no energy.
TEST(RigidMomentumFit, TurnsOnlyAsFastAsEnergyAllows) {
  Random random(7);
  HeldCloud cloud = held_cloud(random, false, {0, 0, 0}, 1);
  for (std::size_t i = 0; i < cloud.to.size(); ++i) {
    const Vector3<double> r = cloud.from[i] - kHeldOrigin;
    cloud.before[i] = cross(Vector3<double>{0, 3, 0}, r), cloud.after[i] = {0, 0, 0};
    cloud.to[i] = kHeldOrigin + r * 0.5;
  }
  const HeldMomenta before = momenta_of(cloud, cloud.from, cloud.before),
                    after = momenta_of(cloud, cloud.to, given_back(cloud, fit_rigid_momentum(sums_of(cloud))));
  EXPECT_LT(norm(after.linear - before.linear), 1e-12 * norm(before.spin));
  EXPECT_LT(after.energy, before.energy * (1 + 1e-12));
  EXPECT_GT(after.energy, before.energy * 0.99) << "as fast as that";
}

TEST(RigidMomentumFit, LeavesWhatLostNothing) {
  Random random(4);
  HeldCloud cloud = held_cloud(random, false, {1, 2, 3}, 1);
  cloud.to = cloud.from;
  const RigidCorrection gain = fit_rigid_momentum(sums_of(cloud));
  EXPECT_NEAR(gain.kept, 1, 1e-14);
  EXPECT_LT(norm(gain.velocity), 1e-14);
  EXPECT_LT(norm(gain.omega), 1e-12);
  EXPECT_EQ(fit_rigid_momentum({}).kept, 1);
}

}  // namespace
}  // namespace malha
