// SPDX-License-Identifier: Apache-2.0
// Maps of friction and of thickness: each particle slides, and lies over another, as its own factor says.
#include <gtest/gtest.h>

#include "host/mesh/vectors.h"
#include "host/model/model.h"
#include "host/run/checkpoint.h"
#include "kernels/environment/edge_detection.h"
#include "tests/mesh/irregular_sheet.h"
#include "tests/refusal.h"
#include "tests/run_scenes.h"
#include "tests/same_bits.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

constexpr double kMu = 0.2;
const std::vector<double> kFactors{0, 0.25, 1, 1.5, 4};

VertexMap listed(std::vector<double> values) {
  VertexMap map;
  map.values = std::move(values);
  return map;
}

/// Loose particles that lie on y = thickness, and whose friction has the factors above.
BodySpec row_of_particles(double thickness) {
  BodySpec body;
  body.name = "particles", body.mass = 1;
  body.shape = LatticeShape{{0, thickness, 0}, {0, thickness, 1}, {1, 1, static_cast<int>(kFactors.size())}};
  body.friction_map = listed(kFactors);
  return body;
}

enum class Ground { Triangles, Exact, Deforming };

Scene on_ground(Ground ground, BodySpec body, const Vec3& gravity, const char* method, Precision precision) {
  EnvironmentSpec object;
  object.name = "ground", object.friction = kMu;
  if (ground == Ground::Exact) {
    object.shape = PlaneShape{};
  } else {
    object.shape = GridShape{{8, 8}, {5, 3}}, object.transform.translate = {-3, 0, -4};
    object.sides = Sides::OneSided;
  }
  if (ground == Ground::Deforming) object.animation.emplace().from_code = true;
  Scene scene = scene_of({std::move(body)}, gravity, 1.0 / 60, 10, precision);
  scene.solver.type = method;
  scene.environment = {object};
  return scene;
}

class FrictionMapsOn : public testing::TestWithParam<Ground> {};

TEST_P(FrictionMapsOn, BrakeEachParticleByItsOwnFactor) {
  constexpr double slope = 18 * kPi / 180, time = 1, h = 1.0 / 600;  // tan = .325
  for (const char* method : {"pbd", "desbrun"})
    for (const Precision precision : {Precision::Float, Precision::Double}) {
      const Scene scene = on_ground(GetParam(), row_of_particles(0.005),
                                    {kG * std::sin(slope), -kG * std::cos(slope), 0}, method, precision);
      const Simulation simulation = after(scene, time);
      for (std::size_t i = 0; i < kFactors.size(); ++i) {
        const double a = std::max(0.0, kG * (std::sin(slope) - kMu * kFactors[i] * std::cos(slope)));
        // Symplectic Euler's path; float rounds pushes of g h^2 = 3e-5 m at positions of 2 m.
        EXPECT_NEAR(simulation.positions()[i][0], a / 2 * time * (time + h),
                    precision == Precision::Float ? 0.005 : 1e-6)
            << method << ", factor " << kFactors[i];
      }
    }
}

// An impact takes (1 + e) times the speed along the normal, and mu times that of the sliding.
TEST_P(FrictionMapsOn, BrakeEachParticleThatBounces) {
  BodySpec body = row_of_particles(0.025);
  body.velocity = {4, -3, 0};
  Scene scene = on_ground(GetParam(), body, {}, "pbd", Precision::Double);
  scene.environment[0].restitution = 0.5;
  const Simulation simulation = after(scene, 2.0 / 60);
  for (std::size_t i = 0; i < kFactors.size(); ++i) {
    const Vec3 expected{std::max(0.0, 4 - kMu * kFactors[i] * 1.5 * 3), 1.5, 0};
    EXPECT_LT(length(simulation.velocities()[i] - expected), 1e-9) << "factor " << kFactors[i];
  }
}

