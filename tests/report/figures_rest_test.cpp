// SPDX-License-Identifier: Apache-2.0
// Figures of scenes/accuracy.md on bodies that should rest, and on momenta that should be conserved.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "host/report/failure_boundaries.h"
#include "tests/measure/resting.h"
#include "tests/mesh/irregular_mesh.h"
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
  BodySpec box = body("box", BoxShape{{0.4, 0.4, 0.4}, {{4, 4, 4}}},
                      {stiff("distance", {"edges", "shear"}), stiff("bending", {}, 0.5)});
  box.transform.translate = {0, 0.22, 0};
  return box;
}

// A displacement of a thousandth of the thickness of 5 mm in a step would be visible.
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

// Its projections exert no torque, and the corrector has nothing to correct.
TEST(Figures, DISABLED_ABoxOnSmoothGround) {
  for (const bool corrects : {false, true}) {
    Scene scene = resting(box_of_98(), "pbd", Precision::Double, false);
    scene.environment[0].friction = 0, scene.solver.keeps_momenta = corrects;
    const double speed = after(scene, 100).measure().speed_max;
    std::printf("a box on smooth ground, %s corrector: %.1e m/s after 100 s\n", corrects ? "with its" : "without",
                speed);
    EXPECT_LT(speed, 1e-6);
  }
}

// Air damps them as an oscillation of a metre needs: after a minute only rounding is left, and the motion due to
// constraints that contradict each other.
TEST(Figures, DISABLED_PinnedSheetsWithBending) {
  const TemporaryFolder folder;
  const MeshFile irregular{folder.write("sheet.obj", irregular_obj(1, 1, 16, 16, 0.3, 5))};
  for (const bool grid : {true, false})
    for (const double air : {0.0, 6.0 / 289})
      for (const std::string kind : {"bending", "isometric_bending", "plate"}) {
        BodySpec sheet =
            body("sheet", GridShape{{1, 1}, {16, 16}}, {stiff("distance", {"edges", "shear"}), stiff(kind)});
        if (!grid) sheet.shape = irregular, sheet.constraints[0].elements = {"edges"};
        sheet.constraints[1].rigidity = 0.01;
        if (kind == "plate") sheet.constraints[1].parameter = 0;
        sheet.pins = {ListPin{{0, 16}}};
        Scene scene = scene_of({sheet}, kEarth, 1.0 / 60, 20, Precision::Double);
        if (air > 0) scene.wind = Wind{{0, 0, 0}, air};
        const double speed = after(scene, 60).measure().speed_max;
        std::printf("%s, %-18s %s air: the fastest particle %.1e m/s after a minute\n", grid ? "grid" : "irregular",
                    kind.c_str(), air > 0 ? "with" : "without", speed);
        if (air > 0) {
          EXPECT_LT(speed, 1e-3) << kind;
        }
      }
}

/// The rotation that a sphere of 0.3 m has at its surface after starting at rest, without gravity, m/s.
double turns_from_rest(std::vector<ConstraintSpec> constraints, int substeps, bool corrects) {
  BodySpec sphere = body("sphere", SphereShape{0.3, 2}, std::move(constraints));
  sphere.mass = 1.3;
  Scene scene = scene_of({sphere}, {}, 1.0 / 60, substeps);
  scene.solver.precision = Precision::Double, scene.solver.keeps_momenta = corrects;
  const double L = length(after(scene, 20).measure().angular_momentum);
  return L / (2.0 / 3 * *sphere.mass * 0.3);  // of a shell
}

