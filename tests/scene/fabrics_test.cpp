// SPDX-License-Identifier: Apache-2.0
// Fabrics by name: their numbers against the tables of their source, what a body takes of them, and how they hang.
#include "malha/fabrics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "host/model/model.h"
#include "tests/refusal.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

using Json = nlohmann::ordered_json;

/// Stiffnesses of the database: (k0, k1, k2, k3) at rest, and stretched by a sixth at 0, 22.5, 45, 67.5 and 90 degrees
/// (N/m, half of ARCSim's); of hinges without curvature whose fold lines are at 0, 45 and 90 degrees (1e-6 N m).
struct MeasuredFabric {
  const char* name;
  double stretching[6][4], bending[3];
};
const MeasuredFabric kMeasuredFabrics[] = {
    {"black denim",
     {{205.352005, 10.234077, 1013.88629, 53.387184},
      {232.027634, 40.646339, 1052.84289, 64.980499},
      {224.592209, 40.384563, 1054.43444, 67.184807},
      {225.95105, 62.095657, 1059.59741, 83.99202},
      {226.039566, 40.502792, 1058.27771, 75.118423},
      {225.767487, 40.917892, 1051.55712, 71.810631}},
     {64.196457, 73.384567, 96.951576}},
    {"camel ponte roma",
     {{31.146198, -12.802702, 44.028667, 31.896357},
      {78.707756, 26.754574, 268.680725, 27.743423},
      {67.368431, 77.767944, 182.273407, -14.661531},
      {113.367035, 54.802021, 175.126572, 44.65733},
      {144.29483, 111.404854, 138.42215, -29.861851},
      {143.933365, 49.654823, 191.777588, 39.491055}},
     {36.348366, 33.013252, 37.157593}},
    {"gray interlock",
     {{16.593832, -14.69599, 34.477123, 36.860302},
      {46.364765, 53.694656, 261.013855, -29.691301},
      {49.28511, 87.5961, 206.373993, 22.768457},
      {123.98922, 105.18177, 365.966217, 44.217571},
      {139.686325, 73.59256, 413.553162, -174.43853},
      {127.44381, 85.848587, 405.872833, 32.238411}},
     {23.191698, 24.749964, 14.267624}},
    {"ivory rib knit",
     {{42.871021, -0.234556, 65.166023, 83.175644},
      {52.422512, 7.219094, 245.337158, -31.129513},
      {29.482058, -5.146112, 127.130753, 13.068157},
      {91.209549, 4.940307, 109.746452, 27.60943},
      {48.973385, -0.967226, 147.696823, -49.282963},
      {105.649139, 0.416488, 254.593491, 3.472504}},
     {46.237591, 30.01593, 32.243889}},
    {"navy sparkle sweat",
     {{12.486332, -19.875324, 3.272434, 17.616289},
      {32.172089, 56.01276, 283.46637, -2.438436},
      {48.565407, 94.126335, 180.101227, 4.43908},
      {77.093796, 2.958664, 91.25116, 6.1077},
      {126.205986, 84.471718, 305.131531, 38.495132},
      {92.34317, 117.527084, 243.264908, 47.338436}},
     {59.469658, 40.072277, 45.625023}},
    {"pink ribbon brown",
     {{151.503906, 106.02816, 244.830673, 30.250183},
      {164.124344, 33.689709, 268.195221, 30.074625},
      {152.584641, 107.251373, 210.614838, -62.760571},
      {209.604172, 175.223465, 220.19812, 129.643188},
      {98.879021, 107.085518, 326.209442, 44.475986},
      {96.805817, 54.626881, 359.792633, 30.340616}},
     {117.070122, 87.509773, 59.774277}},
    {"royal target",
     {{2016.55456, 9.170511, 2034.97644, 104.759674},
      {2109.51684, 38.604588, 2173.93969, 19.129177},
      {2109.78002, 60.16531, 2155.51367, 27.81789},
      {2110.33349, 30.987429, 2135.0791, 121.482445},
      {2109.16015, 72.393326, 2124.13525, 40.810982},
      {2109.52612, 63.424015, 2152.73852, 39.885654}},
     {125.409805, 107.997696, 125.409805}},
    {"tango red jet set",
     {{43.067627, 54.373299, 171.424835, 14.3147},
      {75.151695, 82.195221, 236.163773, -7.230383},
      {57.548206, 89.637825, 224.553848, 3.932043},
      {107.244377, 124.801788, 364.583557, 41.386868},
      {178.734039, 178.488907, 371.764618, -30.898058},
      {227.028687, -21.865427, 404.867188, 62.636021}},
     {14.293814, 21.9517, 20.345654}},
    {"white dots on black",
     {{2002.08618, 0.345588, 2027.48559, 19.189022},
      {2107.22753, 36.371597, 2171.73339, 16.904713},
      {2107.29882, 57.936157, 2153.30712, 24.392872},
      {2107.73291, 28.389059, 2132.72607, 101.462021},
      {2106.9375, 70.149529, 2121.87353, 38.054455},
      {2107.30786, 61.21629, 2150.4768, 37.668823}},
     {51.713814, 40.65947, 31.282822}},
    {"white swim solid",
     {{47.971176, 6.834521, 104.615456, 60.773663},
      {40.369045, 23.092957, 169.66629, -24.68189},
      {40.291599, 48.142597, 138.261612, 9.002558},
      {51.393467, -32.966949, 79.881721, 35.973194},
      {51.500938, 1.86891, 63.693932, -37.540417},
      {68.621185, 40.13195, 124.468513, 36.199604}},
     {60.237942, 58.803211, 51.018833}},
};