TEST_P(FrictionMapsOn, OfOneAreNoMaps) {
  for (const Precision precision : {Precision::Float, Precision::Double}) {
    const auto hash = [&](bool mapped) {
      BodySpec body = row_of_particles(0.02);
      body.velocity = {1, -1, 0};
      mapped ? void(body.friction_map->values.assign(kFactors.size(), 1)) : body.friction_map.reset();
      Scene scene = on_ground(GetParam(), body, kEarth, "pbd", precision);
      scene.environment[0].restitution = 0.3;
      return after(scene, 0.5).state_hash();
    };
    EXPECT_EQ(hash(true), hash(false));
  }
}

INSTANTIATE_TEST_SUITE_P(, FrictionMapsOn, testing::Values(Ground::Triangles, Ground::Exact, Ground::Deforming),
                         [](const auto& tested) {
                           return std::string(tested.param == Ground::Triangles ? "Triangles"
                                              : tested.param == Ground::Exact   ? "Exact"
                                                                                : "Deforming");
                         });

/// Two ridges along x, 1 m apart.
std::string ridges() {
  std::string text;
  for (const double z : {-0.5, 0.5})
    for (const double x : {-1.0, 3.0})
      for (const auto& [y, beside] : {std::pair{0.0, 0.0}, {-0.2, -0.1}, {-0.2, 0.1}})
        text += "v " + std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(z + beside) + "\n";
  for (const int k : {0, 6}) {
    const auto face = [&](std::initializer_list<int> corners) {
      text += "f";
      for (const int c : corners) text += " " + std::to_string(k + c);
      text += "\n";
    };
    face({1, 2, 3}), face({6, 5, 4}), face({4, 5, 2, 1}), face({5, 6, 3, 2}), face({6, 4, 1, 3});
  }
  return text;
}

// A rod of two particles lies across two ridges: edge on edge, at a quarter and three quarters of it.
TEST(FrictionMaps, BrakeARodOnEdges) {
  const TemporaryFolder folder;
  constexpr double slope = 20 * kPi / 180, time = 0.5, h = 1.0 / 600;  // tan = .364
  for (const bool from_code : {false, true})
    for (const double factor : {0.0, 0.5, 1.5}) {
      BodySpec rod;
      rod.name = "rod", rod.mass = 0.1;
      rod.shape = ChainShape{{0, 0.0025, -1}, {0, 0.0025, 1}, 1};
      rod.constraints = {stiff("distance", {"edges"})};
      rod.friction_map = listed({factor, factor});
      Scene scene = scene_of({rod}, {kG * std::sin(slope), -kG * std::cos(slope), 0}, 1.0 / 60, 10);
      EnvironmentSpec object;
      object.name = "ridges", object.shape = MeshFile{folder.write("ridges.obj", ridges())};
      object.friction = kMu, object.thickness = 0.005, object.edges = true;
      if (from_code) object.animation.emplace().from_code = true;
      scene.environment = {object};
      const Simulation simulation = after(scene, time);
      const double a = kG * (std::sin(slope) - kMu * factor * std::cos(slope)), path = a / 2 * time * (time + h);
      for (const Vec3& x : simulation.positions())
        EXPECT_NEAR(x[0], path, 0.01 * path) << "factor " << factor << (from_code ? ", mesh that deforms" : "");
    }
}

TEST(FrictionMaps, HaveTheValueAtThePointOfAContactWithAnEdge) {
  EdgeContact<double> contact{};
  const int particles[]{0, 1, 2, 3}, object[]{0, 0, 1, 1};
  std::copy(std::begin(particles), std::end(particles), contact.i);
  const double weights[]{-0.25, -0.75, 0.4, 0.6}, factors[]{2, 0.4};
  std::copy(std::begin(weights), std::end(weights), contact.weight);
  const EdgeContactParams<double> params{0.01, 0.3};
  const ObjectFriction<double, true> friction{&params, object, factors};
  EXPECT_DOUBLE_EQ(friction(contact), 0.3 * (0.25 * 2 + 0.75 * 0.4));
}

/// A layer of irregular triangles that lies on another one of them, which is fixed, inclined, and 3 m long.
struct Layers {
  static constexpr double kThickness = 0.02;

