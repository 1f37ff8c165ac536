// SPDX-License-Identifier: Apache-2.0
// The matrix of Desbrun's filter: A = M - dt^2 H over the particles that have springs.
#include <gtest/gtest.h>

#include <set>

#include "host/filter/system.h"
#include "tests/filter/filter_reference.h"

namespace malha {
namespace {

/// Two sheets with edges, shear and bend springs (their particles of unequal masses), one pinned, its edges named
/// twice; a free chain; a loose particle.
Scene several_bodies() {
  BodySpec hung = sprung_sheet(5, {RowPin{}}), free = sprung_sheet(4);
  hung.constraints.push_back(compliant("distance", 1e-3, {"edges"}));
  free.name = "free";
  free.transform.translate = {3, 0, 0};
  BodySpec chain = sprung_chain(7, true);
  chain.name = "chain";
  return desbrun_scene({hung, free, chain, particle({9, 9, 9})}, 300);
}

TEST(SpringSystem, IsMassPlusSquaredStepTimesStiffness) {
  const Scene scene = several_bodies();
  const Model model = build_model(scene);
  for (const double dt : {1.0 / 60, 1e-3, 0.5}) {
    const SpringSystem system = spring_system(model, dt);
    const Eigen::MatrixXd A = matrix_of<double>(system), expected = matrix_of<double>(model, dt, system.particle);
    // The sum of some fifty numbers is taken in another order.
    EXPECT_LT((A - expected).cwiseAbs().maxCoeff(), 1e-14 * expected.maxCoeff()) << dt;
    EXPECT_EQ((A - A.transpose()).cwiseAbs().maxCoeff(), 0) << dt;
    for (int i = 0; i < system.count(); ++i) {
      EXPECT_EQ(system.mass[i], 1 / model.w[system.particle[i]]);
      for (int k = system.begin[i] + 1; k < system.begin[i + 1]; ++k)
        ASSERT_LT(system.column[k - 1], system.column[k]) << "each column once, ascending; row " << i;
    }
  }
}

TEST(SpringSystem, OfThreeParticlesIsWhatOneWritesDown) {
  // Particles 1 (pinned) - 2 - 3 with unequal lengths: masses of 1, 3 and 2 kg.
  const TemporaryFolder folder;
  BodySpec body;
  body.name = "line";
  body.shape = MeshFile{folder.write("line.obj", "v 0 0 0\nv 1 0 0\nv 3 0 0\nl 1 2\nl 2 3\n")};
  body.mass = 6;
  body.pins = {ListPin{{0}}};
  body.constraints = {stiff("distance", {"edges"}, 0.5), compliant("distance", 0.02, {"edges"})};
  Scene scene = desbrun_scene({body}, 100);
  scene.solver.dt = 0.2;
  const SpringSystem system = spring_system(build_model(scene), 0.1);
  ASSERT_EQ(system.count(), 2);
  const Eigen::MatrixXd A = matrix_of<double>(system);
  // 50 + 1 / 0.02 = 100 N/m each, times 0.01 s^2: 1 kg.
  const int middle = system.mass[0] > 2.5 ? 0 : 1;
  EXPECT_NEAR(A(middle, middle), 3 + 1 + 1, 1e-14);
  EXPECT_NEAR(A(1 - middle, 1 - middle), 2 + 1, 1e-14);
  EXPECT_NEAR(A(0, 1), -1, 1e-14);
  ASSERT_EQ(system.blocks.size(), 1u);
  EXPECT_FALSE(system.blocks[0].free);
}

TEST(SpringSystem, HasTheMovableParticlesWithSpringsForUnknownsAndABlockForEachPiece) {
  const Model model = build_model(several_bodies());
  const SpringSystem system = spring_system(model, 0.01);
  std::set<int> expected;
  for (int i = 0; i < model.count(); ++i)
    if (model.w[i] > 0 && model.user_index[i] + 1 < model.count()) expected.insert(i);
  EXPECT_EQ(std::set<int>(system.particle.begin(), system.particle.end()), expected)
      << "all but pins and the loose one";
  EXPECT_EQ(system.particle.size(), expected.size()) << "each once";
  int next = 0, free = 0;
  double mass = 0;
  ASSERT_EQ(system.blocks.size(), 3u);
  for (const SystemBlock& block : system.blocks) {
    EXPECT_EQ(block.first, next);
    next += block.count, free += block.free;
    double own = 0;
    for (int i = block.first; i < next; ++i) {
      own += system.mass[i];
      for (int k = system.begin[i]; k < system.begin[i + 1]; ++k)
        ASSERT_TRUE(system.column[k] >= block.first && system.column[k] < next) << "no entry between two blocks";
    }
    EXPECT_NEAR(own, block.mass, 1e-14 * own);
    mass += own;
  }
  EXPECT_EQ(next, system.count());
  EXPECT_EQ(free, 2);
  double movable = 0;
  for (const int i : expected) movable += 1 / model.w[i];
  EXPECT_NEAR(mass, movable, 1e-14 * movable);
}

/// A pin separates the parts on either side of it.
TEST(SpringSystem, IsCutByPins) {
  BodySpec chain = sprung_chain(7, true);
  chain.pins = {ListPin{{3}}};
  const SpringSystem system = spring_system(build_model(desbrun_scene({chain}, 100)), 0.01);
  ASSERT_EQ(system.blocks.size(), 2u);
  for (const SystemBlock& block : system.blocks) {
    EXPECT_EQ(block.count, 3);
    EXPECT_FALSE(block.free);
  }
}

TEST(SpringSystem, MultipliesAsItsMatrix) {
  const SpringSystem system = spring_system(build_model(several_bodies()), 0.01);
  Random random(5);
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> x(system.count(), 3);
  for (int k = 0; k < x.size(); ++k) x.data()[k] = random();
  const std::vector<double> y = multiply(system, {x.data(), x.data() + x.size()});
  const decltype(x) expected = matrix_of<double>(system) * x;
  for (int k = 0; k < x.size(); ++k) ASSERT_NEAR(y[k], expected.data()[k], 1e-14 * expected.norm());
}

/// The inputs that the filter depends on, and those that it does not.
TEST(SpringSystem, DependsOnStepMassStiffnessAndWhichParticlesArePinnedAlone) {
  const auto matrix = [](const BodySpec& body, double stiffness = 100, double dt = 0.01) -> Eigen::MatrixXd {
    return matrix_of<double>(spring_system(build_model(desbrun_scene({body}, stiffness)), dt));
  };
  const auto same = [](const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return a.rows() == b.rows() && a == b; };
  const BodySpec sheet = sprung_sheet(5, {ListPin{{0, 4}}});
  const Eigen::MatrixXd A = matrix(sheet);
  EXPECT_TRUE(same(matrix(sheet), A));
  BodySpec other = sheet;
  other.velocity = {1, 2, 3}, other.spin = {0, 1, 0}, other.transform.translate = {0.5, 1, -2};
  other.constraints[0].parameter = 1.25;  // rest lengths
  // Heights of hinges are computed from positions, each rounded.
  EXPECT_LT((matrix(other) - A).cwiseAbs().maxCoeff(), 1e-12) << "motion, place and rest lengths are no part of it";
  other = sheet, other.pins = {NearestPin{{0, 0, 0}}, NearestPin{{0.2, 0, 0}}};
  EXPECT_TRUE(same(matrix(other), A)) << "the same pins by another name";
  other.pins = {ListPin{{0, 3}}};
  EXPECT_FALSE(same(matrix(other), A));
  other = sheet, other.density = 0.31;
  EXPECT_FALSE(same(matrix(other), A));
  EXPECT_FALSE(same(matrix(sheet, 101), A));
  EXPECT_FALSE(same(matrix(sheet, 100, 0.011), A));
}

TEST(Fold, IsTwiceTheSineOfHalfTheAngleOfItsHinge) {
  const TemporaryFolder folder;
  const double phi = 0.7, slide = 0.3;  // phi: the fold of the mesh; slide: the distance of the wings along the hinge
  BodySpec body;
  body.name = "hinge";
  body.shape = MeshFile{folder.write("hinge.obj", "v 0 0 0\nv 1 0 0\nv 0.4 0 2\nv " + std::to_string(0.4 + slide) +
                                                      " " + std::to_string(3 * std::sin(phi)) + " " +
                                                      std::to_string(-3 * std::cos(phi)) + "\nf 1 2 3\nf 2 1 4\n")};
  body.mass = 1;
  for (const std::string type : {"bending", "isometric_bending"})
    for (const double flat : {0.0, 0.5, 1.0}) {
      body.constraints = {stiff(type, {}, 0.2, flat)};
      const Model model = build_model(desbrun_scene({body}, 1000));
      EXPECT_TRUE(model.springs.empty()) << "no spring spans a hinge";
      ASSERT_EQ(model.stencils.size(), 1u);
      const FoldReference fold = folds_of(model)[0];
      EXPECT_NEAR(length(fold.fold(model.x)), 2 * std::sin(phi / 2), 2e-6) << "the file has six digits";
      // The lever is the harmonic mean of the wings' heights, 2 and 3, whatever the angle: 200 N/m at 2.4 m.
      EXPECT_NEAR(fold.stiffness, 200 * 2.4 * 2.4, 1e-3);
      body.constraints = {compliant(type, 0.05, {}, flat)};
      EXPECT_NEAR(folds_of(build_model(desbrun_scene({body}, 1000)))[0].stiffness, 1 / 0.05, 1e-9);
    }
}

TEST(Springs, OfNoStiffnessOrBetweenPinsAreLeftOut) {
  BodySpec sheet = sprung_sheet(3, {RowPin{}});
  sheet.constraints = {stiff("distance", {"edges"})};
  // 4 x 3 points: 3 x 3 edges in one direction and 4 x 2 in the other, less the three of the pinned row.
  const Model model = build_model(desbrun_scene({sheet}, 10));
  ASSERT_EQ(model.springs.size(), 1u);
  EXPECT_EQ(model.springs[0].ends.size(), 9u + 8u - 3u);
  sheet.constraints = {stiff("distance", {"edges"}, 0)};
  EXPECT_EQ(spring_system(build_model(desbrun_scene({sheet}, 10)), 0.01).count(), 0);
}

}  // namespace
}  // namespace malha
