// SPDX-License-Identifier: Apache-2.0
// Stiff shells that hit the ground: whatever their mesh, their own stiffness adds no energy.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "host/mesh/io/mesh_io.h"
#include "kernels/constraints/constraint_registry.h"
#include "tests/measure/irregular_closed_mesh.h"
#include "tests/projection/one_constraint.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

/// A shell of this mesh, 0.5 m above the ground or thrown along it, with the default substeps.
Scene dropped_shell(const std::string& mesh, double scale, const ConstraintSpec& bending, Precision precision) {
  BodySpec shell;
  shell.name = "shell", shell.shape = MeshFile{mesh}, shell.mass = 1;
  double low = 1e300;
  for (const Vec3& p : read_mesh(mesh).points) low = std::min(low, p[1]);
  shell.transform.scale = {scale, scale, scale}, shell.transform.translate = {0, 0.5 - low * scale, 0};
  shell.constraints = {stiff("distance", {"edges"}), bending};
  Scene scene = scene_of({shell}, kEarth, 1.0 / 60, 10, precision);
  EnvironmentSpec ground;
  ground.name = "ground", ground.shape = GridShape{{80, 80}, {1, 1}}, ground.transform.translate = {-40, 0, -40};
  ground.sides = Sides::OneSided, ground.friction = 0.3;
  scene.environment = {ground};
  return scene;
}

struct Impact {
  double speed = 0, strain = 0;  // the largest after any step
  double fastest = 0;            // m/s: the bound by its initial speed and a fall from its highest point to the ground
};

Impact impact(const Scene& scene, double seconds) {
  Simulation simulation(scene, {.threads = 1});
  double thrown2 = 0, top = 0;
  for (const Vec3& v : simulation.velocities()) thrown2 = std::max(thrown2, length(v) * length(v));
  for (const Vec3& x : simulation.positions()) top = std::max(top, x[1]);
  Impact most;
  most.fastest = std::sqrt(thrown2 + 2 * 9.81 * top);
  while (simulation.time() < seconds) {
    simulation.step();
    const Measures m = simulation.measure();
    most.speed = std::max(most.speed, m.speed_max), most.strain = std::max(most.strain, m.strain_max);
  }
  return most;
}

void expect_bounded(const Impact& most, const std::string& what, double most_strain = 3) {
  EXPECT_LT(most.speed, 6 * most.fastest) << what << ": corners whip, and projections keep their energy";
  EXPECT_LT(most.strain, most_strain) << what;
}

enum class Motion { Dropped, Thrown, Spun };

/// One of many meshes, each with another motion, stiffness and precision, so that all combinations occur.
void expect_bounded_impact(int seed, int subdivisions, const ConstraintSpec& bending, Motion motion,
                           Precision precision) {
  const TemporaryFolder folder;
  Scene scene =
      dropped_shell(folder.write("shell.off", IrregularClosedMesh(seed, subdivisions).off()), 1, bending, precision);
  if (motion == Motion::Thrown) scene.bodies[0].velocity = {5, 0, 0};
  if (motion == Motion::Spun) scene.bodies[0].spin = {0, 7, 7};
  // With hardly any bending one mesh of 50 stretches by 3.14 when thrown, which is due to its springs alone.
  const bool bends = bending.compliance || bending.stiffness > 1e-3;
  expect_bounded(impact(scene, 1),
                 "mesh " + std::to_string(seed) + ", stiffness " + std::to_string(bending.stiffness) + ", compliance " +
                     std::to_string(bending.compliance.value_or(-1)) + ", motion " + std::to_string(int(motion)),
                 bends ? 3 : 3.2);
}

ConstraintSpec plate(double rigidity) {
  ConstraintSpec spec;
  spec.type = "plate", spec.parameter = 0, spec.rigidity = rigidity;
  return spec;
}

/// Bending by k, by compliance and by rigidity, over six decades.
std::vector<ConstraintSpec> bendings() {
  std::vector<ConstraintSpec> all;
  for (const double k : {1.0, 1e-2, 1e-4, 1e-6}) all.push_back(stiff("bending", {}, k));
  for (const double compliance : {1e-4, 1e-2, 1.0, 1e2}) all.push_back(compliant("bending", compliance));
  for (const double rigidity : {1e-4, 1e-2, 1.0, 1e2}) all.push_back(plate(rigidity));
  return all;
}

TEST(AStiffShellOfAnIrregularMesh, GainsNoSpeedOnImpact) {
  const std::vector<ConstraintSpec> all = bendings();
  for (int seed = 0; seed < 50; ++seed)
    expect_bounded_impact(seed, 2, all[seed % all.size()], Motion(seed % 3),
                          seed % 2 == 0 ? Precision::Float : Precision::Double);
}

/// A bound of the angle alone (0.2 rad a projection) let mesh 3 reach 3.1 times that speed.
TEST(AStiffPlateOfAnIrregularMesh, GainsNoSpeedOnImpact) {
  for (int seed = 0; seed < 50; ++seed)
    expect_bounded_impact(seed, 2, plate(seed % 2 == 0 ? 1.0 : 1e-2), Motion::Dropped, Precision::Double);
}

/// One to two minutes on one core.
TEST(AStiffShellOfAnIrregularMesh, DISABLED_GainsNoSpeedWithAnyStiffnessMotionAndPrecision) {
  for (int seed = 0; seed < 50; ++seed)
    for (const ConstraintSpec& bending : bendings())
      for (const Motion motion : {Motion::Dropped, Motion::Thrown, Motion::Spun})
        for (const Precision precision : {Precision::Float, Precision::Double})
          expect_bounded_impact(seed, 2, bending, motion, precision);
}