  Layers(const TemporaryFolder& folder, double slope, double friction) {
    const auto sheet = [&](const char* name, double width, double depth, int across, int along, const Vec3& at) {
      Random random(7);
      BodySpec body;
      body.name = name, body.mass = 0.1;
      body.shape =
          MeshFile{folder.write(std::string(name) + ".obj", irregular_sheet(width, depth, across, along, random))};
      body.transform.translate = at;
      body.constraints = {stiff("distance", {"edges"}), stiff("bending", {}, 0.05)};
      return body;
    };
    BodySpec lower = sheet("lower", 3, 1, 24, 12, {0, 0, 0}),
             upper = sheet("upper", 0.4, 0.3, 6, 5, {0.5, kThickness, 0.37});
    ListPin all;
    for (int i = 1; i < lower_count(); ++i) all.particles.push_back(i);  // a body needs a particle that moves
    lower.pins = {all};
    scene = scene_of({lower, upper}, {kG * std::sin(slope), -kG * std::cos(slope), 0}, 1.0 / 60, 10);
    scene.self_collision = SelfCollision{kThickness, friction, {}};
  }
  static int lower_count() { return 25 * 13; }
  static int upper_count() { return 7 * 6; }
  static double mean(const std::vector<Vec3>& x, int axis, int first, int end) {
    double sum = 0;
    for (int i = first; i < end; ++i) sum += x[static_cast<std::size_t>(i)][static_cast<std::size_t>(axis)];
    return sum / (end - first);
  }

  Scene scene;
};

TEST(FrictionMaps, OfTwoBodiesGiveTheirContactsTheMeanOfBoth) {
  constexpr double slope = 20 * kPi / 180, time = 0.8, h = 1.0 / 600;
  for (const auto& [of_lower, of_upper] : {std::pair{1.0, 1.0}, {0.0, 2.0}, {0.5, 0.25}, {2.0, 4.0}}) {
    const TemporaryFolder folder;
    Layers layers(folder, slope, kMu);
    layers.scene.bodies[0].friction_map = listed(std::vector<double>(Layers::lower_count(), of_lower));
    layers.scene.bodies[1].friction_map = listed(std::vector<double>(Layers::upper_count(), of_upper));
    Simulation simulation(layers.scene, {.threads = 2});
    const int first = Layers::lower_count(), end = first + Layers::upper_count();
    const double from = Layers::mean(simulation.positions(), 0, first, end);
    run_for(simulation, layers.scene, time);
    const double mu = kMu * (of_lower + of_upper) / 2, a = std::max(0.0, kG * (std::sin(slope) - mu * std::cos(slope)));
    const double path = a / 2 * time * (time + h);
    // As without maps: contacts of the first substeps are not in balance yet.
    EXPECT_NEAR(Layers::mean(simulation.positions(), 0, first, end) - from, path, 0.005 * path + 1e-3)
        << of_lower << ", " << of_upper;
    EXPECT_EQ(simulation.measure().crossings, 0);
  }
}

// The lower layer is thinner on the side of small x, so that of two upper layers each rests at its own height.
TEST(ThicknessMaps, LetLayersLieAsNearAsTheThinnerOneIs) {
  for (const Precision precision : {Precision::Float, Precision::Double})
    for (const double of_upper : {1.0, 0.25}) {
      const TemporaryFolder folder;
      Layers layers(folder, 0, 0.5);
      Scene& scene = layers.scene;
      scene.solver.precision = precision;
      std::vector<double> lower;
      for (const Vec3& x : build_model(scene).render_mesh.points)
        if (lower.size() < static_cast<std::size_t>(Layers::lower_count())) lower.push_back(x[0] < 1.4 ? 0.5 : 1);
      scene.bodies[0].thickness_map = listed(lower);
      scene.bodies[1].thickness_map = listed(std::vector<double>(Layers::upper_count(), of_upper));
      scene.bodies[1].damping = 0.5;
      BodySpec other = scene.bodies[1];
      other.name = "other", other.transform.translate[0] = 2;
      scene.bodies.push_back(other);
      const Simulation simulation = after(scene, 1);
      const std::vector<Vec3> x = simulation.positions();
      const int n = Layers::lower_count(), m = Layers::upper_count();
      const double thickness = Layers::kThickness;
      EXPECT_NEAR(Layers::mean(x, 1, n, n + m), std::min(0.5, of_upper) * thickness, 0.02 * thickness);
      EXPECT_NEAR(Layers::mean(x, 1, n + m, n + 2 * m), of_upper * thickness, 0.02 * thickness);
      EXPECT_EQ(simulation.measure().crossings, 0);
    }
}