TEST(Figures, DISABLED_RotationFromRest) {
  const ConstraintSpec edges = stiff("distance", {"edges"}), longer = stiff("distance", {"edges"}, 1, 1.5);
  const auto blown = [](double volume_ratio) { return stiff("pressure", {}, 1, volume_ratio); };
  struct Start {
    const char* title;
    std::vector<ConstraintSpec> constraints;
    bool turns;
  };
  for (const auto& [title, constraints, turns] :
       {Start{"edges of 1e-5 m/N, blown up to 1.2 times its volume",
              {compliant("distance", 1e-5, {"edges"}), blown(1.2)},
              false},
        Start{"edges of 1e-4 m/N, 1.2 times", {compliant("distance", 1e-4, {"edges"}), blown(1.2)}, false},
        Start{"stiff edges, 1.2 times", {edges, blown(1.2)}, false},
        Start{"stiff edges, 5 times", {edges, blown(5)}, true}, Start{"stiff edges half as long again", {longer}, true},
        Start{"stiff edges half as long again, and its volume", {longer, blown(1)}, true}})
    for (const int substeps : {10, 40}) {
      const double speed = turns_from_rest(constraints, substeps, false);
      std::printf("%s, %d substeps: %.1e m/s after 20 s, with the corrector %.0e m/s\n", title, substeps, speed,
                  turns_from_rest(constraints, substeps, true));
      EXPECT_EQ(speed > 0.05, turns) << title << ": or the page says otherwise";
    }
}

// There is no damping, and fixed directions do not respond to the force (kernels/projection/direction.h).
TEST(Figures, DISABLED_PressedBalloons) {
  for (const double compliance : {1e-3, 1e-4})
    for (const double volume_ratio : {1.2, 1.5, 2.0}) {
      std::printf("%g m/N, %g times its volume:", compliance, volume_ratio);
      for (const auto& [substeps, iterations] :
           {std::pair(10, 1), std::pair(40, 1), std::pair(10, 3), std::pair(10, 8)}) {
        BodySpec ball = body("ball", SphereShape{0.5, 3},
                             {compliant("distance", compliance, {"edges"}), stiff("pressure", {}, 1, volume_ratio)});
        ball.mass = 0.3;
        Scene scene = scene_of({ball}, {}, 1.0 / 60, substeps, Precision::Double);
        scene.solver.iterations = iterations;
        const double speed = after(scene, 15).measure().speed_max;
        std::printf("  %d x %d %.1e m/s", substeps, iterations, speed);
        if (volume_ratio < 1.5 && iterations == 1) {
          EXPECT_LT(speed, 0.01) << "or the page says otherwise";
        }
      }
      std::printf("\n");
    }
}

// Projections add no momenta; the rest is a random walk of rounding.
TEST(Figures, DISABLED_MomentaAfterAMinute) {
  for (const Precision precision : {Precision::Float, Precision::Double})
    for (const bool stiff_edges : {false, true})
      for (const double far : {0.1, 20.0, 500.0, 1e4}) {
        BodySpec body = tumbling_ellipsoid(1, {compliant("distance", 1e-6, {"edges"}), compliant("bending", 0.1)});
        if (stiff_edges) body.constraints = {stiff("distance", {"edges"}), compliant("bending", 10)};
        body.transform.translate = {far, 0.3, -0.2};
        body.spin = {0, 1.6, 5.4};
        double linear = 0, angular = 0;
        for (const Vec3& way : {Vec3{0.3, 0, 0}, {0, 0.3, 0}, {0, 0, 0.3}, {-0.3, 0, 0}, {0, -0.3, 0}, {0, 0, -0.3}}) {
          body.velocity = way;
          const Scene scene = scene_of({body}, {}, 1.0 / 60, 20, precision);
          const Measures before = Simulation(scene, {.threads = 1}).measure(), now = after(scene, 60).measure();
          linear = std::max(linear, length(now.momentum - before.momentum) / length(before.momentum));
          angular = std::max(angular,
                             length(now.angular_momentum - before.angular_momentum) / length(before.angular_momentum));
        }
        std::printf(
            "%-6s %s edges, at %8.1f m: momenta changed by up to %.1e (linear) and %.1e (angular) of themselves\n",
            precision_name(precision), stiff_edges ? "stiff" : "1e-6 m/N", far, linear, angular);
        EXPECT_LT(linear, precision == Precision::Double ? 1e-11 : 1e-3);
        // In float 1.5e-4 was measured at 10 km.
        EXPECT_LT(angular, precision == Precision::Double ? 1e-9 : far > 1e3 ? 2e-4 : 1e-4);
      }
}