TEST(AnIrregularMesh, IsClosedAndHasSlivers) {
  for (int seed = 0; seed < 12; ++seed) {
    std::map<std::pair<int, int>, int> sides;
    const IrregularClosedMesh mesh(seed, 2);
    for (const Triangle& t : mesh.faces())
      for (int k = 0; k < 3; ++k) ++sides[{t[k], t[(k + 1) % 3]}];
    for (const auto& [side, times] : sides) {
      EXPECT_EQ(times, 1) << seed;
      EXPECT_TRUE(sides.contains({side.second, side.first})) << seed;
    }
  }
}

/// Scanned meshes of 38,000 to 44,000 particles: see tools/study/README.md, Stability.
class AScannedMesh : public testing::TestWithParam<const char*> {};

/// The mesh, scaled to a height of 1 m.
Scene scanned_shell(const std::string& scan, const ConstraintSpec& bending) {
  const std::string file = MALHA_SOURCE_DIR "/scenes/meshes/scans/" + scan + ".off";
  double low = 1e300, high = -1e300;
  for (const Vec3& p : read_mesh(file).points) low = std::min(low, p[1]), high = std::max(high, p[1]);
  return dropped_shell(file, 1 / (high - low), bending, Precision::Float);
}

TEST_P(AScannedMesh, GainsNoSpeedWhereItFallsAsAStiffShell) {
#if !defined(NDEBUG)
  GTEST_SKIP() << "half a minute without optimisation";
#endif
  // The largest strain of 115,000 edges: 2.1 to 3.7, depending on the smallest difference at the start.
  expect_bounded(impact(scanned_shell(GetParam(), compliant("bending", 0.01)), 0.6), GetParam(), 6);
}

/// Spun, that many particles stretch beyond 3 in ten substeps with edges alone, too; bending adds less than a quarter.
/// It takes half a minute.
TEST_P(AScannedMesh, DISABLED_ThrownOrSpunGainsNoSpeedAndStretchesAsItsEdgesAlone) {
  Scene stiff_shell = scanned_shell(GetParam(), compliant("bending", 0.01));
  for (const Motion motion : {Motion::Thrown, Motion::Spun}) {
    (motion == Motion::Thrown ? stiff_shell.bodies[0].velocity = {5, 0, 0} : stiff_shell.bodies[0].spin = {0, 7, 7});
    Scene edges = stiff_shell;
    edges.bodies[0].constraints.pop_back();
    const double alone = impact(edges, 0.6).strain;
    std::printf("%s, %s: strain %.1f with distance alone\n", GetParam(), motion == Motion::Thrown ? "thrown" : "spun",
                alone);
    expect_bounded(impact(stiff_shell, 0.6), GetParam(), std::max(3.0, 1.25 * alone));
    stiff_shell.bodies[0].velocity = {0, 0, 0};
  }
}
INSTANTIATE_TEST_SUITE_P(, AScannedMesh, testing::Values("bunny00", "armadillo", "refined_elephant"));

/// Every kind with a step bound: no particle moves farther, whatever the violation and the masses.
TEST(EveryConstraint, MovesNoParticleBeyondItsStepBound) {
  int kinds = 0;
  for_each_constraint([&]<class Kind>(Kind) {
    if constexpr (has_max_step<Kind>()) {
      ++kinds;
      Random random(6);
      int held = 0, free = 0;
      for (const Corners<Kind>& at : configurations<Kind>(300, 16)) {
        const auto w = unequal_masses<Kind>(random);
        const Rest<Kind> rest = another_rest<Kind>(at, random);
        const double reach = 1 / rest[Kind::per_max_step];
        OneConstraint<Kind, double> one(at, w, rest);
        one.template project<Update::Stiff>(1, 0);
        double farthest = 0;
        for (int j = 0; j < Kind::particles; ++j) farthest = std::max(farthest, norm(one.way(j)));
        EXPECT_LT(farthest, reach * (1 + 1e-12)) << Kind::name << ": but for rounding";
        ++(farthest > reach * (1 - 1e-12) ? held : free);
      }
      EXPECT_GT(held, 10) << Kind::name;
      EXPECT_GT(free, 0) << Kind::name;
    }
  });
  EXPECT_GT(kinds, 0);
}

/// A correction that exceeds the bound is made in later projections: a hinge folded by 2 rad about a pinned edge
/// unfolds to its rest angle, by PBD and by XPBD, whose multiplier accumulates the corrections that were applied.
TEST(AHinge, WhoseStepIsBoundedConvergesAllTheSame) {
  const double side = 0.1, far = 2;
  const auto folded = [&](double angle) {
    return Corners<Bending>{
        {{0, 0, 0}, {side, 0, 0}, {side / 2, side, 0}, {side / 2, -side * std::cos(angle), side * std::sin(angle)}}};
  };
  const Rest<Bending> rest = rest_of<Bending>(folded(0), 1);
  for (const double compliance : {0.0, 1.0}) {
    OneConstraint<Bending, double> one(folded(far), {0, 0, 1, 1}, rest);
    const double start = one.C();
    double before = std::abs(start);
    int projections = 0;
    for (; projections < 200; ++projections) {
      one.project<Update::Compliant>(0, compliance);
      const double now = std::abs(one.C());
      EXPECT_LE(now, before * (1 + 1e-9) + 1e-12);
      before = now;
    }
    // At the end C + alpha~ lambda = 0: the balance of the compliance, which the bound does not change.
    EXPECT_NEAR(one.C() + compliance * one.lambda[0], 0, 1e-6 * far) << compliance;
    EXPECT_GT(std::abs(one.lambda[0]), 0);
  }
}

}  // namespace
}  // namespace malha