// Two layers rest on each other by their maps; then the scene has other thicknesses. Thinner ones come nearer, and
// thicker ones, or those of which other vertices are thin, stay where they are.
TEST(ThicknessMaps, ThatAreChangedLetLayersComeNearerAndThrowNoneApart) {
  const TemporaryFolder folder;
  Layers layers(folder, 0, 0.5);
  Scene& scene = layers.scene;
  std::vector<double> lower;
  for (const Vec3& x : build_model(scene).render_mesh.points)
    if (lower.size() < static_cast<std::size_t>(Layers::lower_count())) lower.push_back(x[0] < 0.7 ? 0.3 : 1);
  scene.bodies[0].thickness_map = listed(lower);
  scene.bodies[1].damping = 0.2;
  const int n = Layers::lower_count(), m = Layers::upper_count();
  const double thickness = Layers::kThickness;
  Simulation simulation = after(scene, 1);
  const std::vector<Vec3> before = simulation.positions();
  scene.self_collision->thickness *= 1.01;
  simulation.set_scene(scene);
  run_for(simulation, scene, 0.5);
  for (int i = n; i < n + m; ++i)
    EXPECT_NEAR(simulation.positions()[static_cast<std::size_t>(i)][1], before[static_cast<std::size_t>(i)][1],
                0.03 * thickness);
  scene.bodies[1].thickness_map = listed(std::vector<double>(static_cast<std::size_t>(m), 0.3));
  simulation.set_scene(scene);
  run_for(simulation, scene, 1);
  EXPECT_NEAR(Layers::mean(simulation.positions(), 1, n, n + m), 0.3 * 1.01 * thickness, 0.02 * thickness);
  EXPECT_EQ(simulation.measure().crossings, 0);
}

TEST(ThicknessMaps, OfOneAreNoMaps) {
  const auto hash = [](bool mapped) {
    const TemporaryFolder folder;
    Layers layers(folder, 0.1, 0.5);
    layers.scene.solver.precision = Precision::Float;
    if (mapped) layers.scene.bodies[1].thickness_map = listed(std::vector<double>(Layers::upper_count(), 1));
    return after(layers.scene, 0.2).state_hash();
  };
  EXPECT_EQ(hash(true), hash(false));
}

TEST(ContactMaps, AreRefusedWhereTheyCannotBe) {
  const auto said = [](const std::function<void(Scene&)>& change) {
    const TemporaryFolder folder;
    Layers layers(folder, 0, 0);
    change(layers.scene);
    return refusal([&] { Simulation(layers.scene, {.threads = 1}); });
  };
  const auto map_of = [](double value) { return listed(std::vector<double>(Layers::upper_count(), value)); };
  const auto names = [&](const std::string& text, const char* place) { return text.find(place) != std::string::npos; };
  EXPECT_TRUE(names(said([&](Scene& scene) { scene.bodies[1].friction_map = map_of(-0.1); }),
                    "/bodies/1/friction_map: found the factor -0.1"));
  EXPECT_TRUE(names(said([&](Scene& scene) { scene.bodies[1].thickness_map = map_of(1.5); }),
                    "/bodies/1/thickness_map: found the factor 1.5"));
  EXPECT_TRUE(names(said([&](Scene& scene) { scene.bodies[1].thickness_map = map_of(0); }),
                    "/bodies/1/thickness_map: found the factor 0"));
  EXPECT_TRUE(names(said([&](Scene& scene) {
                      scene.bodies[1].friction_map = listed({1, 2});
                    }),
                    "/bodies/1/friction_map: found 2 values"));
  EXPECT_TRUE(
      names(said([&](Scene& scene) { scene.bodies[1].thickness_map = map_of(1), scene.self_collision.reset(); }),
            "/bodies/1/thickness_map"));
  EXPECT_TRUE(names(
      said([&](Scene& scene) { scene.bodies[1].thickness_map = map_of(1), scene.self_collision->bodies = {"lower"}; }),
      "/bodies/1/thickness_map"));
}

