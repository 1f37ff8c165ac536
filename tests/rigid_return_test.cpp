// What was held gets both momenta back by a motion as one body.
#include "host/collision/rigid_return.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/numbers.h"

namespace malha {
namespace {

struct Cloud {
  std::vector<Vec4<double>> x;  // w: 1/kg
  std::vector<Vector3<double>> p;
  std::vector<double> w;
};

RigidSums sums_of(const Cloud& cloud) {
  RigidSums sums;
  const Vector3<double> origin = cloud.x[0].xyz();
  for (std::size_t i = 0; i < cloud.x.size(); ++i) {
    const Vector3<double> a = cloud.x[i].xyz() - origin, b = cloud.p[i] - origin;
    const double m = 1 / cloud.w[i], from[] = {a.x, a.y, a.z}, to[] = {b.x, b.y, b.z};
    sums.mass += m;
    for (int k = 0; k < 3; ++k) {
      sums.x[k] += m * from[k], sums.p[k] += m * to[k];
      for (int j = 0; j < 3; ++j) sums.xp[3 * k + j] += m * from[k] * to[j];
    }
  }
  return sums;
}

Cloud cloud_of(Random& random, bool flat) {
  Cloud cloud;
  for (int i = 0; i < 40; ++i) {
    Vector3<double> x = random.in_cube();
    if (flat) x.y = 0;
    cloud.x.push_back({x.x + 100, x.y, x.z, 0});
    cloud.p.push_back(cloud.x.back().xyz() + random.in_cube(0.1) + Vector3<double>{0.1, -0.2, 0});
    cloud.w.push_back(random(0.5, 2));
  }
  return cloud;
}

/// Sums over particles of m (p - x), and of m p x (p - x) about the world's origin: momenta times the substep.
std::pair<Vector3<double>, Vector3<double>> momenta_of(const Cloud& cloud) {
  Vector3<double> linear{0, 0, 0}, angular{0, 0, 0};
  for (std::size_t i = 0; i < cloud.x.size(); ++i) {
    const Vector3<double> d = (cloud.p[i] - cloud.x[i].xyz()) * (1 / cloud.w[i]);
    linear = linear + d, angular = angular + cross(cloud.p[i], d);
  }
  return {linear, angular};
}

TEST(RigidReturn, GivesBackLinearAndAngularMomentumAndNoStrain) {
  for (const bool flat : {false, true}) {
    Random random(3);
    Cloud cloud = cloud_of(random, flat);
    const auto before = momenta_of(cloud);
    const RigidSums sums = sums_of(cloud);
    for (std::size_t i = 0; i < cloud.p.size(); i += 2) cloud.p[i] = cloud.x[i].xyz();  // half of them are held
    const Vector3<double> side = cloud.p[7] - cloud.p[20];
    const RigidMove move = rigid_return(sums, sums_of(cloud));
    ASSERT_TRUE(move.moves);
    const auto in_R = [](const Vec3& a) { return Vector3<double>{a[0], a[1], a[2]}; };
    const Vector3<double> origin = cloud.x[0].xyz();
    for (Vector3<double>& p : cloud.p) {
      const Vector3<double> r = p - origin - in_R(move.from);
      p = origin + in_R(move.to) +
          Vector3<double>{dot(in_R(move.turn[0]), r), dot(in_R(move.turn[1]), r), dot(in_R(move.turn[2]), r)};
    }
    const auto after = momenta_of(cloud);
    EXPECT_LT(norm(after.first - before.first), 1e-11);
    EXPECT_LT(norm(after.second - before.second), 1e-9) << "100 m from the origin";
    EXPECT_NEAR(norm(cloud.p[7] - cloud.p[20]), norm(side), 1e-13);
  }
}

TEST(RigidReturn, LeavesWhatLostNothing) {
  Random random(4);
  const RigidSums sums = sums_of(cloud_of(random, false));
  EXPECT_FALSE(rigid_return(sums, sums).moves);
  EXPECT_FALSE(rigid_return({}, {}).moves);
}

}  // namespace
}  // namespace malha
