// SPDX-License-Identifier: Apache-2.0
// Fields of the forces on pins.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "host/fields/forces.h"
#include "tests/mesh/irregular_sheet.h"
#include "tests/run_scenes.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

Vec3 sum_of(const std::vector<PinForce>& all) {
  Vec3 sum{};
  for (const PinForce& one : all)
    for (std::size_t k = 0; k < 3; ++k) sum[k] += one.force[k];
  return sum;
}

Json scene_with(Json body, const char* method) {
  body["name"] = "body", body["mass"] = 1;
  return {{"name", "pulled pins"},
          {"duration", 1},
          {"gravity", {0, -kG, 0}},
          {"solver", {{"type", method}, {"dt", 0.01}, {"substeps", 4}, {"precision", "double"}}},
          {"bodies", {body}}};
}

TEST(PinForces, OfAChainAreTheTensionOfItsFirstSegment) {
  const double compliance = 1e-3;
  Scene scene = scene_of({hung_chain({0, 0, 0}, {0, -1, 0}, 4)}, kEarth, 0.01);
  scene.bodies[0].constraints = {compliant("distance", compliance, {"edges"})};
  const Simulation simulation(scene, {.threads = 1});
  const PinForces forces(simulation.model());
  EXPECT_EQ(forces.left_out(), 0u);
  // The first segment is stretched by 0.02 m, and turned: 20 N along it.
  const std::vector<PinForce> all =
      forces({{0, 0, 0}, {0.27 * 0.6, -0.27 * 0.8, 0}, {5, 5, 5}, {6, 5, 5}, {9, 9, 9}}, 0);
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].particle, 0);
  EXPECT_NEAR(all[0].force[0], 20 * 0.6, 1e-9);
  EXPECT_NEAR(all[0].force[1], -20 * 0.8, 1e-9);
  EXPECT_NEAR(all[0].force[2], 0, 1e-12);
  EXPECT_THROW(forces({{0, 0, 0}}, 0), std::invalid_argument);
}

// For every kind that has an energy, the force is minus the gradient of the energy that measures add up.
TEST(PinForces, AreMinusTheSlopeOfTheEnergy) {
  const auto check = [](const Json& body, const std::string& what, const char* method = "pbd") {
    const Scene scene = parsed(scene_with(body, method));
    const Simulation simulation(scene, {.threads = 1});
    const Model& model = simulation.model();
    Random random(7);
    std::vector<Vec3> x = simulation.positions();
    for (Vec3& p : x)
      for (double& coordinate : p) coordinate = 1.1 * coordinate + 0.01 * random();
    const auto energy = [&](const std::vector<Vec3>& at) {
      Simulation moved(scene, {.threads = 1});
      moved.set_positions(at);
      return moved.measure().elastic;
    };
    const std::vector<PinForce> all = PinForces(model)(x, 0);
    ASSERT_GT(all.size(), 0u) << what;
    double largest = 0;
    for (const PinForce& one : all) largest = std::max(largest, length(one.force));
    EXPECT_GT(largest, 1e-4) << what;
    for (const PinForce& one : all)
      for (std::size_t k = 0; k < 3; ++k) {
        const double d = 1e-5;
        std::vector<Vec3> more = x, less = x;
        more[one.particle][k] += d, less[one.particle][k] -= d;
        // Central differences of energies: off by d^2 times the third derivative, and by rounding over d.
        EXPECT_NEAR(one.force[k], -(energy(more) - energy(less)) / (2 * d), 1e-5 * largest) << what;
      }
  };
  const auto sheet = [](const char* constraint) {
    return Json{{"shape", {{"grid", {{"size", {1, 1}}, {"cells", {3, 3}}}}}},
                {"pins", {{{"particles", {0, 3}}}}},
                {"constraints", {Json::parse(constraint)}}};
  };
  const auto box = [](const char* constraint) {
    return Json{{"shape", {{"tet_box", {{"size", {1, 1, 1}}, {"cells", {2, 2, 2}}}}}},
                {"pins", {{{"particles", {0, 1, 2}}}}},
                {"constraints", {Json::parse(constraint)}}};
  };
  for (const char* constraint :
       {R"({"type": "distance", "compliance": 0.01})", R"({"type": "bending", "compliance": 1})",
        R"({"type": "isometric_bending", "compliance": 1})", R"({"type": "distance_limit", "compliance": 0.01})",
        R"({"type": "membrane", "young_modulus": 40, "poisson_ratio": 0.3})",
        R"({"type": "plate", "rigidity": 0.001, "poisson_ratio": 0.3})"})
    check(sheet(constraint), constraint);
  for (const char* constraint : {R"({"type": "volume", "compliance": 0.01})",
                                 R"({"type": "neo_hookean", "young_modulus": 1e4, "poisson_ratio": 0.3})"})
    check(box(constraint), constraint);
  check({{"shape", {{"sphere", {{"radius", 0.5}, {"subdivisions", 1}}}}},
         {"pins", {{{"particles", {0, 7}}}}},
         {"constraints", {{{"type", "pressure"}, {"volume_ratio", 1.5}, {"compliance", 1e-3}}}}},
        "pressure");
  check(sheet(R"({"type": "distance"})"), "springs", "desbrun");
}