TEST(Fabrics, HaveTheModuliOfTheirTablesAtAStretchOfATwentieth) {
  ASSERT_EQ(fabrics().size(), std::size(kMeasuredFabrics));
  for (std::size_t f = 0; f < fabrics().size(); ++f) {
    const Fabric& fabric = fabrics()[f];
    const MeasuredFabric& measured = kMeasuredFabrics[f];
    const std::string name = measured.name;
    ASSERT_EQ(fabric.name, name);
    const auto at = [&](int direction, int k) {
      return 0.7 * measured.stretching[0][k] + 0.3 * measured.stretching[1 + direction][k];
    };
    const double c11 = 2 * at(0, 0), c22 = 2 * at(4, 2), c12 = at(0, 1) + at(4, 1);
    const auto is = [&](double found, double expected) {
      EXPECT_NEAR(found / expected, 1, 0.006) << name << ": three digits";
    };
    is(fabric.young_modulus[0], c11 - c12 * c12 / c22), is(fabric.young_modulus[1], c22 - c12 * c12 / c11);
    is(fabric.shear_modulus, at(2, 3));
    EXPECT_NEAR(fabric.poisson_ratio, c12 / c22, 0.006) << name << ": two digits";
    const double D1 = measured.bending[2] / 4e6, D2 = measured.bending[0] / 4e6, at_45 = measured.bending[1] / 4e6;
    is(fabric.rigidity[0], D1), is(fabric.rigidity[1], D2), is(fabric.twisting_rigidity, at_45 - (D1 + D2) / 4);
  }
}

TEST(Fabrics, AreInThePageAsTheCommandPrintsThem) {
  std::ifstream file(std::string(MALHA_SOURCE_DIR) + "/scenes/README.md");
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  EXPECT_NE(page.find(fabric_table()), std::string::npos) << fabric_table();
}

Json scene_of_fabric(const Json& more) {
  Json body{{"name", "cloth"}, {"shape", {{"grid", {{"size", {1, 1}}, {"cells", {8, 8}}}}}}};
  body.update(more);
  return {{"name", "scene"}, {"solver", {{"type", "pbd"}, {"dt", 0.01}}}, {"duration", 1}, {"bodies", {body}}};
}
BodySpec parsed_body(const Json& more) { return parse_scene(scene_of_fabric(more).dump(), "s.json", "").bodies[0]; }

