// SPDX-License-Identifier: Apache-2.0
// Fields of strain and residual of particles.
#include "host/fields/fields.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

#include "host/solver/solver.h"
#include "tests/fields/fields_of_sheets.h"
#include "tests/projection/one_constraint.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

constexpr double kInFloat = 1e-7;  // fields are floats: half of their last digit is 6e-8

double largest_look(const std::vector<float>& values) { return *std::max_element(values.begin(), values.end()); }

using FieldsOfStrain = FieldsOfSheets;

TEST(Fields, StrainOfAChainIsThatOfItsSegments) {
  Scene scene = scene_of({hung_chain({0, 0, 0}, {1, 0, 0}, 4)}, {}, 0.01);
  scene.bodies[0].constraints = {stiff("distance", {"edges"}, 1, 0.5)};
  const Simulation simulation(scene, {.threads = 1});
  const Strains strains(simulation.model());
  // Segments of 1/8 m at rest, now 0.25, 0.25, 0.5 and 0.0625 m.
  const std::vector<float> all =
      strains({{0, 0, 0}, {0.25, 0, 0}, {0.25, 0.25, 0}, {0.25, 0.25, 0.5}, {0.25, 0.3125, 0.5}});
  const std::vector<double> expected{1, 1, 3, 3, 0.5};
  ASSERT_EQ(all.size(), expected.size());
  for (std::size_t i = 0; i < all.size(); ++i) EXPECT_NEAR(all[i], expected[i], kInFloat * expected[i]) << i;
}

TEST_F(FieldsOfStrain, IsAnalyticOnAnIrregularMesh) {
  Scene scene = sheet(9, {stiff("distance", {"edges"})});
  scene.solver.precision = Precision::Double;  // so that positions are those of the file
  const Simulation simulation(scene, {.threads = 1});
  const std::vector<Vec3> X = simulation.positions();
  std::vector<Vec3> x = X;
  for (Vec3& p : x) p = {p[2] + 3, 1.25 * p[0], 0.5 * p[2]};  // x is stretched to 5/4, z to sqrt(1 + 1/4)
  // The strain is that of the faces, not of the constraints.
  std::vector<double> expected(X.size(), 0);
  for (const Quad& face : simulation.model().render_mesh.faces)
    for (int k = 0; k < 3; ++k) {
      const int i = face[k], j = face[(k + 1) % 3];
      const Vec3 d = X[i] - X[j];
      const double strain = std::abs(std::hypot(1.25 * d[0], std::sqrt(1.25) * d[2]) / std::hypot(d[0], d[2]) - 1);
      expected[i] = std::max(expected[i], strain), expected[j] = std::max(expected[j], strain);
    }
  const std::vector<float> all = Strains(simulation.model())(x);
  for (std::size_t i = 0; i < all.size(); ++i) EXPECT_NEAR(all[i], expected[i], kInFloat * expected[i] + 1e-12) << i;
}

TEST_F(FieldsOfStrain, IsAtMostThatOfTheMeasures) {
  for (const char* method : {"pbd", "desbrun"}) {
    Scene scene = sheet(14, {stiff("distance", {"edges"}, 0.5), compliant("bending", 1)}, {ListPin{{0}}});
    scene.solver.type = method;
    Simulation simulation(scene, {.threads = 1});
    for (int step = 0; step < 20; ++step) simulation.step();
    const double most = simulation.measure().strain_max;
    ASSERT_GT(most, 1e-4) << method;
    const Strains strains(simulation.model());
    EXPECT_TRUE(strains.any());
    EXPECT_NEAR(largest_look(strains(simulation.positions())), most, kInFloat * most) << method;
  }
}

TEST(Fields, OfATornMeshAreRebuilt) {
  BodySpec strip;
  strip.name = "strip", strip.mass = 0.2, strip.tear = Tear{0.5};
  strip.shape = GridShape{{1, 2}, {4, 8}};
  strip.constraints = {compliant("distance", 1e-3, {"edges", "shear"})};
  Pin end(RowPin{true});
  end.motion = {{0, {}, {0, 1, 0}, 0}, {1, {0, 0, 1.8}, {0, 1, 0}, 0}};
  strip.pins = {RowPin{false}, end};
  Simulation simulation(scene_of({strip}, {}, 0.01, 4, Precision::Float), {.threads = 1});
  const Strains before(simulation.model());
  const Residuals residuals(simulation.model());
  while (simulation.tears() == 0 && simulation.time() < 2) simulation.step();
  ASSERT_GT(simulation.tears(), 0);
  EXPECT_THROW(before(simulation.positions()), std::invalid_argument);
  EXPECT_THROW(residuals(simulation.positions()), std::invalid_argument);
  const double most = simulation.measure().strain_max;
  EXPECT_NEAR(largest_look(Strains(simulation.model())(simulation.positions())), most, kInFloat * most);
  const Structure layout = structure(simulation.model());
  EXPECT_EQ(layout.patch.size(), simulation.positions().size());
  EXPECT_EQ(layout.patches, simulation.solver().facts().patches.patches);
}