// Checkpoints and set_scene() know a scene by its hash, which has the colours of the files too.
TEST(ContactMaps, OfOtherColoursAreAnotherScene) {
  const auto hash = [](const char* red, const char* key) {
    const TemporaryFolder folder;
    Layers layers(folder, 0, 0.5);
    std::string obj = "v 0 0 0 " + std::string(red) + " 0 0\nv 1 0 0 0.5 0 0\nv 0 0 1 0.5 0 0\nf 1 3 2\n";
    BodySpec& body = layers.scene.bodies[1];
    body.shape = MeshFile{folder.write("coloured.obj", obj)}, body.constraints.pop_back();  // there is no hinge
    VertexMap map;
    map.colours = "red";
    const std::string of = key;
    (of == "friction" ? body.friction_map : of == "thickness" ? body.thickness_map : body.density_map) = map;
    Simulation simulation(layers.scene, {.threads = 1});
    return scene_hash(simulation.model());  // as checkpoints ask, of a model that is laid out
  };
  for (const char* key : {"friction", "thickness", "density"}) {
    EXPECT_EQ(hash("0.25", key), hash("0.25", key)) << key;
    EXPECT_NE(hash("0.25", key), hash("0.75", key)) << key;
  }
}

/// A sheet on a belt: one half sticks to it and goes with it, the other does not. It tears between them.
Scene torn_by_a_belt(const TemporaryFolder& folder) {
  Random random(5);
  BodySpec body;
  body.name = "sheet", body.density = 0.2;
  body.shape = MeshFile{folder.write("sheet.obj", irregular_sheet(1, 0.3, 20, 6, random))};
  body.transform.translate = {0, 0.005, 0};
  body.constraints = {compliant("distance", 0.1, {"edges"})};
  body.tear = Tear{0.05};
  std::vector<double> factors;
  for (int i = 0; i < 21 * 7; ++i) factors.push_back(i % 21 < 10 ? 0 : 2);
  body.friction_map = listed(factors);
  Scene scene = scene_of({body}, kEarth, 1.0 / 60, 10, Precision::Float);
  EnvironmentSpec belt;
  belt.name = "belt", belt.shape = GridShape{{8, 8}, {3, 3}}, belt.transform.translate = {-4, 0, -4};
  belt.sides = Sides::OneSided, belt.friction = 1;
  Keyframe end;
  end.time = 1, end.translate = {3, 0, 0};
  belt.motion = {Keyframe{}, end};
  scene.environment = {belt};
  return scene;
}

INSTANTIATE_TEST_SUITE_P(ContactMaps, SameBits,
                         testing::Values(SameBitsScene{"LayersWithMaps",
                                                       [](const TemporaryFolder& folder) {
                                                         Layers layers(folder, 0.2, 0.4);
                                                         BodySpec& upper = layers.scene.bodies[1];
                                                         std::vector<double> factors(Layers::upper_count());
                                                         for (std::size_t i = 0; i < factors.size(); ++i)
                                                           factors[i] = 0.2 + 0.8 * static_cast<double>(i) /
                                                                                  static_cast<double>(factors.size());
                                                         upper.friction_map = upper.thickness_map = listed(factors);
                                                         upper.velocity = {0, -1, 0}, upper.spin = {0, 30, 0};
                                                         layers.scene.solver.precision = Precision::Float;
                                                         return layers.scene;
                                                       },
                                                       40,
                                                       {7, 23}},
                                         SameBitsScene{"SheetTornByABelt",
                                                       torn_by_a_belt,
                                                       30,
                                                       {7, 23},
                                                       [](const Simulation& simulation) {
                                                         EXPECT_GT(simulation.positions().size(), 21u * 7u)
                                                             << "it tore";
                                                       }}),
                         name_of_scene);

}  // namespace
}  // namespace malha
