// SPDX-License-Identifier: Apache-2.0
// Bodies whose rest shape is not that of their start.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "host/base/build_info.h"
#include "host/mesh/generate.h"
#include "host/mesh/topology.h"
#include "host/mesh/vectors.h"
#include "host/model/build_constraints.h"
#include "host/model/stencils.h"
#include "malha/scene.h"
#include "tests/model/rest_patterns.h"
#include "tests/refusal.h"
#include "tests/same_bits.h"
#include "tests/support.h"

namespace malha {
namespace {

constexpr double kRigidity = 1e-4;  // N m

Scene scene_at_rest(BodySpec body, Precision precision = Precision::Double) {
  return scene_of({std::move(body)}, {0, 0, 0}, 1.0 / 60, 10, precision);
}

double elastic_at_start(const BodySpec& body) {
  return Simulation(scene_at_rest(body), {.threads = 1}).measure().elastic;
}

/// The energy of a flat plate rolled up, D / (2 r^2) an area.
double energy_of_rolling(const RolledPattern& pattern) {
  return kRigidity / (2 * pattern.radius * pattern.radius) * pattern.area();
}

// Wide enough in cells that the rim, whose curvature is that of the triangles next to it, does not count.
RolledPattern half_pipe(Cells cells) { return rolled_pattern(kPi * 0.2, 0.5, 0.2, 48, 40, false, cells); }
RolledPattern tube(Cells cells) { return rolled_pattern(2 * kPi * 0.2, 0.5, 0.2, 96, 40, true, cells); }

BodySpec tube_by_uv(const RolledPattern& pattern, const TemporaryFolder& folder,
                    std::vector<ConstraintSpec> constraints) {
  BodySpec body = rolled_body(pattern, std::move(constraints));
  body.shape = MeshFile{folder.write("tube.obj", pattern.obj(0.5))}, body.rest = RestUv{0.5};
  return body;
}

ConstraintSpec bending_of_rigidity(const std::string& type) {
  ConstraintSpec spec = stiff(type);
  spec.rigidity = kRigidity;
  return spec;
}

TEST(BodyRest, FlatPlateOnACylinderHasTheEnergyOfAPlate) {
  for (const Cells cells : {Cells::Quads, Cells::Triangles, Cells::Irregular}) {
    const RolledPattern pattern = half_pipe(cells);
    EXPECT_NEAR(elastic_at_start(rolled_body(pattern, {plate_of(kRigidity)})) / energy_of_rolling(pattern), 1, 0.02)
        << "cells " << static_cast<int>(cells);
  }
}

TEST(BodyRest, FlatHingesOnACylinderHaveTheEnergyOfAPlate) {
  // Of the hinges only those of quads are isotropic (host/model/material.h). They bend all but half a column of cells
  // at either rim, which has no neighbour.
  const RolledPattern pattern = half_pipe(Cells::Quads);
  const double bent = energy_of_rolling(pattern) * (pattern.across - 1) / pattern.across;
  for (const char* type : {"bending", "isometric_bending"})
    EXPECT_NEAR(elastic_at_start(rolled_body(pattern, {bending_of_rigidity(type)})) / bent, 1, 2e-3) << type;
}

TEST(BodyRest, MembraneHasTheEnergyOfItsStretchFromThePattern) {
  const double Y = 50, nu = 0.3, e = 0.1;
  RolledPattern pattern = rolled_pattern(1, 0.7, 1, 12, 9, false, Cells::Irregular);
  pattern.start = pattern.flat;
  for (Vec3& x : pattern.start) x = {3, x[1], (1 + e) * x[0]};  // in another plane
  EXPECT_NEAR(elastic_at_start(rolled_body(pattern, {membrane_of(Y, nu)})),
              pattern.area() * Y * e * e / (2 * (1 - nu * nu)), 1e-12);
}

TEST(BodyRest, BendingIsFilteredWithTheEnergyOfThePattern) {
  const RolledPattern pattern = half_pipe(Cells::Irregular);
  for (const char* solver : {"pbd", "desbrun"}) {
    Scene scene = scene_at_rest(rolled_body(pattern, {plate_of(kRigidity)}));
    scene.solver.type = solver, scene.solver.bending = BendingMethod::Filtered;
    const Simulation simulation(scene, {.threads = 1});
    ASSERT_FALSE(simulation.model().stencils.empty());
    EXPECT_NEAR(simulation.measure().elastic / energy_of_rolling(pattern), 1, 0.02) << solver;
  }
}

TEST(BodyRest, ClosedTubeOfAFlatPatternHasTheEnergyOfAPlate) {
  const TemporaryFolder folder;
  for (const Cells cells : {Cells::Quads, Cells::Triangles, Cells::Irregular}) {
    const RolledPattern pattern = tube(cells);
    EXPECT_NEAR(elastic_at_start(tube_by_uv(pattern, folder, {plate_of(kRigidity)})) / energy_of_rolling(pattern), 1,
                0.02)
        << "cells " << static_cast<int>(cells);
  }
  const RolledPattern pattern = tube(Cells::Quads);
  for (const char* type : {"bending", "isometric_bending"})
    EXPECT_NEAR(elastic_at_start(tube_by_uv(pattern, folder, {bending_of_rigidity(type)})) / energy_of_rolling(pattern),
                1, 0.02)
        << type;
}

/// The energy over the compliance of each constraint of the kind that lies in the middle third of the tube.
template <class Kind>
std::vector<double> energies_in_the_middle(const Model& model, double height) {
  std::vector<double> found;
  for (const ConstraintSet& set : model.sets) {
    if (set.type != Kind::name) continue;
    for (int c = 0; c < set.count(); ++c) {
      double rest[Kind::rest_values];
      rest_values<Kind>(rest_positions(model, set), c, set.parameter, rest);
      Vector3<double> q[Kind::particles], grad[Kind::particles];
      corners<Kind>(model.x.data(), &set.particles[std::size_t(c) * Kind::particles], q);
      if (q[0].z < height / 3 || q[0].z > 2 * height / 3) continue;
      double scale;
      const double C = Kind::evaluate(q, rest, true, grad, scale);
      found.push_back(C * C / (scale * scale) / set.alpha(c));
    }
  }
  return found;
}

TEST(BodyRest, TubeIsUniformAcrossItsSeam) {
  const TemporaryFolder folder;
  const RolledPattern pattern = tube(Cells::Triangles);
  Scene scene = scene_at_rest(tube_by_uv(pattern, folder, {plate_of(kRigidity), membrane_of(10)}));
  scene.solver.bending = BendingMethod::Projected;
  const Model model = build_model(scene);
  for (const auto& energies : {energies_in_the_middle<Plate>(model, pattern.height),
                               energies_in_the_middle<Membrane>(model, pattern.height)}) {
    ASSERT_GT(energies.size(), 96u);
    // The two triangles of a cell are mirror images of each other, up to the rounding of the file.
    const auto [least, most] = std::ranges::minmax(energies);
    EXPECT_NEAR(least / most, 1, 1e-6);
  }
}

TEST(BodyRest, MassIsThatOfTheAreaAtRest) {
  const TemporaryFolder folder;
  const RolledPattern pattern = tube(Cells::Irregular);
  BodySpec body = tube_by_uv(pattern, folder, {});
  body.transform.scale = {3, 3, 3};  // does not apply to the pattern
  const Model model = build_model(scene_at_rest(body));
  EXPECT_NEAR(std::accumulate(model.mass.begin(), model.mass.end(), 0.0), *body.density * pattern.area(), 1e-9);
  // A column at the seam has as much as any other, though its places are at both ends of the pattern.
  std::vector<double> mass(model.mass.size());
  const RolledPattern regular = tube(Cells::Quads);
  const Model even = build_model(scene_at_rest(tube_by_uv(regular, folder, {})));
  for (std::size_t i = 0; i < mass.size(); ++i) mass[even.user_index[i]] = even.mass[i];
  const auto row = mass.begin() + 20 * regular.across;
  for (int i = 1; i < regular.across; ++i) EXPECT_NEAR(row[i] / row[0], 1, 1e-9);
}

TEST(BodyRest, LengthsAreThoseOfThePattern) {
  const TemporaryFolder folder;
  const RolledPattern pattern = tube(Cells::Quads);
  BodySpec body = tube_by_uv(pattern, folder, {compliant("distance", 1e-3, {"edges", "shear"})});
  const double a = pattern.width / pattern.across, b = pattern.height / pattern.along;
  for (const char* solver : {"pbd", "desbrun"}) {
    Scene scene = scene_at_rest(body);
    scene.solver.type = solver;
    const Model model = build_model(scene);
    std::vector<double> lengths;
    for (const ConstraintSet& set : model.sets)
      for (int c = 0; c < set.count(); ++c) lengths.push_back(rest_value<Distance>(rest_positions(model, set), c, 1));
    for (const SpringSet& set : model.springs) lengths.insert(lengths.end(), set.rest.begin(), set.rest.end());
    EXPECT_EQ(lengths.size(), std::size_t(96 * (40 + 41 + 80))) << solver;
    for (const double length : lengths)
      EXPECT_LT(std::min({std::abs(length - a), std::abs(length - b), std::abs(length - std::hypot(a, b))}), 1e-12);
  }
}

TEST(BodyRest, BallWithASmallerRestShrinksToIt) {
  Scene scene = scene_of({}, {0, 0, 0}, 1.0 / 60, 20);
  BodySpec ball;
  ball.name = "ball", ball.shape = SphereShape{0.5, 3}, ball.mass = 1, ball.damping = 0.2;
  std::vector<Vec3> small = generate(ball.shape).points;
  for (Vec3& x : small)
    for (double& k : x) k *= 0.6;
  ball.rest = RestPoints{small};
  // So soft that it does not overshoot: a ball that overshoots buckles.
  ball.constraints = {compliant("distance", 2, {"edges"})};
  ball.constraints.push_back(bending_of_rigidity("bending"));
  scene.bodies = {ball};
  const Simulation simulation = after(scene, 5);
  double farthest = 0, nearest = 1;
  for (const Vec3& x : simulation.positions())
    farthest = std::max(farthest, length(x)), nearest = std::min(nearest, length(x));
  EXPECT_NEAR(nearest, 0.3, 1e-3);
  EXPECT_NEAR(farthest, 0.3, 1e-3);
  EXPECT_LT(simulation.measure().strain_max, 5e-3);
}

TEST(BodyRest, JellyWithASmallerRestShrinksToItsVolume) {
  BodySpec jelly;
  jelly.name = "jelly", jelly.shape = TetBoxShape{{1, 1, 1}, {3, 3, 3}}, jelly.density = 1000, jelly.damping = 0.2;
  std::vector<Vec3> small = generate(jelly.shape).points;
  for (Vec3& x : small)
    for (double& k : x) k = 7 + 0.8 * k;  // somewhere else, which does not matter
  jelly.rest = RestPoints{small};
  ConstraintSpec material = stiff("neo_hookean", {}, 1, 0.3);
  material.young_modulus = 1e5;
  jelly.constraints = {material};
  Scene scene = scene_of({jelly}, {0, 0, 0}, 1.0 / 60, 20);
  Simulation simulation(scene, {.threads = 1});
  EXPECT_NEAR(simulation.measure().volume_ratios.at(0), 1 / std::pow(0.8, 3), 1e-9);
  run_for(simulation, scene, 2);
  EXPECT_NEAR(simulation.measure().volume_ratios.at(0), 1, 1e-3);
  const std::vector<double> w = simulation.inverse_masses();
  double mass = 0;
  for (const double inverse : w) mass += 1 / inverse;
  EXPECT_NEAR(mass, 1000 * std::pow(0.8, 3), 1e-6);
}

TEST(BodyRest, BalloonTakesTheVolumeOfItsRestShape) {
  BodySpec ball;
  ball.name = "ball", ball.shape = SphereShape{0.5, 2}, ball.mass = 1;
  std::vector<Vec3> large = generate(ball.shape).points;
  for (Vec3& x : large)
    for (double& k : x) k *= 1.1;
  ball.rest = RestPoints{large};
  ball.constraints = {compliant("pressure", 0)};
  const Scene scene = scene_of({ball}, {0, 0, 0}, 1.0 / 60, 10);
  Simulation simulation(scene, {.threads = 1});
  EXPECT_NEAR(simulation.measure().volume_ratios.at(0), 1 / std::pow(1.1, 3), 1e-9);
  run_for(simulation, scene, 0.1);
  EXPECT_NEAR(simulation.measure().volume_ratios.at(0), 1, 1e-3);
}

TEST(BodyRest, FlatSpringThatRestsBentBendsToIt) {
  RolledPattern pattern = rolled_pattern(kPi * 0.2, 0.1, 0.2, 32, 4, false, Cells::Quads);
  std::swap(pattern.start, pattern.flat);  // starts flat, rests as half a circle
  BodySpec body = rolled_body(pattern, {membrane_of(100), plate_of(1e-2)});
  body.damping = 0.1;
  const Scene scene = scene_at_rest(body);
  const Simulation simulation = after(scene, 3);
  const std::vector<Vec3> x = simulation.positions();
  EXPECT_NEAR(distance(x[0], x[32]), 0.4, 0.004) << "its ends are a diameter apart";
  EXPECT_LT(simulation.measure().elastic, 1e-4 * 1e-2 / (2 * 0.04) * pattern.area()) << "of that of its start";
}

TEST(BodyRest, TextureCoordinatesAreTheBitsOfTheirPoints) {
  const TemporaryFolder folder;
  const RolledPattern pattern = half_pipe(Cells::Irregular);
  BodySpec by_points = rolled_body(pattern, {plate_of(kRigidity), membrane_of(50)});
  by_points.shape = MeshFile{folder.write("sheet.obj", pattern.obj())};
  BodySpec by_uv = by_points, by_mesh = by_points;
  by_uv.rest = RestUv{1};
  RolledPattern flat = pattern;
  flat.start = flat.flat;
  by_mesh.rest = RestMesh{folder.write("pattern.obj", flat.obj())};
  const auto hash = [](const BodySpec& body) { return after(scene_at_rest(body), 0.1).state_hash(); };
  const std::uint64_t wanted = hash(by_points);
  EXPECT_EQ(hash(by_uv), wanted);
  EXPECT_EQ(hash(by_mesh), wanted);
}

TEST(BodyRest, TextureCoordinatesOfGltf) {
  if (!has_gltf()) GTEST_SKIP() << "built without tinygltf";
  const TemporaryFolder folder;
  // A sheet without seams has the bits of its listed points, as they are in the file: in float.
  const RolledPattern sheet = half_pipe(Cells::Irregular);
  BodySpec by_uv = rolled_body(sheet, {plate_of(kRigidity), membrane_of(50)});
  by_uv.shape = MeshFile{folder.write("sheet.glb", sheet.glb())}, by_uv.rest = RestUv{2};
  BodySpec by_points = by_uv;
  std::vector<Vec3> points = sheet.flat;
  for (Vec3& x : points)
    for (double& k : x) k = 2 * static_cast<double>(static_cast<float>(k));
  by_points.rest = RestPoints{points};
  const auto hash = [](const BodySpec& body) { return after(scene_at_rest(body), 0.1).state_hash(); };
  EXPECT_EQ(hash(by_uv), hash(by_points));
  // A tube has vertices of its own at both sides of its seam, which are welded.
  const RolledPattern pattern = tube(Cells::Triangles);
  BodySpec body = rolled_body(pattern, {plate_of(kRigidity)});
  body.shape = MeshFile{folder.write("tube.glb", pattern.glb()), 0.0}, body.rest = RestUv{1};
  EXPECT_NEAR(elastic_at_start(body) / energy_of_rolling(pattern), 1, 0.02);
  EXPECT_EQ(build_model(scene_at_rest(body)).count(), 96 * 41);
  body.shape = MeshFile{folder.write("tube.glb", pattern.glb(false)), 0.0};
  const std::string said = refusal([&] { build_model(scene_at_rest(body)); });
  EXPECT_TRUE(has(said, "found no texture coordinates; allowed: TEXCOORD_0")) << said;
}

TEST(BodyRest, MeshOfWeldedPiecesHasSeams) {
  const TemporaryFolder folder;
  // The file's pieces are welded at the start, and lie apart in the pattern.
  const RolledPattern pattern = tube(Cells::Irregular);
  RolledPattern unwelded = pattern, flat = pattern;
  unwelded.start = pattern.start_of_places(), unwelded.faces = unwelded.corners;
  flat.start = pattern.flat, flat.faces = flat.corners;
  BodySpec body = tube_by_uv(pattern, folder, {plate_of(kRigidity), membrane_of(50)});
  const double wanted = elastic_at_start(body);
  body.shape = MeshFile{folder.write("unwelded.obj", unwelded.obj()), 0.0};
  body.rest = RestMesh{folder.write("pattern.obj", flat.obj())};
  EXPECT_NEAR(elastic_at_start(body) / wanted, 1, 1e-9);
  body.rest = RestPoints{pattern.flat};
  EXPECT_NEAR(elastic_at_start(body) / wanted, 1, 1e-9);
}

TEST(BodyRest, StartAsRestIsNoRest) {
  const RolledPattern pattern = half_pipe(Cells::Irregular);
  BodySpec without = rolled_body(pattern, {plate_of(kRigidity), membrane_of(50)});
  without.pins = {ListPin{{0}}};
  BodySpec with = without;
  with.rest = RestPoints{pattern.start}, without.rest.reset();
  const auto hash = [](const BodySpec& body) {
    Scene scene = scene_at_rest(body);
    scene.gravity = kEarth;
    return after(scene, 0.1).state_hash();
  };
  EXPECT_EQ(hash(with), hash(without));
}

TEST(BodyRest, OfOneBodyChangesNoOther) {
  const auto ends_at = [](bool rests) {
    BodySpec cloth = rolled_body(half_pipe(Cells::Quads), {plate_of(kRigidity), membrane_of(50)});
    if (!rests) cloth.rest.reset();
    BodySpec plain = cloth;
    plain.name = "plain", plain.rest.reset(), plain.velocity = {1, 2, 3}, plain.spin = {3, 2, 1};
    const std::vector<Vec3> x = after(scene_of({cloth, plain}, kEarth, 1.0 / 60), 0.1).positions();
    return std::vector<Vec3>(x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2), x.end());
  };
  EXPECT_EQ(ends_at(true), ends_at(false));
}

TEST(BodyRest, QuadsAndTrianglesMayBeMixed) {
  const TemporaryFolder folder;
  RolledPattern pattern = tube(Cells::Quads);
  const auto split = [](std::vector<std::vector<int>>& faces) {
    for (std::size_t f = 0; f < 96 * 40; f += 3) {
      const std::vector<int> quad = faces[f];
      faces[f] = {quad[0], quad[1], quad[2]}, faces.push_back({quad[0], quad[2], quad[3]});
    }
  };
  split(pattern.faces), split(pattern.corners);
  EXPECT_NEAR(elastic_at_start(tube_by_uv(pattern, folder, {plate_of(kRigidity)})) / energy_of_rolling(pattern), 1,
              0.02);
}

TEST(BodyRest, MirroredPieceOfAPatternIsTheSame) {
  const TemporaryFolder folder;
  const RolledPattern pattern = tube(Cells::Irregular);
  // The right half becomes an island of its own, turned over.
  RolledPattern mirrored = pattern;
  const auto places = static_cast<int>(pattern.flat.size());
  for (const Vec3& x : pattern.flat) mirrored.flat.push_back({5 - x[0], x[1] + 3, 0});
  for (std::size_t f = 0; f < pattern.faces.size(); ++f)
    if (std::ranges::all_of(pattern.corners[f], [](int c) { return c % 97 >= 48; }))
      for (int& corner : mirrored.corners[f]) corner += places;
  const std::vector<ConstraintSpec> all{plate_of(kRigidity), membrane_of(50), bending_of_rigidity("bending")};
  const double wanted = elastic_at_start(tube_by_uv(pattern, folder, all));
  EXPECT_NEAR(elastic_at_start(tube_by_uv(mirrored, folder, all)) / wanted, 1, 1e-9);
}

TEST(BodyRest, PatternLaidDoubleIsFlatAtItsFold) {
  const TemporaryFolder folder;
  // A strip of two cells whose second cell lies on the first one in the pattern, as the back of a garment on its front.
  const std::string obj =
      "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\n"
      "vt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\n"
      "f 1/1 2/2 5/4 4/3\nf 2/2 3/1 6/3 5/4\n";
  BodySpec body;
  body.name = "strip", body.shape = MeshFile{folder.write("strip.obj", obj)}, body.mass = 1, body.rest = RestUv{1};
  body.constraints = {bending_of_rigidity("bending")};
  EXPECT_NEAR(elastic_at_start(body), 0, 1e-18);
}

TEST(BodyRest, TethersReachAsFarAsThePattern) {
  const TemporaryFolder folder;
  const RolledPattern pattern = tube(Cells::Irregular);
  for (const double larger : {1.0, 0.5}) {
    BodySpec body = tube_by_uv(pattern, folder, {stiff("long_range", {}, 1, 0)});
    body.transform.scale = {larger, larger, larger};
    body.pins = {ListPin{{0}}};
    const Model model = build_model(scene_at_rest(body));
    // From vertex 0 across the seam is as far as the other way round, and never farther than half the tube.
    double most = 0;
    for (std::size_t k = 0; k < model.long_range.particle.size(); ++k) {
      const int user = model.user_index[model.long_range.particle[k]];
      const double reach = model.long_range.max_distance[k];
      if (user < 96) {
        EXPECT_NEAR(reach, std::min(user, 96 - user) * pattern.width / 96, 1e-6);
      }
      most = std::max(most, reach);
    }
    EXPECT_NEAR(most, std::hypot(pattern.width / 2, pattern.height), 1e-3);
  }
}

TEST(BodyRest, EdgeTearsAtItsLengthInThePattern) {
  RolledPattern pattern = rolled_pattern(1, 1, 1, 8, 8, false, Cells::Quads);
  pattern.start = pattern.flat;
  for (Vec3& x : pattern.start) x[0] *= 1.3;  // below the strain that tears
  BodySpec body = rolled_body(pattern, {compliant("distance", 1e-2, {"edges"})});
  body.tear = Tear{0.2};
  Scene scene = scene_at_rest(body);
  Simulation torn(scene, {.threads = 1});
  torn.step();
  EXPECT_GT(torn.tears(), 0) << "at the start its edges are 30 % longer than at rest";
  // What is torn rests at the lengths of the pattern as before.
  const Model& model = torn.model();
  ASSERT_EQ(model.sets.size(), 1u);
  EXPECT_GT(model.sets[0].count(), 2 * 8 * 9) << "edges along the tear are two";
  for (int c = 0; c < model.sets[0].count(); ++c)
    EXPECT_NEAR(rest_value<Distance>(rest_positions(model, model.sets[0]), c, 1), 0.125, 1e-12);
  double mass = 0;
  for (const double w : torn.inverse_masses()) mass += 1 / w;
  EXPECT_NEAR(mass, *body.density * pattern.area(), 1e-9);
  scene.bodies[0].rest.reset();
  Simulation whole_sheet(scene, {.threads = 1});
  whole_sheet.step();
  EXPECT_EQ(whole_sheet.tears(), 0);
}

TEST(BodyRest, NotesAStartFarFromItAndEase) {
  const TemporaryFolder folder;
  RolledPattern pattern = rolled_pattern(2 * kPi, 1, 1, 12, 2, true, Cells::Quads);
  BodySpec body = tube_by_uv(pattern, folder, {plate_of(kRigidity)});
  const auto notes = [&] {
    std::string all;
    for (const std::string& note : build_model(scene_at_rest(body)).notes) all += note + "\n";
    return all;
  };
  EXPECT_FALSE(has(notes(), "\"rest\"")) << notes();
  body.transform.scale = {1, 1, 2};
  EXPECT_TRUE(has(notes(), "is 2 times as long as in its \"rest\"")) << notes();
  body.transform.scale = {1, 1, 1};
  for (Vec3& x : pattern.flat)
    if (x[0] > 6) x[1] *= 1.1;  // the last column
  body.shape = MeshFile{folder.write("tube.obj", pattern.obj(0.5))};
  EXPECT_TRUE(has(notes(), "10 % longer on one side of a seam")) << notes();
}

TEST(BodyRest, SelfCollisionLetsPartsLieAsNearAsAtRest) {
  // A coarse sheet that rests at a third of its size: its rings are then nearer than the thickness.
  RolledPattern pattern = rolled_pattern(0.3, 0.3, 1, 12, 12, false, Cells::Quads);
  pattern.start = pattern.flat;
  for (Vec3& x : pattern.start) x[0] *= 3, x[1] *= 3;
  BodySpec body = rolled_body(pattern, {compliant("distance", 1e-5, {"edges", "shear"})});
  body.damping = 0.3;
  Scene scene = scene_at_rest(body);
  scene.self_collision = SelfCollision{0.04, 0, {}, false};
  const Simulation simulation = after(scene, 2);
  EXPECT_LT(simulation.measure().strain_max, 0.02);
  EXPECT_EQ(simulation.measure().self_contacts, 0);
}

TEST(BodyRest, LevelsHangAClothByTheLengthsOfItsPattern) {
  RolledPattern pattern = rolled_pattern(1, 1, 1, 30, 30, false, Cells::Quads);
  pattern.start = pattern.flat;
  for (Vec3& x : pattern.start)
    for (double& k : x) k *= 0.9;  // starts slack
  BodySpec body = rolled_body(pattern, {stiff("distance", {"edges", "shear"})});
  std::vector<int> held(31);
  std::iota(held.begin(), held.end(), 31 * 30);
  body.pins = {ListPin{held}};
  body.damping = 0.05;
  Scene scene = scene_at_rest(body);
  scene.gravity = kEarth, scene.solver.levels = 3;
  const Simulation simulation = after(scene, 3);
  const std::vector<Vec3> x = simulation.positions();
  EXPECT_NEAR(x[31 * 30 + 15][1] - x[15][1], 1, 0.02) << "it hangs as long as it is at rest";
  EXPECT_LT(simulation.measure().strain_rms, 0.05);
}

// Refusals.

std::string refused(const BodySpec& body) {
  return refusal([&] { build_model(scene_of({body}, {0, 0, 0}, 0.01)); });
}

TEST(BodyRestRefusals, PointsOfAnotherNumber) {
  BodySpec body = rolled_body(half_pipe(Cells::Quads), {});
  std::get<RestPoints>(*body.rest).points.pop_back();
  const std::string said = refused(body);
  EXPECT_TRUE(has(said, "/bodies/0/rest/points")) << said;
  EXPECT_TRUE(has(said, "a list of 2008; allowed: a place for each of the 2009 vertices")) << said;
}

TEST(BodyRestRefusals, FileOfAnotherTopology) {
  const TemporaryFolder folder;
  const RolledPattern pattern = rolled_pattern(1, 1, 1, 2, 2, false, Cells::Quads);
  BodySpec body = rolled_body(pattern, {});
  const auto with = [&](const RolledPattern& rest) {
    body.rest = RestMesh{folder.write("pattern.obj", rest.obj())};
    return refused(body);
  };
  EXPECT_EQ(with(pattern), "");
  RolledPattern other = pattern;
  std::ranges::rotate(other.faces[1], other.faces[1].begin() + 1);
  EXPECT_TRUE(has(with(other), "pattern.obj: face 1 (0-based): found the vertices 2, 5, 4, 1; allowed: 1, 2, 5, 4"))
      << with(other);
  other = pattern;
  other.faces.pop_back(), other.corners.pop_back();
  EXPECT_TRUE(has(with(other), "found 3 faces; allowed: 4 as of")) << with(other);
  other = pattern;
  other.start.push_back({0, 0, 5});
  EXPECT_TRUE(has(with(other), "found 10 vertices; allowed: 9 as of")) << with(other);
}

TEST(BodyRestRefusals, PatternsWithoutArea) {
  const TemporaryFolder folder;
  RolledPattern pattern = rolled_pattern(1, 1, 1, 2, 2, true, Cells::Triangles);
  for (int k = 0; k < 3; ++k) {
    pattern.corners[3][k] = static_cast<int>(pattern.flat.size());
    pattern.flat.push_back({0.1 * k, 0.2 * k, 0});
  }
  BodySpec body = rolled_body(pattern, {});
  body.shape = MeshFile{folder.write("tube.obj", pattern.obj())}, body.rest = RestUv{1};
  EXPECT_TRUE(has(refused(body), "/bodies/0/rest: found face 3 (0-based) without area")) << refused(body);
}

TEST(BodyRestRefusals, CornersWithoutTextureCoordinates) {
  const TemporaryFolder folder;
  BodySpec body;
  body.name = "sheet", body.mass = 1, body.rest = RestUv{1};
  const auto with = [&](const std::string& faces, const std::string& name = "sheet.obj") {
    body.shape =
        MeshFile{folder.write(name, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\n" + faces)};
    return refused(body);
  };
  EXPECT_EQ(with("f 1/1 2/2 3/3\nf 2/-3 4/-1 3/-2\n"), "");
  EXPECT_TRUE(
      has(with("f 1/1 2/2 3/3\nf 2/2 4 3/3\n"),
          "face 1 (0-based): found a corner without texture coordinates; allowed: texture coordinates at each corner"))
      << with("f 1/1 2/2 3/3\nf 2/2 4 3/3\n");
  EXPECT_TRUE(has(with("f 1/1 2/2 3/3\nf 2/2 4/5 3/3\n"), "found texture coordinates 5; allowed: 1 to 4"));
  EXPECT_TRUE(has(with("f 1/1 2/0 3/3\n"), "line 9, column")) << with("f 1/1 2/0 3/3\n");
  EXPECT_TRUE(has(with("f 1/1 2/2 3/3\nl 3 4\n"), "texture coordinates for lines"));
  body.shape = MeshFile{folder.write("bare.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")};
  EXPECT_TRUE(has(refused(body), "bare.obj: found no texture coordinates")) << refused(body);
  body.shape = MeshFile{folder.write("sheet.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")};
  EXPECT_TRUE(has(refused(body), "texture coordinates of a file with the extension \".off\"")) << refused(body);
}

TEST(BodyRestRefusals, InvertedTetrahedraAndMergedLines) {
  BodySpec jelly;
  jelly.name = "jelly", jelly.shape = TetBoxShape{{1, 1, 1}, {1, 1, 1}}, jelly.mass = 1;
  std::vector<Vec3> inverted = generate(jelly.shape).points;
  for (Vec3& x : inverted) x[0] = -x[0];
  jelly.rest = RestPoints{inverted};
  EXPECT_TRUE(has(refused(jelly), "tetrahedron 0 (0-based) with a volume of -0.")) << refused(jelly);

  const TemporaryFolder folder;
  BodySpec rope;
  rope.name = "rope", rope.mass = 1;
  rope.shape = MeshFile{folder.write("rope.obj", "v 0 0 0\nv 1 0 0\nv 1 0 0\nv 2 0 0\nl 1 2\nl 3 4\n"), 0.0};
  rope.rest = RestPoints{{{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {2, 0, 0}}};
  EXPECT_EQ(refused(rope), "");
  std::get<RestPoints>(*rope.rest).points[2][1] = 1;
  EXPECT_TRUE(has(refused(rope), "merged vertices with different places at rest")) << refused(rope);
  std::get<RestPoints>(*rope.rest).points = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {2, 0, 0}};
  EXPECT_TRUE(has(refused(rope), "line 0 (0-based) without length")) << refused(rope);
}

TEST(BodyRestRefusals, PressureInAFlatRest) {
  BodySpec ball;
  ball.name = "ball", ball.shape = SphereShape{0.5, 1}, ball.mass = 1, ball.constraints = {compliant("pressure", 0)};
  std::vector<Vec3> flat = generate(ball.shape).points;
  for (Vec3& x : flat) x[2] *= -1;  // inside out
  ball.rest = RestPoints{flat};
  EXPECT_TRUE(has(refused(ball), "/bodies/0/rest: found a rest shape that encloses -0.")) << refused(ball);
}

TEST(BodyRestRefusals, InScenes) {
  const auto said = [](const std::string& shape, const std::string& rest) {
    return refusal([&] {
      parse_scene(R"({"name": "a", "solver": {"type": "pbd"}, "duration": 1, "bodies": [{"name": "b", "mass": 1,
                    "shape": )" +
                      shape + R"(, "rest": )" + rest + "}]}",
                  "scene.json", "");
    });
  };
  const std::string mesh = R"({"mesh": "a.obj"})", grid = R"({"grid": {"size": [1, 1], "cells": [1, 1]}})",
                    loose = R"({"lattice": {"min": [0, 0, 0], "max": [1, 1, 1], "count": [2, 2, 2]}})";
  EXPECT_EQ(said(mesh, R"({"uv": 2})"), "");
  EXPECT_EQ(said(mesh, R"({"mesh": "b.obj"})"), "");
  EXPECT_EQ(said(grid, R"({"points": [[0, 0, 0], [1, 0, 0], [0, 0, 1], [1, 0, 1]]})"), "");
  EXPECT_TRUE(has(said(grid, R"({"uv": 2})"), "/bodies/0/rest/uv: found 'uv' beside a shape without texture"));
  EXPECT_TRUE(has(said(mesh, R"({"uv": 0})"), "/bodies/0/rest/uv"));
  EXPECT_TRUE(has(said(loose, R"({"points": []})"), "/bodies/0/rest: found 'rest' of loose particles"));
  EXPECT_TRUE(has(said(mesh, R"({"uv": 1, "mesh": "b.obj"})"), "/bodies/0/rest"));
  EXPECT_TRUE(has(said(mesh, R"({})"), "/bodies/0/rest"));
  EXPECT_TRUE(has(said(mesh, R"({"points": [[0, 0]]})"), "/bodies/0/rest/points/0"));
}

TEST(BodyRest, IsWrittenBack) {
  const std::string text = R"({"name": "a", "solver": {"type": "pbd"}, "duration": 1, "bodies": [
      {"name": "b", "mass": 1, "shape": {"mesh": "m/a.obj"}, "rest": {"uv": 2}},
      {"name": "c", "mass": 1, "shape": {"mesh": "m/a.obj"}, "rest": {"mesh": "m/b.obj"}},
      {"name": "d", "mass": 1, "shape": {"mesh": "m/a.obj"}, "rest": {"points": [[1, 2, 3]]}}]})";
  const Scene scene = parse_scene(text, "scene.json", "");
  const Scene again = parse_scene(to_json(scene), "scene.json", "");
  EXPECT_EQ(std::get<RestUv>(again.bodies[0].rest.value()).metres, 2);
  EXPECT_TRUE(has(std::get<RestMesh>(again.bodies[1].rest.value()).path, "m/b.obj"));
  EXPECT_EQ(std::get<RestPoints>(again.bodies[2].rest.value()).points, (std::vector<Vec3>{{1, 2, 3}}));
  EXPECT_EQ(to_json(scene), to_json(again));
}