/// One constraint of a kind, whose particles the user numbers in reverse.
template <class Kind>
Model one_constraint_model(const Corners<Kind>& X, double parameter) {
  Model model;
  ConstraintSet set{Kind::name, Kind::particles, 1, {}, parameter, {}, {}};
  set.orthotropic = some_orthotropic<Kind>();
  for (int j = 0; j < Kind::particles; ++j) {
    model.x.push_back({X[j].x, X[j].y, X[j].z}), model.w.push_back(1);
    model.user_index.push_back(Kind::particles - 1 - j);
    set.particles.push_back(j);
  }
  model.sets.push_back(set);
  return model;
}
template <class Kind>
std::vector<Vec3> backwards(const Corners<Kind>& q) {
  std::vector<Vec3> x;
  for (int j = Kind::particles - 1; j >= 0; --j) x.push_back({q[j].x, q[j].y, q[j].z});
  return x;
}
template <class Kind>
double look_at_residual(const Corners<Kind>& X, const Corners<Kind>& now,
                        double parameter = Kind::parameter.default_value) {
  const std::vector<float> all = Residuals(one_constraint_model<Kind>(X, parameter))(backwards<Kind>(now));
  EXPECT_EQ(all.size(), std::size_t(Kind::particles));
  for (const float one : all) EXPECT_EQ(one, all[0]) << Kind::name;
  return all[0];
}

/// F / |grad F| with the gradient of F by differences.
template <class Kind, class F>
double by_differences(const Corners<Kind>& at, const F& value) {
  constexpr double step = 1e-5;
  double sum = 0;
  for (int j = 0; j < Kind::particles; ++j)
    for (const auto coordinate : {&Vector3<double>::x, &Vector3<double>::y, &Vector3<double>::z}) {
      Corners<Kind> low = at, high = at;
      low[j].*coordinate -= step, high[j].*coordinate += step;
      const double slope = (value(high) - value(low)) / (2 * step);
      sum += slope * slope;
    }
  return std::abs(value(at)) / std::sqrt(sum);
}

template <class Kind>
void as_array(const Corners<Kind>& from, Vector3<double> (&q)[Kind::particles]) {
  std::copy(from.begin(), from.end(), q);
}

/// Six points of a folded mesh, of which every kind takes the first ones.
template <class Kind>
Corners<Kind> near_a_mesh(Random& random, double off) {
  const Vector3<double> mesh[6] = {{0, 0, 0},        {1, 0, 0},        {0.3, 0.9, 0},
                                   {0.5, -0.8, 0.4}, {-0.6, 0.7, 0.3}, {1.1, 0.9, 0.2}};
  Corners<Kind> at;
  for (int j = 0; j < Kind::particles; ++j) at[j] = mesh[j] + random.in_cube(off);
  if (Kind::particles == 6) std::swap(at[3], at[5]);  // the wings are opposite to their corners
  return at;
}

TEST(Fields, ResidualIsTheDistanceToTheConstraint) {
  Random random(11);
  for_each_constraint([&]<class Kind>(Kind) {
    int compared = 0;
    for (int trial = 0; trial < 50; ++trial) {
      const Corners<Kind> X = near_a_mesh<Kind>(random, 0.1), now = near_a_mesh<Kind>(random, trial % 2 ? 0.1 : 0.4);
      Vector3<double> q[Kind::particles];
      double rest[Kind::rest_values];
      as_array<Kind>(X, q);
      Kind::rest(q, some_material<Kind>(), rest);
      const auto C = [&](const Corners<Kind>& at) {
        Vector3<double> p[Kind::particles], grad[Kind::particles];
        as_array<Kind>(at, p);
        if constexpr (requires { Kind::energy(p, rest); }) return 2 * Kind::energy(p, rest);
        double scale = 1;
        const double scaled = Kind::evaluate(p, rest, true, grad, scale);
        return scaled / scale;
      };
      const double found = look_at_residual<Kind>(X, now);
      if (Kind::inequality && C(now) >= 0) {
        EXPECT_EQ(found, 0) << Kind::name;
        continue;
      }
      // For a material the differences are those of 2 U, which give U / |grad U|.
      const double way = by_differences<Kind>(now, C) * (multipliers<Kind>() > 1 ? 2 : 1);
      EXPECT_NEAR(found, way, 1e-5 * way + kInFloat) << Kind::name << ": differences of 1e-5 m, with curvature";
      ++compared;
    }
    EXPECT_GT(compared, 5) << Kind::name;
  });
}

