// SPDX-License-Identifier: Apache-2.0
#include "host/forces/pressure.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "host/mesh/generate.h"
#include "host/mesh/topology.h"
#include "host/mesh/vectors.h"
#include "tests/mesh/point_list.h"
#include "tests/numbers.h"
#include "tests/scene_builders.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

constexpr double kRadius = 0.5;

/// An icosphere about `centre` with unequal masses, and its one pressure constraint.
struct RoundBalloon {
  Model model;
  PressureSet set;
  explicit RoundBalloon(double volume_ratio = 1, const Vec3& centre = {0, 0, 0}, int subdivisions = 2) {
    Mesh mesh = generate(SphereShape{kRadius, subdivisions});
    Random random(1);
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
      for (int k = 0; k < 3; ++k) mesh.points[i][k] += centre[k];
      model.w.push_back(random(0.2, 5));
      set.particles.push_back(static_cast<int>(i));
    }
    model.x = mesh.points;
    set.triangles = triangles(mesh);
    set.volume_ratio = volume_ratio;
    model.scene.solver.substeps = model.scene.solver.iterations = 1;
  }

  /// The particles, each moved by up to `noise` metres.
  template <class R>
  PointList<R> particles(double noise, unsigned seed = 2) const {
    Random random(seed);
    PointList<R> p;
    for (const Vec3& x : model.x) p.push_back(Vector3<double>{x[0], x[1], x[2]} + random.in_cube(noise));
    return p;
  }

  template <class R>
  std::vector<R> inverse_masses() const {
    return {model.w.begin(), model.w.end()};
  }
};

double volume(const PointList<double>& p, const std::vector<Triangle>& triangles) {
  std::vector<Vec3> points;
  for (int i = 0; i < p.size(); ++i) points.push_back({p[i].x, p[i].y, p[i].z});
  return signed_volume(points, triangles);
}

/// Projects in a substep that begins at these positions; p changes. `starts`: whether it is the first projection, or
/// continues.
template <class Executor, class R>
void project(Pressure<Executor, R>& pressure, const RoundBalloon& balloon, PointList<R>& p, int times = 1,
             bool starts = true) {
  const std::vector<R> w = balloon.inverse_masses<R>();
  PointList<R> d(p.size()), low(p.size());
  const Displaced<R> all{p.points(), d.points(), low.points()};
  if (starts) pressure.start_substep(all, w.data(), false);
  for (int k = 0; k < times; ++k) pressure.project(all, w.data());
  for (int i = 0; i < p.size(); ++i) p.set(i, p[i] + d[i]);
}
/// Projects the constraint of `set`.
template <class R>
void project(const RoundBalloon& balloon, PointList<R>& p, int times = 1) {
  Pressure<Serial, R> pressure({}, balloon.model, balloon.set);
  project(pressure, balloon, p, times);
}

TEST(Pressure, TakesTheEnclosedVolumeInCubicMetres) {
  const RoundBalloon balloon(1, {3, -2, 7});
  auto p = balloon.particles<double>(0.05);
  std::vector<int> corners;
  for (const Triangle& t : balloon.set.triangles) corners.insert(corners.end(), t.begin(), t.end());
  for (const int origin : {0, 5}) {
    const double enclosed = parallel_reduce<Sum>(Serial{}, static_cast<int>(balloon.set.triangles.size()),
                                                 EnclosedVolume<Points<double>>{p.points(), corners.data(), origin})
                                .value;
    EXPECT_NEAR(enclosed, volume(p, balloon.set.triangles), 2e-14);
  }
}

TEST(Pressure, KnowsTheVolumeOfASphere) {
  const RoundBalloon balloon(1, {0, 0, 0}, 5);
  auto p = balloon.particles<double>(0);
  const double sphere = 4.0 / 3 * 3.14159265358979323846 * std::pow(kRadius, 3);
  // 10,242 points: facets lie inside the sphere by edge^2 / (8 r), some 0.0004 r, three times that in volume.
  EXPECT_NEAR(volume(p, balloon.set.triangles) / sphere, 1, 2e-3);
  Pressure<Serial, double> pressure({}, balloon.model, balloon.set);
  EXPECT_NEAR(pressure.volume_ratio(p.points()), 1, 1e-14);
  for (int i = 0; i < p.size(); ++i) p.set(i, p[i] * 1.1);
  EXPECT_NEAR(pressure.volume_ratio(p.points()), 1.331, 1e-13);
}

