// SPDX-License-Identifier: Apache-2.0
#include "malha/scene.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "host/scene/constraint_schema.h"
#include "tests/full_scene.h"
#include "tests/refusal.h"

namespace malha {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

TEST(ParseScene, GivesEveryKindItsOwnDefaults) {
  for (const ConstraintSchema& kind : constraint_kinds()) {
    Json one{{"type", kind.name}};
    if (!kind.accepts_stiffness && !kind.modulus.empty()) one[kind.modulus] = 1;
    const Scene scene = parse_scene(changed_scene("/bodies/2/constraints", Json::array({one}).dump()), "s.json", "");
    ASSERT_EQ(scene.bodies[2].constraints.size(), 1u);
    const ConstraintSpec& spec = scene.bodies[2].constraints[0];
    EXPECT_EQ(spec.type, kind.name);
    EXPECT_EQ(spec.parameter, kind.parameter_default) << kind.name;
    EXPECT_EQ(spec.stiffness, 1) << kind.name;
    EXPECT_FALSE(spec.compliance) << kind.name;
    EXPECT_EQ(spec.elements, kind.on_edges ? std::vector<std::string>{"edges"} : std::vector<std::string>{})
        << kind.name;
  }
}

TEST(ParseScene, HoldsEveryParameterToTheMinimumOfItsKind) {
  for (const ConstraintSchema& kind : constraint_kinds()) {
    const auto with = [&](double value) {
      Json one{{"type", kind.name}, {kind.parameter, value}};
      if (!kind.accepts_stiffness && !kind.modulus.empty()) one[kind.modulus] = 1;
      return changed_scene("/bodies/2/constraints", Json::array({one}).dump());
    };
    EXPECT_EQ(scene_refusal(with(kind.parameter_min)).empty(), kind.min_included) << kind.name;
    EXPECT_NE(scene_refusal(with(kind.parameter_min - 1)), "") << kind.name;
    const double inside = std::min(kind.parameter_min + 1, kind.parameter_max);
    EXPECT_EQ(parse_scene(with(inside), "s.json", "").bodies[2].constraints[0].parameter, inside);
    if (std::isfinite(kind.parameter_max)) {
      EXPECT_NE(scene_refusal(with(kind.parameter_max + 0.001)), "") << kind.name;
    }
  }
}

TEST(ParseScene, ReadsEveryValueOfAFullScene) {
  const Scene s = parse_scene(full_scene(), "s.json", "");
  EXPECT_EQ(s.file, "s.json");
  EXPECT_EQ(s.solver.dt, 0.01);
  EXPECT_EQ(s.solver.substeps, 4);
  EXPECT_EQ(s.solver.iterations, 3);
  EXPECT_EQ(s.solver.precision, Precision::Double);
  EXPECT_EQ(s.gravity, (Vec3{0, -9.81, 0}));
  EXPECT_EQ(s.wind.value().velocity, (Vec3{1, 0, 0.5}));
  EXPECT_EQ(s.wind.value().drag, 0.01);
  EXPECT_EQ(s.wind.value().density, 1.2);
  EXPECT_EQ(s.wind.value().drag_coefficient, 1.1);
  EXPECT_EQ(s.wind.value().lift_coefficient, 0.9);
  EXPECT_EQ(s.sleep.value().speed, 0.02);
  EXPECT_EQ(s.sleep.value().after, 0.25);
  ASSERT_EQ(s.bodies.size(), 9u);
  const BodySpec& body = s.bodies[0];
  EXPECT_EQ(std::get<MeshFile>(body.shape).path, "meshes/x.obj");
  EXPECT_EQ(body.density, 0.2);
  EXPECT_FALSE(body.mass);
  EXPECT_EQ(body.transform.translate, (Vec3{1, 2, 3}));
  EXPECT_EQ(body.transform.axis, (Vec3{0, 0, 2}));
  EXPECT_EQ(body.transform.degrees, 90);
  EXPECT_EQ(body.transform.scale, (Vec3{1, 2, 3}));
  EXPECT_EQ(body.velocity, (Vec3{1, 2, 3}));
  EXPECT_EQ(body.spin, (Vec3{4, 5, 6}));
  EXPECT_EQ(body.damping, 0.5);
  ASSERT_EQ(body.constraints.size(), 4u);
  EXPECT_EQ(body.constraints[0].elements, (std::vector<std::string>{"edges", "shear"}));
  EXPECT_EQ(body.constraints[0].stiffness, 0.5);
  EXPECT_EQ(body.constraints[0].parameter, 1.1);
  EXPECT_EQ(body.constraints[1].compliance, 1e-7);
  EXPECT_EQ(body.constraints[1].parameter, 0.2);
  EXPECT_EQ(body.constraints[2].parameter, 0);
  EXPECT_EQ(body.constraints[3].compliance, 0);
  EXPECT_EQ(body.constraints[3].parameter, 1.2);
  EXPECT_EQ(s.bodies[1].mass, 0.3);
  EXPECT_EQ(s.bodies[1].transform.scale, (Vec3{2, 2, 2}));
  ASSERT_EQ(s.bodies[1].pins.size(), 7u);
  EXPECT_TRUE(std::get<RowPin>(s.bodies[1].pins[0].at).last);
  EXPECT_EQ(std::get<BoxPin>(s.bodies[1].pins[1].at).max, (Vec3{1, 0, 2}));
  EXPECT_EQ(std::get<SpherePin>(s.bodies[1].pins[2].at).radius, 0.1);
  EXPECT_EQ(std::get<NearestPin>(s.bodies[1].pins[3].at).point, (Vec3{0, 0, 7}));
  EXPECT_EQ(std::get<ListPin>(s.bodies[1].pins[6].at).particles, (std::vector<int>{0, 16}));
  EXPECT_EQ(s.bodies[1].pins[6].release_time, 1.5);
  ASSERT_EQ(s.bodies[1].pins[6].motion.size(), 2u);
  EXPECT_EQ(s.bodies[1].pins[6].motion[1].degrees, 90);
  ASSERT_EQ(s.bodies[1].attachments.size(), 6u);
  EXPECT_EQ(s.bodies[1].attachments[0].environment, "planet");
  EXPECT_EQ(s.bodies[1].attachments[0].compliance, 0.001);
  EXPECT_EQ(s.bodies[1].attachments[0].release_time, 2);
  EXPECT_EQ(s.bodies[1].attachments[1].point, (Vec3{0, 2, 0}));
  EXPECT_EQ(s.bodies[1].attachments[1].stiffness, 0.5);
  EXPECT_EQ(s.bodies[1].attachments[5].motion[1].translate, (Vec3{0, 1, 0}));
  EXPECT_EQ(s.bodies[1].tear.value().strain, 0.4);
  EXPECT_EQ(std::get<GridShape>(s.bodies[1].shape).size, (std::array<double, 2>{1, 2}));
  EXPECT_EQ(std::get<SphereShape>(s.bodies[2].shape).subdivisions, 3);
  EXPECT_EQ(std::get<BoxShape>(s.bodies[3].shape).cells, (std::array<int, 3>{1, 2, 3}));
  EXPECT_EQ(std::get<BarShape>(s.bodies[4].shape).length, 2);
  EXPECT_EQ(std::get<ChainShape>(s.bodies[5].shape).segments, 9);
  EXPECT_EQ(std::get<LatticeShape>(s.bodies[6].shape).count, (std::array<int, 3>{2, 3, 1}));
  EXPECT_EQ(s.bodies[7].constraints.at(1).young_modulus, 2e5);
  EXPECT_EQ(s.bodies[7].constraints.at(1).parameter, 0.4);
  EXPECT_EQ(std::get<TetBoxShape>(s.bodies[7].shape).size, (Vec3{1, 2, 3}));
  EXPECT_EQ(std::get<TetBoxShape>(s.bodies[7].shape).cells, (std::array<int, 3>{1, 2, 3}));
  ASSERT_EQ(s.environment.size(), 13u);
  EXPECT_EQ(s.environment[0].sides, Sides::Solid);
  EXPECT_EQ(s.environment[1].sides, Sides::OneSided);
  EXPECT_EQ(s.environment[2].sides, Sides::TwoSided);
  EXPECT_EQ(s.environment[1].thickness, 0.01);
  EXPECT_EQ(s.environment[1].friction, 1.5);
  EXPECT_EQ(s.environment[1].restitution, 0.25);
  ASSERT_EQ(s.environment[3].motion.size(), 3u);
  EXPECT_EQ(s.environment[3].motion[1].translate, (Vec3{0, 1, 0}));
  EXPECT_EQ(s.environment[3].motion[2].degrees, 720);
  const AnimationSpec walk = s.environment[6].animation.value(), swim = s.environment[7].animation.value();
  EXPECT_TRUE(walk.file.ends_with("meshes/walk.glb"));
  EXPECT_EQ(std::get<std::string>(walk.clip), "walk");
  EXPECT_EQ(walk.speed, 2);
  EXPECT_EQ(walk.offset, -.5);
  EXPECT_TRUE(walk.loop);
  EXPECT_TRUE(swim.frames.ends_with("meshes/swim_*.ply"));
  EXPECT_EQ(swim.frames_per_second, 24);
  EXPECT_TRUE(s.environment[8].animation.value().from_code);
  EXPECT_TRUE(std::holds_alternative<PlaneShape>(s.environment[10].shape));
  EXPECT_EQ(std::get<CapsuleShape>(s.environment[11].shape).to, (Vec3{4, 0, 0}));
  EXPECT_EQ(std::get<CylinderShape>(s.environment[12].shape).radius, 0.2);
  ASSERT_EQ(s.seams.size(), 7u);
  EXPECT_EQ(s.seams[0].from.body, "sheet");
  EXPECT_TRUE(std::get<RowPin>(s.seams[0].from.at.value()).last);
  EXPECT_EQ(s.seams[0].within, 0.02);
  EXPECT_EQ(s.seams[0].closing, 0.5);
  EXPECT_EQ(s.seams[0].compliance, 1e-6);
  EXPECT_TRUE(s.seams[5].to.surface);
  EXPECT_EQ(s.seams[6].pairs, (std::vector<Edge>{{0, 1}, {2, 3}}));
  EXPECT_EQ(s.expect.max_seam_gap.at_most, 0.001);
  EXPECT_EQ(s.duration, 2.5);
  EXPECT_EQ(s.outputs.every, 2);
  EXPECT_EQ(s.outputs.formats, (std::vector<std::string>{"vtp", "pc2", "ply", "obj", "glb"}));
  EXPECT_EQ(s.outputs.page.value().max_megabytes, 30);
  EXPECT_EQ(s.outputs.picture_every, 5);
  EXPECT_EQ(s.outputs.picture.value().size, (std::array<int, 2>{640, 360}));
  EXPECT_EQ(s.outputs.picture.value().camera.value().fov_degrees, 35);
  EXPECT_EQ(s.outputs.checkpoint_every, 10);
  EXPECT_EQ(s.expect.max_strain, 0.1);
  EXPECT_EQ(s.expect.rms_strain.at_least, 0.001);
  EXPECT_EQ(s.expect.rms_strain.at_most, 0.01);
  EXPECT_EQ(s.expect.max_penetration, 0.001);
  EXPECT_EQ(s.expect.max_crossings, 2);
  EXPECT_EQ(s.expect.energy_not_above, -5);
  EXPECT_EQ(s.expect.energy_not_below, -50);
  EXPECT_EQ(s.expect.max_speed.at_least, 3);
  EXPECT_FALSE(s.expect.max_speed.at_most);
  EXPECT_EQ(s.expect.bounds_max, (Vec3{1, 2, 3}));
  EXPECT_EQ(s.expect.volume_ratio, (std::array<double, 2>{0.9, 1.1}));
  EXPECT_EQ(s.expect.bodies.at(0).name, "ball");
  EXPECT_EQ(s.expect.bodies.at(0).bounds_min, (Vec3{-0.5, -1, -1.5}));
  EXPECT_EQ(s.expect.inverted_tetrahedra.at_least, 1);
  EXPECT_EQ(s.expect.inverted_tetrahedra.at_most, 3);
}

TEST(ToJson, ComesBackAsTheSameScene) {
  const std::string once = to_json(parse_scene(full_scene(), "s.json", "some/folder"));
  // Paths come out absolute, so that another folder on the way in changes nothing.
  EXPECT_EQ(to_json(parse_scene(once, "t.json", "another/folder")), once);
}

TEST(ToJson, SpellsOutEveryValue) {
  const auto leaves = [](const Json& json) {
    Json flat = json.flatten();
    flat.erase("/$schema");
    flat.erase("/bodies/0/shape/mesh");  // absolute there
    flat.erase("/bodies/2/constraints/3/map/picture"), flat.erase("/bodies/1/pins/5/map/picture");
    flat.erase("/bodies/3/rest/mesh"), flat.erase("/environment/0/shape/mesh");
    for (const char* object : {"6", "7", "8"})
      for (const char* path : {"/shape/mesh", "/animation/file", "/animation/frames"})
        flat.erase("/environment/" + std::string(object) + path);
    flat.erase("/bodies/1/transform/scale");  // three numbers there
    return flat;
  };
  const Json given = leaves(Json::parse(full_scene()));
  const Json written = leaves(Json::parse(to_json(parse_scene(full_scene(), "s.json", ""))));
  for (const auto& [pointer, value] : given.items()) EXPECT_EQ(written.value(pointer, Json()), value) << pointer;
}

TEST(ToJson, KeepsEveryBitOfANumber) {
  const double third = std::nextafter(1.0 / 3, 1);
  Scene scene = parse_scene(full_scene(), "s.json", "");
  scene.solver.dt = third;
  EXPECT_EQ(parse_scene(to_json(scene), "s.json", "").solver.dt, third);
}

TEST(LoadScene, ResolvesMeshPathsAgainstTheScenesFolder) {
  const fs::path folder = fs::temp_directory_path() / ("malha_scene_test_" + std::to_string(getpid()));
  fs::remove_all(folder);
  fs::create_directories(folder);
  std::ofstream(folder / "s.json") << changed_scene("/environment/0/shape/mesh", "\"/elsewhere/y.off\"");
  const Scene scene = load_scene((folder / "s.json").string());
  EXPECT_EQ(scene.file, (folder / "s.json").string());
  EXPECT_EQ(std::get<MeshFile>(scene.bodies[0].shape).path, (folder / "meshes/x.obj").string());
  EXPECT_EQ(std::get<MeshFile>(scene.environment[0].shape).path, "/elsewhere/y.off");
  fs::remove_all(folder);
}

TEST(LoadScene, RefusesAMissingFileAndAFolder) {
  const std::string missing = (fs::temp_directory_path() / "malha_no_such_scene.json").string();
  EXPECT_EQ(refusal([&] { load_scene(missing); }),
            missing + ": cannot read: No such file or directory; allowed: a readable scene file (JSON)");
  EXPECT_THROW(load_scene(fs::temp_directory_path().string()), InputError);
}

}  // namespace
}  // namespace malha