TEST(Figures, DISABLED_RotationThatIsTooFast) {
  for (const bool stiff_edges : {true, false})
    for (const int substeps : {1, 10})
      for (const double radians : {0.03, 0.06, 0.1, 0.17, 0.33}) {  // a substep
        BodySpec body = tumbling_ellipsoid(2, {stiff("distance", {"edges"}), stiff("bending", {}, 0.3)});
        if (!stiff_edges) body.constraints = {compliant("distance", 1e-5, {"edges"}), compliant("bending", 0.1)};
        body.velocity = {}, body.transform.translate = {}, body.spin = {0, 0, radians * 60 * substeps};
        const Scene scene = scene_of({body}, {}, 1.0 / 60, substeps, Precision::Double);
        const double had = length(Simulation(scene, {.threads = 1}).measure().angular_momentum),
                     changed = length(after(scene, 5).measure().angular_momentum) / had - 1;
        std::printf("%s edges, %d substeps a step, %g rad each: angular momentum changes by %+.2g of itself in 5 s\n",
                    stiff_edges ? "stiff" : "1e-5 m/N", substeps, radians, changed);
        EXPECT_LT(changed, 0.05);
        if (radians < 0.05) {
          EXPECT_GT(changed, -0.005) << "or the page says otherwise";
        }
        if (radians > 0.3) {
          EXPECT_LT(changed, -0.2) << "or the page warns for nothing";
        }
      }
}

/// The relative change of the angular momentum of a free ellipsoid of 162 particles.
double change_of_rotation(const std::string& bending, double spin, int substeps, int iterations, double time) {
  BodySpec shell = body("shell", SphereShape{0.3, 2}, {stiff("distance", {"edges"}), stiff(bending)});
  shell.transform.scale = {1, 0.7, 0.85};
  shell.spin = {0.502 * spin, 0.703 * spin, 0.502 * spin};
  Scene scene = scene_of({shell}, {}, 1.0 / 60, substeps, Precision::Double);
  scene.solver.iterations = iterations;
  Simulation simulation(scene, {.threads = 1});
  const Vec3 before = simulation.measure().angular_momentum;
  while (simulation.time() < time) simulation.step();
  return length(simulation.measure().angular_momentum) / length(before) - 1;
}

TEST(Figures, DISABLED_RotationOfFoldsAndIterations) {
  for (const double turn : {0.01, 0.03, 0.05})
    for (const std::string bending : {"bending", "isometric_bending"}) {
      const double change = change_of_rotation(bending, 600 * turn, 10, 1, 60);
      std::printf("%s, %g rad a substep: %.1e of its angular momentum in a minute\n", bending.c_str(), turn, change);
      if (bending == "bending" || turn < 0.02) {
        EXPECT_LT(std::abs(change), 1e-9) << "or the page says otherwise";
      }
    }
  for (const int iterations : {4, 5})
    std::printf("4 substeps of %d iterations, 2.2 rad/s: %.1e in 10 s\n", iterations,
                change_of_rotation("bending", 2.2, 4, iterations, 10));
}

TEST(Figures, DISABLED_RotationOfTetrahedra) {
  BodySpec block = body("block", TetBoxShape{{0.3, 0.2, 0.4}, {4, 4, 4}}, {stiff("neo_hookean", {}, 1, 0.3)});
  block.constraints[0].young_modulus = 1e5, block.spin = {0, 1.6, 5.4};
  for (const int substeps : {80, 40, 20, 10}) {
    const Scene scene = scene_of({block}, {}, 1.0 / 60, substeps, Precision::Double);
    const Simulation start(scene, {.threads = 1});
    const Vec3 had = start.measure().angular_momentum;
    const double lost = length(after(scene, 10).measure().angular_momentum - had) / length(had);
    std::printf("%.2f cells a substep: %.1e of the angular momentum is lost in 10 s\n",
                fastest_shear_wave(start.model()).cells, lost);
    EXPECT_EQ(lost > 1e-3, substeps <= 20);
  }
}

}  // namespace
}  // namespace malha