INSTANTIATE_TEST_SUITE_P(
    BodyRest, SameBits,
    testing::Values(SameBitsScene{"TubeOfAPatternThatTears",
                                  [](const TemporaryFolder& folder) {
                                    const RolledPattern pattern =
                                        rolled_pattern(2 * kPi * 0.2, 0.5, 0.2, 24, 20, true, Cells::Irregular);
                                    BodySpec body = tube_by_uv(pattern, folder, {plate_of(kRigidity), membrane_of(20)});
                                    body.constraints.push_back(compliant("distance", 1e-2, {"edges"}));
                                    body.tear = Tear{0.05};
                                    body.pins = {ListPin{{0, 1, 2, 3}}};
                                    return scene_of({body}, kEarth, 0.01, 4, Precision::Float);
                                  },
                                  60,
                                  {10, 40},
                                  [](const Simulation& simulation) { EXPECT_GT(simulation.tears(), 0); }},
                    SameBitsScene{"SmallerBallByDesbrun",
                                  [](const TemporaryFolder&) {
                                    BodySpec ball;
                                    ball.name = "ball", ball.shape = SphereShape{0.5, 3}, ball.mass = 1;
                                    std::vector<Vec3> small = generate(ball.shape).points;
                                    for (Vec3& x : small) x[1] *= 0.7;
                                    ball.rest = RestPoints{small};
                                    ball.constraints = {compliant("distance", 1e-3, {"edges"}), plate_of(kRigidity)};
                                    Scene scene = scene_of({ball}, kEarth, 0.01, 1, Precision::Float);
                                    scene.solver.type = "desbrun";
                                    scene.self_collision = SelfCollision{0.01, 0, {}, false};
                                    return scene;
                                  },
                                  40,
                                  {15}}),
    name_of_scene);

}  // namespace
}  // namespace malha
