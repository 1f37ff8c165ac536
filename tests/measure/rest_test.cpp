// SPDX-License-Identifier: Apache-2.0
// A scene at rest stays at rest, also without sleep: the displacement of resting contacts from step to step.
#include <gtest/gtest.h>

#include "tests/measure/resting.h"

namespace malha {
namespace {

#ifdef NDEBUG
constexpr int kSteps = 10'000;
#else
constexpr int kSteps = 300;
#endif

BodySpec sheet() {
  BodySpec body = malha::body("sheet", GridShape{{1, 1}, {4, 4}}, {stiff("distance", {"edges", "shear"})});
  body.transform.translate = {-0.5, 0.02, -0.5};
  return body;
}

BodySpec crate() {
  BodySpec body = malha::body("crate", BoxShape{{0.4, 0.4, 0.4}, {{2, 2, 2}}},
                              {stiff("distance", {"edges", "shear"}), stiff("bending", {}, 0.5)});
  body.transform.translate = {0, 0.22, 0};
  return body;
}

class RestingContacts : public testing::TestWithParam<const char*> {};

TEST_P(RestingContacts, OfASheetMoveByLessThanATenThousandthOfTheThickness) {
  for (const Precision precision : {Precision::Float, Precision::Double})
    for (const bool solid : {false, true}) {
      Scene scene = resting(sheet(), GetParam(), precision, solid);
      if (scene.solver.type == "desbrun") scene.solver.substeps = 2;
      const Jitter found = jitter(scene, 5, kSteps / (solid ? 10 : 1));
      EXPECT_EQ(found.contacts, 25u);
      EXPECT_LT(found.touching, 1e-4 * 0.005) << solid;  // 1e-13 when it was measured
    }
}

/// Particles that do not touch the ground move by some tens of the spacings of float at 0.4 m, and in double hardly at
/// all.
TEST(RestingContactsOfACrate, MoveByLessThanATenThousandthOfTheThickness) {
  const Jitter coarse = jitter(resting(crate(), "pbd", Precision::Float, false), 5, kSteps);
  EXPECT_EQ(coarse.contacts, 9u);
  EXPECT_LT(coarse.touching, 1e-4 * 0.005);  // 0 when it was measured
  EXPECT_LT(coarse.all, 100 * 0x1p-25);
  const Jitter fine = jitter(resting(crate(), "pbd", Precision::Double, false), 10, 100);
  EXPECT_LT(fine.all, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Under, RestingContacts, testing::Values("pbd", "desbrun"));

}  // namespace
}  // namespace malha
