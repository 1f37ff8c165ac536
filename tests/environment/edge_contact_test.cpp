// SPDX-License-Identifier: Apache-2.0
// Contacts between deformable bodies: their division planes, constraint and gradient.
#include "kernels/environment/edge_contact.h"

#include <gtest/gtest.h>

#include <cmath>

#include "host/base/point_array.h"
#include "tests/numbers.h"

namespace malha {
namespace {

// The division planes of a pair are as far apart as its closest points. Where their normal was tilted, as one from
// differences in float was by 1e-5, the far ends of the primitives could come nearer in every substep: a cloth that was
// pressed together crept through itself in 200 of them.
TEST(EdgeContact, HasPlanesThatSeparateWhatIsAThousandthOfItsSizeApart) {
  Random random(1);
  for (int trial = 0; trial < 1000; ++trial) {
    // Two edges of some 3 cm across each other, 30 micrometres apart, a third of a metre from the origin.
    const Vector3<double> o = random.in_cube(0.3), a = random.in_cube(0.03), b = random.in_cube(0.03);
    const Vector3<double> across = cross(a, b);
    if (norm(across) < 0.3 * norm(a) * norm(b)) continue;
    const Vector3<double> up = across * (3e-5 / norm(across));
    std::vector<Vec3> x;
    for (const Vector3<double>& at : {o - a * 0.4, o + a * 0.6, o + up - b * 0.3, o + up + b * 0.7})
      x.push_back({at.x, at.y, at.z});
    ScatteredArray<Serial, float> points(x), still(4);
    points.upload_fourth(std::vector<float>(4, INFINITY));
    std::vector<Box<float>> boxes(4);
    const ParticleBounds<float> bounds{points.points(), still.points(), 1e-3f, boxes.data()};
    for (int i = 0; i < 4; ++i) ComputeParticleBounds<float>{bounds}(i);
    const Candidate pair{{~0, 1, 2, 3}};
    EdgeContact<float> contact;
    ASSERT_TRUE((EvaluateCandidate<float>{&pair, bounds, {1e-3f, 0.1f}}(pair, contact)));
    // Along the normal as it is stored: every end of the one side is above every end of the other by the gap.
    const std::vector<Vec3> stored = points.download();
    double low = INFINITY, high = -INFINITY;
    for (int j = 0; j < 4; ++j) {
      const Vector3<double> from{stored[j][0] - stored[0][0], stored[j][1] - stored[0][1], stored[j][2] - stored[0][2]};
      const double at = dot(to_double(contact.n), from);
      j < 2 ? low = std::min(low, at) : high = std::max(high, at);
    }
    const Vector3<double> p{stored[2][0] - stored[0][0], stored[2][1] - stored[0][1], stored[2][2] - stored[0][2]};
    const double distance = std::abs(dot(to_double(contact.n), p));
    EXPECT_NEAR(contact.gap, low - high, 1e-9);
    // A normal rounded to float leans by 6e-8, which over 6 cm is 4e-9 m.
    EXPECT_NEAR(contact.gap, distance, 1e-8);
  }
}

/// A contact of the pair, whose primitives belong to two bodies, at any position.
EdgeContact<double> contact_of(const Candidate& pair, const std::vector<Vec3>& x) {
  ScatteredArray<Serial, double> points(x), still(4);
  points.upload_fourth(std::vector<double>(4, INFINITY));
  std::vector<Box<double>> boxes(4);
  const ParticleBounds<double> bounds{points.points(), still.points(), 10, boxes.data()};
  EdgeContact<double> contact;
  EXPECT_TRUE((EvaluateCandidate<double>{&pair, bounds, {10, 0.1}}(pair, contact)));
  return contact;
}

// C = distance of the closest points - thickness. Where they slide along the primitives, C does not change to first
// order, so that its gradient is the weight of each particle times the normal: inside, on edges and at corners alike.
TEST(EdgeContact, PushesAlongTheGradientOfTheDistance) {
  Random random(2);
  constexpr double kStep = 1e-6;
  for (const Candidate& pair : {Candidate{{0, 1, 2, 3}}, Candidate{{~0, 1, 2, 3}}})
    for (int trial = 0; trial < 200; ++trial) {
      std::vector<Vec3> x;
      for (int j = 0; j < 4; ++j) {
        const Vector3<double> at = random.in_cube();
        x.push_back({at.x, at.y, at.z});
      }
      // Only the thickness lies between the closest points' weights and n: distance = thickness - bias / recovery.
      const auto distance = [&](const std::vector<Vec3>& at) { return 10 - contact_of(pair, at).bias / 0.1; };
      const EdgeContact<double> contact = contact_of(pair, x);
      if (distance(x) < 0.05) continue;  // curvature 1 / distance: the difference below leaves an error of 1e-9
      for (int j = 0; j < 4; ++j)
        for (int k = 0; k < 3; ++k) {
          std::vector<Vec3> before = x, after = x;
          before[j][k] -= kStep, after[j][k] += kStep;
          const double slope = (distance(after) - distance(before)) / (2 * kStep);
          const double n[] = {contact.n.x, contact.n.y, contact.n.z};
          // Rounding: the distance is computed from a thickness of 10 m over 0.1, 1e-14 / 1e-6. Where the closest
          // feature changes (from a face to its edge), the slope of the distance is continuous, but the second
          // derivative is not.
          EXPECT_NEAR(slope, contact.weight[j] * n[k], 2e-5) << trial << ": " << j << ", " << k;
        }
    }
}

}  // namespace
}  // namespace malha