TEST(Material, GivesABodyItsDensityItsMembraneAndItsPlate) {
  for (const Fabric& fabric : fabrics()) {
    const BodySpec body = parsed_body({{"material", fabric.name}});
    EXPECT_EQ(body.density, fabric.density);
    ASSERT_EQ(body.constraints.size(), 2u);
    const ConstraintSpec &membrane = body.constraints[0], &plate = body.constraints[1];
    EXPECT_EQ(membrane.type, "membrane");
    EXPECT_EQ(membrane.young_modulus, fabric.young_modulus[0]);
    EXPECT_EQ(membrane.orthotropy->across, fabric.young_modulus[1]);
    EXPECT_EQ(membrane.orthotropy->shear, fabric.shear_modulus);
    EXPECT_EQ(membrane.parameter, fabric.poisson_ratio);
    EXPECT_EQ(plate.type, "plate");
    EXPECT_EQ(plate.rigidity, fabric.rigidity[0]);
    EXPECT_EQ(plate.orthotropy->across, fabric.rigidity[1]);
    EXPECT_EQ(plate.orthotropy->shear, fabric.twisting_rigidity);
  }
}

TEST(Material, GivesWayToWhatTheBodySaysItself) {
  const BodySpec heavy = parsed_body({{"material", "black denim"}, {"mass", 3}});
  EXPECT_EQ(heavy.mass, 3);
  EXPECT_FALSE(heavy.density);
  const auto types = [](const Json& constraint) {
    std::vector<std::string> all;
    for (const ConstraintSpec& one :
         parsed_body({{"material", "black denim"}, {"constraints", {constraint}}}).constraints)
      all.push_back(one.type);
    return all;
  };
  using Types = std::vector<std::string>;
  EXPECT_EQ(types({{"type", "membrane"}, {"young_modulus", 7}}), (Types{"membrane", "plate"}));
  EXPECT_EQ(types({{"type", "distance"}}), (Types{"distance", "plate"}));
  EXPECT_EQ(types({{"type", "plate"}, {"rigidity", 1}}), (Types{"plate", "membrane"}));
  EXPECT_EQ(types({{"type", "isometric_bending"}, {"rigidity", 1}}), (Types{"isometric_bending", "membrane"}));
  EXPECT_EQ(types({{"type", "distance_limit"}}), (Types{"distance_limit", "membrane", "plate"}));
}

TEST(Material, IsWrittenAndReadBack) {
  const Scene scene = parse_scene(scene_of_fabric({{"material", "ivory rib knit"}}).dump(), "s.json", "");
  const Scene again = parse_scene(to_json(scene), "s.json", "");
  EXPECT_EQ(again.bodies[0].material, "ivory rib knit");
  EXPECT_EQ(to_json(again), to_json(scene));
}

TEST(Material, OfCodeIsThatOfAScene) {
  BodySpec body;
  body.name = "cloth", body.shape = GridShape{{1, 1}, {8, 8}};
  apply_material(body, "white swim solid");
  EXPECT_EQ(to_json(scene_of({body}, kEarth, 0.01)),
            to_json(scene_of({parsed_body({{"material", "white swim solid"}})}, kEarth, 0.01)));
  EXPECT_NE(refusal([&] { apply_material(body, "white swimm solid"); }).find("did you mean 'white swim solid'"),
            std::string::npos);
}

TEST(Material, ThatDoesNotExistOrDoesNotFitIsRefused) {
  const std::string unknown = refusal([] { parsed_body({{"material", "gray interlok"}}); });
  EXPECT_NE(unknown.find("s.json: /bodies/0/material: found unknown material"), std::string::npos) << unknown;
  EXPECT_NE(unknown.find("did you mean 'gray interlock'"), std::string::npos) << unknown;
  const std::string solid = refusal([] {
    BodySpec body = parsed_body(
        {{"material", "black denim"}, {"shape", {{"tet_box", {{"size", {1, 1, 1}}, {"cells", {1, 1, 1}}}}}}});
    build_model(scene_of({body}, kEarth, 0.01));
  });
  EXPECT_NE(solid.find("/bodies/0/material"), std::string::npos) << solid;
  EXPECT_NE(refusal([] {
              parsed_body({{"material", "black denim"},
                           {"shape", {{"lattice", {{"min", {0, 0, 0}}, {"max", {1, 1, 0}}, {"count", {2, 3, 1}}}}}}});
            }).find("/bodies/0/material: found a density of loose particles"),
            std::string::npos);
}

}  // namespace
}  // namespace malha