TEST(Pressure, HasTheGradientOfItsFiniteDifferences) {
  const RoundBalloon balloon(1.3);
  auto p = balloon.particles<double>(0.05);
  const auto& triangles = balloon.set.triangles;
  // The fans of triangles in the layout that the kernel reads, built in the simplest way.
  std::vector<int> begin{0}, around;
  for (int i : balloon.set.particles) {
    for (const Triangle& t : triangles)
      for (int k = 0; k < 3; ++k)
        if (t[k] == i) around.insert(around.end(), {t[(k + 1) % 3], t[(k + 2) % 3]});
    begin.push_back(static_cast<int>(around.size()) / 2);
  }
  PointList<double> grad(p.size());
  const std::vector<double>& w = balloon.model.w;
  const std::vector<double> most(w.size(), 1e9);  // m^2: nothing is clamped
  const StartPositions<double> started{{p.points(), {}, {}}};
  const PressureGradient<double> kernel{
      {started, begin.data(), around.data(), 3}, w.data(), balloon.set.particles.data(), most.data(), grad.points()};
  double weighted = 0;
  for (int i : balloon.set.particles) {
    const double sum = kernel(i).grad2;
    EXPECT_NEAR(sum, w[i] * dot(grad[i], grad[i]), 1e-15);
    weighted += sum;
  }
  EXPECT_GT(weighted, 0);
  for (const int i : {0, 1, 40, 161})
    for (const Vector3<double>& axis : {Vector3<double>{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}) {
      constexpr double h = 1e-4;  // the volume is linear in one particle: only rounding, eps / h, is left
      const auto at = [&](double by) {
        auto moved = p;
        moved.set(i, moved[i] + axis * by);
        return volume(moved, triangles);
      };
      EXPECT_NEAR(dot(grad[i], axis), (at(h) - at(-h)) / (2 * h), 1e-10) << i;
    }
}

TEST(Pressure, KeepsLinearAndAngularMomentum) {
  for (const bool is_compliant : {false, true}) {
    RoundBalloon balloon(1.5);
    if (is_compliant) balloon.set.compliance = 3e-6;
    const auto before = balloon.particles<double>(0.05);
    auto p = before;
    project(balloon, p);
    Vector3<double> linear{0, 0, 0}, angular{0, 0, 0};
    double size = 0;
    for (int i = 0; i < p.size(); ++i) {
      const Vector3<double> push = (p[i] - before[i]) * (1 / balloon.model.w[i]);
      linear = linear + push, angular = angular + cross(before[i], push), size += norm(push);
    }
    EXPECT_GT(size, 0.1);
    EXPECT_LT(norm(linear), 1e-14 * size);
    EXPECT_LT(norm(angular), 1e-14 * size);
  }
}

/// A balloon of uniform density with a needle: one particle is at `times` the radius from the centre.
struct NeedleBalloon : RoundBalloon {
  PointList<double> p;
  explicit NeedleBalloon(double times) : p(particles<double>(0)) {
    std::vector<double> around(model.w.size(), 0);
    for (const Triangle& t : set.triangles)
      for (const int i : t) around[i] += area(model.x[t[0]], model.x[t[1]], model.x[t[2]]);
    for (std::size_t i = 0; i < around.size(); ++i) model.w[i] = 1 / around[i];
    p.set(50, p[50] * times);
  }
};

TEST(Pressure, MovesTheFacesOfANeedleNoFartherThanFourTimesAllOthers) {
  // The faces of a needle of 15 m push its foot with 46 times the area that they had. Pressure moves the faces of one
  // density alike but for their stretch, and of that four times counts: kMaxStretch. A quarter of that for the
  // rigid motion that returns the momenta, and for what is flatter at its corners than its faces are large.
  for (const bool is_compliant : {false, true}) {
    NeedleBalloon balloon(30);
    if (is_compliant) balloon.set.compliance = 3e-9;
    const PointList<double> before = balloon.p;
    project(balloon, balloon.p);
    std::vector<double> way;
    Vector3<double> linear{0, 0, 0}, angular{0, 0, 0};
    double size = 0;
    for (int i = 0; i < before.size(); ++i) {
      way.push_back(norm(balloon.p[i] - before[i]));
      const Vector3<double> push = (balloon.p[i] - before[i]) * (1 / balloon.model.w[i]);
      linear = linear + push, angular = angular + cross(before[i], push), size += norm(push);
    }
    std::sort(way.begin(), way.end());
    EXPECT_GT(way.front(), 0);
    EXPECT_LT(way.back(), 5 * way[way.size() / 2]);
    EXPECT_LT(norm(linear), 1e-12 * size);
    EXPECT_LT(norm(angular), 1e-12 * size * 15) << "of moments over 15 m";
  }
}

TEST(Pressure, MovesWhatHasANeedleByTheVolumeThatItShould) {
  NeedleBalloon balloon(30);
  const double k = 1e-5;  // the first-order error is as small
  balloon.set.stiffness = k;
  const auto C = [&](const PointList<double>& p) {
    return volume(p, balloon.set.triangles) - volume(balloon.particles<double>(0), balloon.set.triangles);
  };
  const double before = C(balloon.p);
  project(balloon, balloon.p);
  EXPECT_GT(before, 0.1);
  EXPECT_NEAR((before - C(balloon.p)) / (k * before), 1, 1e-3);
}

/// A mesh like a scan: thin limbs, triangles of all sizes (a sphere's, crowded about one limb), vertices in random
/// order. It falls half a metre, and has no bending.
Scene falling_limbs(int subdivisions) {
  Mesh mesh = generate(SphereShape{1, subdivisions});
  Random random(1);
  const Vec3 crowded{0.25, -1, 0};
  const std::vector<Vec3> limbs{crowded, {-0.25, -1, 0}, {1, 0.35, 0}, {-1, 0.35, 0}, {0, 1, 0}};
  const auto unit = [](Vec3 a) {
    const double size = norm(a);
    for (double& k : a) k /= size;
    return a;
  };
  const Vec3 d = unit(crowded);
  double low = 0;
  for (Vec3& p : mesh.points) {
    for (double& k : p) k += random(-0.014, 0.014);  // a fifth of the edges
    p = unit(p);
    const double along = dot(p, d);
    if (along > -1 + 1e-9) {  // the conformal map that makes triangles about `crowded` a third as long
      Vec3 q = minus(p, {along * d[0], along * d[1], along * d[2]});
      for (double& k : q) k /= 3 * (1 + along);
      const double q2 = dot(q, q);
      for (int k = 0; k < 3; ++k) p[k] = (2 * q[k] + (1 - q2) * d[k]) / (1 + q2);
    }
    double r = 0.1;
    for (const Vec3& limb : limbs) r += 0.8 * std::pow(std::max(0.0, dot(p, unit(limb))), 40);
    for (double& k : p) k *= r;
    low = std::min(low, p[1]);
  }
  BodySpec body;
  body.name = "limbs";
  body.shape = MeshDataShape{mesh.points, mesh.faces, {}, {}};
  body.mass = 1;
  body.transform.translate = {0, 0.5 - low, 0};
  body.constraints = {compliant("distance", 1e-4, {"edges"}), stiff("pressure")};
  Scene scene = scene_of({body}, kEarth, 1.0 / 60, 2);
  scene.environment = {obstacle("ground", BoxShape{{40, 1, 40}, {{1, 1, 1}}})};
  scene.environment[0].transform.translate = {0, -0.5, 0};
  return scene;
}

// Its shell crumples, which few substeps do not resolve. It may then be too soft, but not faster than a body that falls
// so far: the factor of five is for its light particles, which oscillate.
TEST(Pressure, LetsNoSpikesGrowFromABodyOfThinLimbsThatFalls) {
  const double impact = std::sqrt(2 * kG * 0.5);
  for (const std::string method : {"pbd", "desbrun"})
    for (const int substeps : {2, 5}) {
      Scene scene = falling_limbs(method == "pbd" ? 5 : 4);
      scene.solver.type = method, scene.solver.substeps = substeps;
      Simulation simulation(scene, {.threads = 1});
      double fastest = 0;
      for (int step = 0; step < 50; ++step) {
        simulation.step();
        fastest = std::max(fastest, simulation.measure().speed_max);
      }
      EXPECT_LT(fastest, 5 * impact) << method << ", " << substeps << " substeps";
    }
}

TEST(Pressure, ReachesItsVolume) {
  for (const double ratio : {0.5, 1.0, 2.0}) {
    const RoundBalloon balloon(ratio);
    auto p = balloon.particles<double>(0.02);
    project(balloon, p, 20);
    const double rest = volume(balloon.particles<double>(0), balloon.set.triangles);
    EXPECT_NEAR(volume(p, balloon.set.triangles) / rest, ratio, 1e-12);
  }
}

TEST(Pressure, ReachesItsVolumeInFloatFarFromTheOrigin) {
  // Taken about a particle of the mesh, a volume of 0.5 m^3 at 1000 m is as good as the positions: 6e-5 m on 1 m.
  const RoundBalloon balloon(1.5, {1000, -1000, 1000});
  auto p = balloon.particles<float>(0.02f);
  project(balloon, p, 20);
  Pressure<Serial, float> measure({}, balloon.model, balloon.set);
  EXPECT_NEAR(measure.volume_ratio(p.points()), 1.5, 1e-3);
}

TEST(Pressure, WithStiffnessKLeavesOneMinusKOfASmallError) {
  RoundBalloon balloon(1.0001);
  balloon.set.stiffness = 0.7;
  balloon.model.scene.solver.iterations = 5;
  auto p = balloon.particles<double>(0);
  project(balloon, p, 5);
  Pressure<Serial, double> measure({}, balloon.model, balloon.set);
  // The volume is cubic in the displacement: relative to the error, another 1e-4.
  EXPECT_NEAR((1.0001 - measure.volume_ratio(p.points())) / 0.0001, 0.3, 1e-3);
}

TEST(Pressure, WithComplianceComesToTheBalanceOfItsForce) {
  // Where C is so small that it is linear, the balance C = -alpha~ lambda leaves C / C0 = alpha~ / (s + alpha~), with
  // s = sum w |grad C|^2 a number of the mesh alone: every alpha~ must give the same s.
  const double excess = 1e-5;
  RoundBalloon balloon(1 + excess);
  const double h = balloon.model.scene.solver.dt;
  std::vector<double> s;
  for (const double alpha : {0.03, 0.1, 0.4}) {
    balloon.set.compliance = alpha * h * h;
    auto p = balloon.particles<double>(0);
    Pressure<Serial, double> pressure({}, balloon.model, balloon.set);
    project(pressure, balloon, p, 10);
    const double left = (1 + excess - pressure.volume_ratio(p.points())) / excess;
    EXPECT_GT(left, 0.01);
    EXPECT_LT(left, 0.99);
    s.push_back(alpha * (1 / left - 1));
  }
  EXPECT_NEAR(s[1] / s[0], 1, 1e-3);
  EXPECT_NEAR(s[2] / s[0], 1, 1e-3);
}

/// A balloon of springs of `softness` (m/N) whose rest volume is `volume_ratio` times its volume, damped by air.
Scene inflated(const Vec3& scale, int subdivisions, double softness, double compliance, double volume_ratio) {
  BodySpec body;
  body.name = "balloon";
  body.shape = SphereShape{kRadius, subdivisions};
  body.transform.scale = scale;
  body.mass = 1;
  body.constraints = {compliant("distance", softness, {"edges"}), compliant("pressure", compliance, {}, volume_ratio)};
  Scene scene = scene_of({body}, {}, 1.0 / 60, 40);
  scene.wind = Wind{{0, 0, 0}, subdivisions == 0 ? 10.0 : 0.4};  // nearly critical damping of the whole
  return scene;
}

/// An icosahedron grows uniformly by s, to the minimum of E(s) = 30 (l (s - 1))^2 / (2 a) + (V (s^3 - r))^2 / (2 alpha)
/// of its 30 edges l and its volume V.
TEST(Pressure, WithComplianceMeetsTheEquilibriumOfAnIcosahedron) {
  const double a = 1e-3, r = 2, l = kRadius / std::sin(0.4 * kPi), V = 5 * (3 + std::sqrt(5.0)) / 12 * l * l * l;
  for (const double alpha : {3e-5, 3e-4, 1e-3}) {
    double low = 1, high = 1.3;
    for (int k = 0; k < 60; ++k) {
      const double s = (low + high) / 2;
      (30 * l * l * (s - 1) / a + 3 * V * V * s * s * (s * s * s - r) / alpha < 0 ? low : high) = s;
    }
    const double stretched = l * (low - 1), missing = V * (low * low * low - r);
    const Measures found = after(inflated({1, 1, 1}, 0, a, alpha, r), 0.5).measure();
    // Substeps of 1 / 2400 s: what is projected one after the other is off by some (omega h)^2 = 0.01 of the way.
    EXPECT_NEAR(found.volume_ratios[0] - 1, low * low * low - 1, 0.01 * (low * low * low - 1)) << alpha;
    const double energy = 30 * stretched * stretched / (2 * a) + missing * missing / (2 * alpha);
    EXPECT_NEAR(found.elastic, energy, 0.02 * energy) << alpha;
  }
}

/// At rest the springs pull each particle back as strongly as the missing volume over alpha pushes it out.
TEST(Pressure, WithCompliancePushesAMeshOfAnyFormByItsVolumeOverAlpha) {
  const double a = 1e-2, alpha = 2e-4, r = 1.6;
  const Scene scene = inflated({1, 2, 0.5}, 2, a, alpha, r);
  const Simulation simulation = after(scene, 3);
  Mesh mesh = make_mesh(scene.bodies[0].shape);
  apply(scene.bodies[0].transform, mesh);
  const std::vector<Triangle> faces = triangles(mesh);
  const std::vector<Vec3> x = simulation.positions();
  const double pressure = (r * signed_volume(mesh.points, faces) - signed_volume(x, faces)) / alpha;
  std::vector<Vec3> pushed(x.size()), left;
  for (const Triangle& t : faces) {
    const Vec3 n = cross(x[t[1]] - x[t[0]], x[t[2]] - x[t[0]]);  // twice the area: a third of it to each corner
    for (int corner : t)
      for (int k = 0; k < 3; ++k) pushed[corner][k] += pressure * n[k] / 6;
  }
  left = pushed;
  for (const auto& [i, j] : edges(mesh)) {
    const Vec3 d = x[j] - x[i];
    const double pull = (1 - length(mesh.points[j] - mesh.points[i]) / length(d)) / a;
    for (int k = 0; k < 3; ++k) left[i][k] += pull * d[k], left[j][k] -= pull * d[k];
  }
  double push = 0, rest = 0;
  for (std::size_t i = 0; i < x.size(); ++i) push += length(pushed[i]), rest += length(left[i]);
  EXPECT_GT(push, 10);
  EXPECT_LT(rest, 0.02 * push);  // some (omega h)^2, as above
}

TEST(Pressure, ForgetsLambdaWhenASubstepStarts) {
  RoundBalloon balloon(1.5);
  balloon.set.compliance = 3e-5;
  Pressure<Serial, double> pressure({}, balloon.model, balloon.set);
  const auto project_from_rest = [&](bool starts) {
    auto p = balloon.particles<double>(0);
    project(pressure, balloon, p, 1, starts);
    return pressure.volume_ratio(p.points());
  };
  const double first = project_from_rest(true), remembered = project_from_rest(false);
  EXPECT_NE(first, remembered);
  EXPECT_EQ(project_from_rest(true), first);
}

TEST(Pressure, LeavesPinnedParticlesAndWhatHasCollapsedAlone) {
  RoundBalloon balloon(1.5);
  for (std::size_t i = 0; i < balloon.model.w.size(); i += 2) balloon.model.w[i] = 0;
  const auto before = balloon.particles<float>(0.02f);
  auto p = before;
  project(balloon, p);
  for (int i = 0; i < p.size(); ++i) EXPECT_EQ(same_bits(p[i], before[i]), i % 2 == 0) << i;

  auto collapsed = before;
  for (int i = 0; i < p.size(); ++i) collapsed.set(i, {1, 2, 3});
  const auto still = collapsed;
  project(balloon, collapsed);
  for (int i = 0; i < p.size(); ++i) EXPECT_TRUE(same_bits(collapsed[i], still[i])) << i;

  for (double& w : balloon.model.w) w = 0;
  auto pinned = balloon.particles<float>(0.02f);
  const auto as_it_was = pinned;
  project(balloon, pinned);
  for (int i = 0; i < p.size(); ++i) EXPECT_TRUE(same_bits(pinned[i], as_it_was[i])) << i;
}

TEST(Pressure, GivesTheSameBitsOnEveryExecutor) {
  const RoundBalloon balloon(1.5, {0, 0, 0}, 4);  // 2,562 particles: ten groups a reduction
  const auto run = [&]<class Executor>(const Executor& executor) {
    auto p = balloon.particles<float>(0.02f);
    Pressure<Executor, float> pressure(executor, balloon.model, balloon.set);
    project(pressure, balloon, p, 5);
    return p;
  };
  const auto serial = run(Serial{});
  for (const int threads : {1, 2, 3, 8}) {
    const auto parallel = run(OpenMP{threads});
    for (int i = 0; i < serial.size(); ++i) ASSERT_TRUE(same_bits(serial[i], parallel[i])) << threads;
  }
}

}  // namespace
}  // namespace malha
