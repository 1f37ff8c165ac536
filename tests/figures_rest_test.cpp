// Figures of scenes/accuracy.md of what should rest, and of momenta that should stay.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tests/irregular_mesh.h"
#include "tests/resting.h"
#include "tests/support.h"

namespace malha {
namespace {

const char* precision_name(Precision precision) { return precision == Precision::Float ? "float" : "double"; }

BodySpec sheet_of_289(const ConstraintSpec& edges) {
  BodySpec sheet = body("sheet", GridShape{{1, 1}, {16, 16}}, {edges});
  sheet.transform.translate = {-0.5, 0.02, -0.5};
  return sheet;
}
BodySpec box_of_98() {
  BodySpec box = body("box", BoxShape{{0.4, 0.4, 0.4}, {4, 4, 4}},
                      {stiff("distance", {"edges", "shear"}), stiff("bending", {}, 0.5)});
  box.transform.translate = {0, 0.22, 0};
  return box;
}

// A thousandth of the thickness of 5 mm a step would be motion that one sees.
constexpr double kVisible = 5e-6;
constexpr int kLooks = 1000;  // steps

TEST(Figures, DISABLED_RestOnTheGround) {
  for (const Precision precision : {Precision::Float, Precision::Double}) {
    for (const char* method : {"pbd", "desbrun"})
      for (const bool solid : {false, true}) {
        const BodySpec sheet = sheet_of_289(stiff("distance", {"edges", "shear"}));
        const Jitter moves = jitter(resting(sheet, method, precision, solid), 10, kLooks);
        std::printf("sheet of 289 particles on a %s by %s in %s: %.0e m a step\n", solid ? "solid" : "plane", method,
                    precision_name(precision), moves.all);
        EXPECT_LT(moves.all, kVisible);
      }
    const Jitter box = jitter(resting(box_of_98(), "pbd", precision, false), 10, kLooks);
    std::printf("box of 98 particles in %s: %.0e m a step of what touches the ground, %.0e m of all\n",
                precision_name(precision), box.touching, box.all);
    EXPECT_LT(box.all, kVisible);
    const BodySpec soft = sheet_of_289(compliant("distance", 1e-3, {"edges", "shear"}));
    const Jitter springs = jitter(resting(soft, "pbd", precision, false), 60, kLooks);
    std::printf("sheet of springs after a minute in %s: %.0e m a step\n", precision_name(precision), springs.all);
    EXPECT_LT(springs.all, kVisible);
  }
}

// A torque that nothing exerts is small beside the weight, and the corrector takes it away.
TEST(Figures, DISABLED_ABoxOnSmoothGround) {
  for (const bool corrects : {false, true}) {
    Scene scene = resting(box_of_98(), "pbd", Precision::Double, false);
    scene.environment[0].friction = 0, scene.solver.keeps_momenta = corrects;
    const double speed = after(scene, 100).measure().speed_max;
    std::printf("a box on smooth ground, %s corrector: %.1e m/s after 100 s\n", corrects ? "with its" : "without",
                speed);
    EXPECT_LT(speed, corrects ? 1e-4 : 0.1);
  }
}

// Air brakes them as a swing of a metre needs it: after a minute nothing is left but rounding, and what constraints
// that contradict each other made of it.
TEST(Figures, DISABLED_PinnedSheetsWithBending) {
  const TemporaryFolder folder;
  const MeshFile irregular{folder.write("sheet.obj", irregular_obj(1, 1, 16, 16, 0.3, 5))};
  for (const bool grid : {true, false})
    for (const double air : {0.0, 6.0 / 289})
      for (const std::string kind : {"bending", "isometric_bending", "plate"}) {
        BodySpec sheet =
            body("sheet", GridShape{{1, 1}, {16, 16}}, {stiff("distance", {"edges", "shear"}), stiff(kind)});
        if (!grid) sheet.shape = irregular, sheet.constraints[0].on = {"edges"};
        sheet.constraints[1].rigidity = 0.01;
        if (kind == "plate") sheet.constraints[1].parameter = 0;
        sheet.pins = {ListPin{{0, 16}}};
        Scene scene = scene_of({sheet}, kEarth, 1.0 / 60, 20, Precision::Double);
        if (air > 0) scene.wind = Wind{{0, 0, 0}, air};
        const double speed = after(scene, 60).measure().speed_max;
        std::printf("%s, %-18s %s air: the fastest particle %.1e m/s after a minute\n", grid ? "grid" : "irregular",
                    kind.c_str(), air > 0 ? "with" : "without", speed);
        if (air > 0) {
          EXPECT_LT(speed, 1e-6) << kind;
        }
      }
}

/// A sphere at rest whose pressure wants 1.2 times its volume, without gravity.
double turns_from_rest(const ConstraintSpec& edges, int substeps, double seconds) {
  BodySpec sphere = body("sphere", SphereShape{0.3, 2}, {edges, stiff("pressure", {}, 1, 1.2)});
  sphere.mass = 1.3;
  return after(scene_of({sphere}, {}, 1.0 / 60, substeps), seconds).measure().speed_max;
}

TEST(Figures, DISABLED_RotationFromRest) {
  const ConstraintSpec hard = stiff("distance", {"edges"}), firm = compliant("distance", 1e-4, {"edges"}),
                       soft = compliant("distance", 0.01, {"edges"});
  double stiffest = 0, softest = 0;
  for (const int substeps : {10, 40}) {
    stiffest = turns_from_rest(hard, substeps, 5), softest = turns_from_rest(soft, substeps, 20);
    std::printf(
        "%d substeps: stiff edges %.2g m/s after 5 s and %.2g after 20 s; after 20 s of 1e-4 m/N %.2g m/s, of "
        "0.01 m/N %.2g m/s\n",
        substeps, stiffest, turns_from_rest(hard, substeps, 20), turns_from_rest(firm, substeps, 20), softest);
  }
  EXPECT_GT(stiffest, 1) << "or the page warns for nothing";
  EXPECT_LT(softest, 0.05) << "what is met in a substep gives forces at right angles to no arm";
}

// Rounding is a random walk, so that the direction of flight alone changes what comes of it by a factor of ten; angular
// momentum falls as by backward Euler.
TEST(Figures, DISABLED_MomentaAfterAMinute) {
  for (const Precision precision : {Precision::Float, Precision::Double})
    for (const bool stiff_edges : {false, true})
      for (const double far : {0.1, 20.0, 500.0}) {
        BodySpec body = tumbling_ellipsoid(1, {compliant("distance", 1e-6, {"edges"}), compliant("bending", 0.1)});
        if (stiff_edges) body.constraints = {stiff("distance", {"edges"}), compliant("bending", 10)};
        body.transform.translate = {far, 0.3, -0.2};
        body.spin = {0, 1.6, 5.4};
        double least = 1e9, most = 0;
        for (const Vec3& way : {Vec3{0.3, 0, 0}, {0, 0.3, 0}, {0, 0, 0.3}, {-0.3, 0, 0}, {0, -0.3, 0}, {0, 0, -0.3}}) {
          body.velocity = way;
          const Scene scene = scene_of({body}, {}, 1.0 / 60, 20, precision);
          const Vec3 start = Simulation(scene, {.threads = 1}).measure().momentum,
                     end = after(scene, 60).measure().momentum;
          const double changed = length(end - start) / length(start);
          least = std::min(least, changed), most = std::max(most, changed);
        }
        std::printf("%-6s %s edges, at %5.1f m: linear momentum changed by %.1e to %.1e of itself\n",
                    precision_name(precision), stiff_edges ? "stiff" : "1e-6 m/N", far, least, most);
        EXPECT_LT(most, precision == Precision::Double ? 1e-6 : far < 100 ? 4 : 30);
      }
  BodySpec body = tumbling_ellipsoid(1, {compliant("distance", 1e-6, {"edges"}), compliant("bending", 0.1)});
  body.transform.translate = body.velocity = {}, body.spin = {0, 0, 5.4};
  for (const int substeps : {20, 80}) {
    const Scene scene = scene_of({body}, {}, 1.0 / 60, substeps);
    const double had = length(Simulation(scene, {.threads = 1}).measure().angular_momentum),
                 has = length(after(scene, 60).measure().angular_momentum);
    std::printf("%d substeps at 5.4 rad/s: %.0f %% of the angular momentum is lost in a minute\n", substeps,
                100 * (1 - has / had));
    EXPECT_LT(has, had);
    EXPECT_GT(has, 0.2 * had);
  }
}

}  // namespace
}  // namespace malha