TEST(Fields, ResidualIsNothingAtRestAndWhereThatIsMoved) {
  Random random(12);
  for_each_constraint([&]<class Kind>(Kind) {
    for (int trial = 0; trial < 20; ++trial) {
      const Corners<Kind> X = near_a_mesh<Kind>(random, 0.1);
      Corners<Kind> turned = X;
      for (auto& p : turned) p = {0.6 * p.x - 0.8 * p.z + 10, p.y, 0.8 * p.x + 0.6 * p.z};
      EXPECT_LT(look_at_residual<Kind>(X, X), 1e-14) << Kind::name << ": rounding, of 1 m";
      EXPECT_LT(look_at_residual<Kind>(X, turned), 2e-13) << Kind::name << ": rounding, of 10 m";
    }
  });
}

TEST(Fields, ResidualIsAnalytic) {
  const Corners<Distance> rod{{{0, 0, 0}, {2, 0, 0}}};
  EXPECT_NEAR(look_at_residual<Distance>(rod, {{{0, 0, 0}, {0, 0, 5}}}), 3 / std::sqrt(2.0), kInFloat * 3);
  EXPECT_NEAR(look_at_residual<Distance>(rod, {{{1, 1, 1}, {1, 1, 1}}}), 2 / std::sqrt(2.0), kInFloat * 3);
  EXPECT_NEAR(look_at_residual<DistanceLimit>(rod, {{{0, 0, 0}, {5, 0, 0}}}, 0.25), 2.5 / std::sqrt(2.0), kInFloat * 3);
  EXPECT_EQ(look_at_residual<DistanceLimit>(rod, {{{0, 0, 0}, {2.4, 0, 0}}}, 0.25), 0);
  // Three edges at right angles, twice as long: 7/6 m^3 too much; |grad| = 4/6 sqrt(6) m^2.
  const Corners<Volume> corner{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  EXPECT_NEAR(look_at_residual<Volume>(corner, {{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}}}),
              7 / (4 * std::sqrt(6.0)), kInFloat * 2);
  // Flat, wings of height 2 m over the middle of their edge; folded by 1 rad.
  const double a = 0.5;
  const Corners<Bending> flat{{{-1, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, -2, 0}}};
  const Corners<Bending> fold{
      {{-1, 0, 0}, {1, 0, 0}, {0, 2 * std::cos(a), 2 * std::sin(a)}, {0, -2 * std::cos(a), 2 * std::sin(a)}}};
  EXPECT_NEAR(look_at_residual<Bending>(flat, fold), 2 / std::sqrt(2 + 2 * std::cos(a) * std::cos(a)), kInFloat * 2);
}

TEST(Fields, ResidualOfPressureIsThatOfItsVolume) {
  BodySpec ball;
  ball.name = "ball", ball.mass = 1, ball.shape = SphereShape{0.5, 1};
  ball.constraints = {stiff("pressure", {}, 1, 1.5)};
  const Simulation simulation(scene_of({ball, particle({3, 0, 0})}, {}, 0.01), {.threads = 1});
  std::vector<Vec3> x = simulation.positions();
  for (Vec3& p : x) p = {1.2 * p[0], p[1], 0.9 * p[2]};
  const auto volume = [&](const std::vector<Vec3>& at) {
    double sum = 0;
    for (const Quad& f : simulation.model().render_mesh.faces) {
      const Vec3 &a = at[f[0]], &b = at[f[1]], &c = at[f[2]];
      sum +=
          a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    return sum / 6;
  };
  double sum = 0;
  for (Vec3& p : x)
    for (double& coordinate : p) {
      const double here = coordinate;
      coordinate = here + 1e-4;
      const double more = volume(x);
      coordinate = here - 1e-4;  // a volume is linear in each coordinate
      const double slope = (more - volume(x)) / 2e-4;
      coordinate = here, sum += slope * slope;
    }
  const double way = std::abs(volume(x) - 1.5 * volume(simulation.positions())) / std::sqrt(sum);
  const std::vector<float> all = Residuals(simulation.model())(x);
  for (int i = 0; i < 42; ++i) EXPECT_NEAR(all[i], way, 1e-6 * way) << i << ": differences, rounded";
  EXPECT_EQ(all[42], 0) << "the loose particle";
}

TEST_F(FieldsOfSheets, AreTheSameOnAnyThreads) {
  const Scene scene = sheet(20, {stiff("distance", {"edges"}), compliant("bending", 1)});
  Simulation simulation(scene, {.threads = 1});
  std::vector<Vec3> x = simulation.positions();
  for (Vec3& p : x) p[1] = 0.3 * p[0] * p[2];
  EXPECT_EQ(Residuals(simulation.model(), 1)(x), Residuals(simulation.model(), 3)(x));
  EXPECT_EQ(structure(simulation.model(), 1).batch, structure(simulation.model(), 3).batch);
}

}  // namespace
}  // namespace malha