TEST(PinForces, OfAnIrregularSheetAtRestAddUpToItsWeight) {
  TemporaryFolder folder;
  Random random(8);
  const std::string file = folder.write("sheet.obj", irregular_sheet(1, 1, 7, 7, random));
  for (const char* method : {"pbd", "desbrun"}) {
    Json scene = scene_with({{"shape", {{"mesh", file}}},
                             {"transform", {{"rotate", {{"axis", {1, 0, 0}}, {"degrees", 90}}}}},
                             {"pins", {{{"particles", {0, 3, 7}}}}},
                             {"damping", 0.5},
                             {"constraints", {{{"type", "distance"}, {"compliance", 1e-3}}}}},
                            method);
    scene["solver"]["substeps"] = method == std::string("pbd") ? 40 : 4;
    scene["wind"] = {{"velocity", {0, 0, 0}}, {"drag", 2}};  // so that it comes to rest soon
    Simulation simulation(parsed(scene), {.threads = 1});
    for (int step = 0; step < 4000; ++step) simulation.step();
    const PinForces forces(simulation.model());
    const std::vector<PinForce> all = forces(simulation.positions(), simulation.time());
    ASSERT_EQ(all.size(), 3u) << method;
    // The pins' own masses exert no force.
    double weight = 0;
    for (const double w : simulation.inverse_masses())
      if (w > 0) weight += kG / w;
    const Vec3 sum = sum_of(all);
    std::printf("%s: pins are pulled with %.4f of the weight\n", method, -sum[1] / weight);
    // A constraint is satisfied when it is projected, and its neighbours move its particles again: by some w dt^2 /
    // compliance, 0.008.
    EXPECT_NEAR(sum[1], -weight, 0.01 * weight) << method << ": it hardly moves any more";
    EXPECT_NEAR(std::hypot(sum[0], sum[2]), 0, 0.01 * weight) << method;
  }
}

TEST(PinForces, OfWhatHasNoComplianceAreLeftOut) {
  Scene scene = scene_of({hung_chain({0, 0, 0}, {0, -1, 0}, 4)}, kEarth, 0.01);
  scene.bodies[0].constraints = {stiff("distance", {"edges"})};
  const Simulation simulation(scene, {.threads = 1});
  const PinForces forces(simulation.model());
  EXPECT_FALSE(forces.any());
  EXPECT_EQ(forces.left_out(), 1u) << "one segment has a pin";
  EXPECT_TRUE(forces(simulation.positions(), 0).empty());
}

// Whatever the compliance, the field of a chain that hangs at rest has the weight below its pin, or nothing.
TEST(PinForces, OfWhatIsTooStiffForItsSubstepsAreLeftOut) {
  int shown = 0, left_out = 0;
  for (const double compliance : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-9}) {
    Json scene = scene_with({{"shape", {{"chain", {{"from", {0, 0, 0}}, {"to", {0, -1, 0}}, {"segments", 5}}}}},
                             {"pins", {{{"particles", {0}}}}},
                             {"constraints", {{{"type", "distance"}, {"compliance", compliance}}}}},
                            "pbd");
    scene["wind"] = {{"velocity", {0, 0, 0}}, {"drag", 2}}, scene["solver"]["substeps"] = 20;
    Simulation simulation(parsed(scene), {.threads = 1});
    for (int step = 0; step < 2000; ++step) simulation.step();
    const PinForces forces(simulation.model());
    left_out += static_cast<int>(forces.left_out());
    double below = 0;
    for (const double w : simulation.inverse_masses())
      if (w > 0) below += kG / w;
    for (const PinForce& one : forces(simulation.positions(), simulation.time())) {
      EXPECT_NEAR(one.force[1], -below, 0.1 * below) << compliance;
      ++shown;
    }
  }
  EXPECT_GE(shown, 3);
  EXPECT_GE(left_out, 2);
}

}  // namespace
}  // namespace malha
