// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "host/scene/constraint_schema.h"
#include "tests/full_scene.h"

namespace malha {
namespace {

/// A value at a JSON pointer that the parser refuses, the place that it names, and a part of what it says. Ranges,
/// types, lengths, enumerations and required keys are not here: scene_schema_test.cpp makes those cases from the
/// schema.
struct Refusal {
  std::string name, pointer, value, place, says = "";
};
void PrintTo(const Refusal& r, std::ostream* out) { *out << r.pointer << " = " << r.value; }

class ParseSceneRefuses : public testing::TestWithParam<Refusal> {};

TEST_P(ParseSceneRefuses, It) {
  const Refusal& tested = GetParam();
  const std::string refused = scene_refusal(changed_scene(tested.pointer, tested.value));
  EXPECT_EQ(refused.find("s.json: " + tested.place + (tested.place.empty() ? "found " : ": found ")), 0u) << refused;
  EXPECT_NE(refused.find(tested.says), std::string::npos) << refused;
  EXPECT_NE(refused.find("; allowed: "), std::string::npos) << refused;
  EXPECT_EQ(refused.find('\n'), std::string::npos) << refused;
}

std::string name_of_refusal(const testing::TestParamInfo<Refusal>& info) { return info.param.name; }

INSTANTIATE_TEST_SUITE_P(
    Whole, ParseSceneRefuses,
    testing::Values(Refusal{"AList", "", "[]", ""},
                    Refusal{"UnknownKey", "/gravitiy", "1", "/gravitiy", "did you mean 'gravity'"},
                    Refusal{"ZeroBodies", "/bodies", "[]", "/bodies"},
                    Refusal{"UnknownSolver", "/solver/type", "\"xpbd\"", "/solver/type", "did you mean 'pbd'"},
                    Refusal{"SpringConstantAsItWasCalled", "/solver/stiffness", "500", "/solver/stiffness",
                            "'spring_constant'"},
                    Refusal{"WindThatDoesNothing", "/wind", R"({"velocity": [1, 0, 0]})", "/wind"},
                    Refusal{"CoefficientWithoutAir", "/wind",
                            R"({"velocity": [1, 0, 0], "drag": 1, "lift_coefficient": 1})", "/wind/lift_coefficient"},
                    Refusal{"EndlessDuration", "/duration", "1e12", "/duration"},
                    Refusal{"RepeatedName", "/bodies/2/name", "\"sheet\"", "/bodies/2/name"},
                    Refusal{"EnvironmentNamedAsABody", "/environment/0/name", "\"sheet\"", "/environment/0/name"},
                    Refusal{"EmptyName", "/bodies/0/name", "\"\"", "/bodies/0/name"},
                    Refusal{"NameThatLeavesTheFolder", "/bodies/0/name", "\"../x\"", "/bodies/0/name"},
                    Refusal{"NameWithASlash", "/name", "\"a/b\"", "/name"}),
    name_of_refusal);

INSTANTIATE_TEST_SUITE_P(
    TwoModuli, ParseSceneRefuses,
    testing::Values(
        Refusal{"ShearModulusOfOneModulus", "/bodies/2/constraints/2/shear_modulus", "5",
                "/bodies/2/constraints/2/shear_modulus", "beside a single 'young_modulus'"},
        Refusal{"TwistingRigidityOfOneRigidity", "/bodies/2/constraints/3/twisting_rigidity", "1e-4",
                "/bodies/2/constraints/3/twisting_rigidity", "\"rigidity\": [along, across]"},
        Refusal{"DirectionOfOneModulus", "/bodies/2/constraints/2/along", "[1, 0, 0]", "/bodies/2/constraints/2/along"},
        Refusal{"DirectionOfNothing", "/bodies/3/constraints/0/along", "[0, 0, 0]", "/bodies/3/constraints/0/along"},
        Refusal{"TwoModuliOfAKindWithOne", "/bodies/2/constraints/0/rigidity", "[500, 400]",
                "/bodies/2/constraints/0/rigidity"},
        // nu12 nu21 = 0.5^2 400 / 100 = 1: a strain without energy.
        Refusal{"PoissonsRatioThatIsUnstable", "/bodies/2/constraints/2",
                R"({"type": "membrane", "young_modulus": [100, 400], "poisson_ratio": 0.5})",
                "/bodies/2/constraints/2/poisson_ratio", "4 times as stiff across as along"},
        Refusal{"DefaultPoissonsRatioThatIsUnstable", "/bodies/2/constraints/2",
                R"({"type": "membrane", "young_modulus": [1, 100]})", "/bodies/2/constraints/2",
                "'poisson_ratio' <= 0.095"}),
    name_of_refusal);

INSTANTIATE_TEST_SUITE_P(
    Attachments, ParseSceneRefuses,
    testing::Values(
        Refusal{"PinThatJumps", "/bodies/1/pins/6/motion/0/translate", "[0, 0, 1]", "/bodies/1/pins/6/motion/0"},
        Refusal{"PinKeyframesOutOfOrder", "/bodies/1/pins/6/motion/1/time", "0.5", "/bodies/1/pins/6/motion/1/time"},
        Refusal{"PinWithoutAPlace", "/bodies/1/pins/0", R"({"release_time": 1})", "/bodies/1/pins/0"},
        Refusal{"PinUtnil", "/bodies/1/pins/0/relaese_time", "1", "/bodies/1/pins/0/relaese_time",
                "did you mean 'release_time'"},
        Refusal{"AttachmentAtNoPlace", "/bodies/1/attachments/0/at", "{}", "/bodies/1/attachments/0/at"},
        Refusal{"AttachmentToTwoThings", "/bodies/1/attachments/0/to/point", "[0, 0, 0]", "/bodies/1/attachments/0/to"},
        Refusal{"AttachmentToAMeshOnAPathOfItsOwn", "/bodies/1/attachments/0/motion", "[]",
                "/bodies/1/attachments/0/motion"},
        Refusal{"AttachmentThatJumps", "/bodies/1/attachments/2/motion/0/rotate",
                R"({"axis": [0, 1, 0], "degrees": 1})", "/bodies/1/attachments/2/motion/0"},
        Refusal{"AttachmentStiffAndCompliant", "/bodies/1/attachments/0/stiffness", "1",
                "/bodies/1/attachments/0/compliance"},
        Refusal{"TearOfABalloon", "/bodies/0/tear", R"({"strain": 1})", "/bodies/0/tear"},
        Refusal{"TearOfDust", "/bodies/6/tear", R"({"strain": 1})", "/bodies/6/tear"}),
    name_of_refusal);

INSTANTIATE_TEST_SUITE_P(
    Bodies, ParseSceneRefuses,
    testing::Values(
        Refusal{"MisspeltMass", "/bodies/2/mas", "1", "/bodies/2/mas", "did you mean 'mass'"},
        Refusal{"NoMass", "/bodies/2/mass", "remove", "/bodies/2"},
        Refusal{"MassAndDensity", "/bodies/2/density", "1", "/bodies/2"},
        Refusal{
            "DensityOfACloud", "/bodies/6",
            R"({"name": "c", "density": 1, "shape": {"lattice": {"min": [0,0,0], "max": [1,1,1], "count": [2,2,2]}}})",
            "/bodies/6/density", "'mass'"},
        Refusal{"TwoPinsInOne", "/bodies/1/pins/0/nearest", "[0, 0, 0]", "/bodies/1/pins/0"},
        Refusal{"UnknownRow", "/bodies/1/pins/0/row", "\"lats\"", "/bodies/1/pins/0/row", "did you mean 'last'"},
        Refusal{"RowOfASphere", "/bodies/2/pins", "[{\"row\": \"first\"}]", "/bodies/2/pins/0/row"},
        Refusal{"PinBoxInsideOut", "/bodies/1/pins/1/box/max", "[1, -1, 2]", "/bodies/1/pins/1/box/max/1"}),
    name_of_refusal);

INSTANTIATE_TEST_SUITE_P(Constraints, ParseSceneRefuses,
                         testing::Values(Refusal{"StiffnessAndCompliance", "/bodies/0/constraints/0/compliance", "1",
                                                 "/bodies/0/constraints/0/compliance"},
                                         Refusal{"StiffnessAndRigidity", "/bodies/0/constraints/0/rigidity", "1",
                                                 "/bodies/0/constraints/0/rigidity"},
                                         Refusal{"UnknownElement", "/bodies/0/constraints/0/elements", "[\"edge\"]",
                                                 "/bodies/0/constraints/0/elements/0", "did you mean 'edges'"},
                                         Refusal{"PressureAsItWasCalled", "/bodies/0/constraints/3/pressure", "1.2",
                                                 "/bodies/0/constraints/3/pressure", "'volume_ratio'"}),
                         name_of_refusal);

INSTANTIATE_TEST_SUITE_P(
    Shapes, ParseSceneRefuses,
    testing::Values(
        Refusal{"None", "/bodies/0/shape", "{}", "/bodies/0/shape"},
        Refusal{"Unknown", "/bodies/0/shape", "{\"shpere\": {}}", "/bodies/0/shape/shpere", "did you mean 'sphere'"},
        Refusal{"EmptyPath", "/bodies/0/shape/mesh", "\"\"", "/bodies/0/shape/mesh"},
        Refusal{"TooManyCells", "/bodies/1/shape/grid/cells", "[100000, 100000]", "/bodies/1/shape/grid/cells"},
        Refusal{"TooManyBoxCells", "/bodies/3/shape/box/cells", "[100000, 100000, 1]", "/bodies/3/shape/box/cells"},
        Refusal{"TooManyBarCells", "/bodies/4/shape/bar/cells", "100000", "/bodies/4/shape/bar/cells"},
        Refusal{"TooManyLooseParticles", "/bodies/6/shape/lattice/count", "[100000, 1000, 1]",
                "/bodies/6/shape/lattice/count"},
        Refusal{"ChainWithoutLength", "/bodies/5/shape/chain/to", "[0, 0, 0]", "/bodies/5/shape/chain/to"},
        Refusal{"TooManyTetrahedra", "/bodies/7/shape/tet_box/cells", "[1000, 1000, 1000]",
                "/bodies/7/shape/tet_box/cells"},
        Refusal{"CloudInsideOut", "/bodies/6/shape/lattice/max", "[1, 0, 0]", "/bodies/6/shape/lattice/max/1"},
        Refusal{"ZeroAxis", "/bodies/0/transform/rotate/axis", "[0, 0, 0]", "/bodies/0/transform/rotate/axis"}),
    name_of_refusal);

INSTANTIATE_TEST_SUITE_P(
    Surroundings, ParseSceneRefuses,
    testing::Values(
        Refusal{"UnknownSides", "/environment/0/sides", "\"twosided\"", "/environment/0/sides",
                "did you mean 'two_sided'"},
        Refusal{"AnimationWithoutAFile", "/environment/0/animation", "{}", "/environment/0/animation",
                "no file for a shape of another kind than glTF"},
        Refusal{"AnimationOfAnotherFormat", "/environment/6/animation/file", "\"walk.fbx\"",
                "/environment/6/animation/file", "a .glb or .gltf file"},
        Refusal{"ClipByAFraction", "/environment/6/animation/clip", "1.5", "/environment/6/animation/clip"},
        Refusal{"FramesBesideAClip", "/environment/7/animation/clip", "1", "/environment/7/animation/clip",
                "'clip' beside 'frames'"},
        Refusal{"FramesBesideAFile", "/environment/7/animation/file", "\"z.glb\"", "/environment/7/animation/file",
                "'file' beside 'frames'"},
        Refusal{"FramesWithoutARate", "/environment/7/animation/frames_per_second", "remove",
                "/environment/7/animation", "'frames_per_second'"},
        Refusal{"RateOfAClip", "/environment/6/animation/frames_per_second", "24",
                "/environment/6/animation/frames_per_second", "'speed' for a clip"},
        Refusal{"SpeedFromCode", "/environment/8/animation/speed", "2", "/environment/8/animation/speed",
                "'speed' beside 'from_code'"},
        Refusal{"NotFromCode", "/environment/8/animation/from_code", "false", "/environment/8/animation/from_code"},
        Refusal{"TimesThatDoNotIncrease", "/environment/3/motion/2/time", "0.5", "/environment/3/motion/2/time"},
        Refusal{"ZeroAxisOfMotion", "/environment/3/motion/2/rotate/axis", "[0, 0, 0]",
                "/environment/3/motion/2/rotate/axis"},
        Refusal{"UnknownFormat", "/outputs/frames/formats", "[\"vtk\"]", "/outputs/frames/formats/0",
                "did you mean 'vtp'"},
        Refusal{"CameraInItsTarget", "/outputs/pictures/camera/target", "[1, 2, 3]", "/outputs/pictures/camera/target"},
        Refusal{"RoomInsideOut", "/expect/bounds/min", "[-1, 3, -3]", "/expect/bounds/max/1"},
        Refusal{"StrainInWords", "/expect/max_strain", "\"small\"", "/expect/max_strain"},
        Refusal{"StrainOfNothing", "/expect/max_strain", "{}", "/expect/max_strain"},
        Refusal{"StrainInReverse", "/expect/max_strain", R"({"at_least": 0.2, "at_most": 0.1})",
                "/expect/max_strain/at_most"},
        Refusal{"StrainMisspelt", "/expect/rms_strain/at_leest", "1", "/expect/rms_strain/at_leest",
                "did you mean 'at_least'"},
        Refusal{"EnergyInReverse", "/expect/energy_not_below", "5", "/expect/energy_not_above"},
        Refusal{"BoxOfAStranger", "/expect/bodies/0/name", "\"bal\"", "/expect/bodies/0/name", "did you mean 'ball'"},
        Refusal{"BoxTwice", "/expect/bodies/1", R"({"name": "ball", "bounds": {"min": [0, 0, 0], "max": [1, 1, 1]}})",
                "/expect/bodies/1/name"},
        Refusal{"BoxOfNoBody", "/expect/bodies", "[]", "/expect/bodies"},
        Refusal{"VolumesInReverse", "/expect/volume_ratio", "[1, 0.5]", "/expect/volume_ratio/1"}),
    name_of_refusal);

TEST(ParseScene, RefusesAnUnknownConstraintWithTheListOfKinds) {
  std::string names;
  for (const ConstraintSchema& kind : constraint_kinds()) names += (names.empty() ? "" : ", ") + kind.name;
  EXPECT_EQ(scene_refusal(changed_scene("/bodies/0/constraints/0/type", "\"distanse\"")),
            "s.json: /bodies/0/constraints/0/type: found unknown constraint \"distanse\" (did you mean 'distance'?); "
            "allowed: " +
                names);
}

TEST(ParseScene, NamesTheLineOfASyntaxErrorAndOfADuplicateKey) {
  EXPECT_EQ(scene_refusal("{\n\"name\": }").find("s.json: line 2, column 9: found"), 0u);
  EXPECT_EQ(
      scene_refusal("{\"name\": \"a\",\n \"name\": \"b\"}").find("s.json: line 2, column 2: found the key 'name'"), 0u);
}

/// The JSON pointers of a refusal's lines.
std::vector<std::string> places_of_faults(const std::string& refused) {
  std::vector<std::string> places;
  for (std::size_t at = 0, end = 0; at < refused.size(); at = end + 1) {
    end = std::min(refused.find('\n', at), refused.size());
    const std::string line = refused.substr(at, end - at);
    const std::size_t from = line.find(": ") + 2;
    places.push_back(line.substr(from, line.find(": ", from) - from));
  }
  return places;
}

TEST(ParseScene, RefusesAllFaultsAtOnceEachOnALineOfItsOwn) {
  nlohmann::ordered_json scene = nlohmann::ordered_json::parse(full_scene());
  scene["solver"]["dt"] = -1, scene["solver"]["subteps"] = 3;
  scene["bodies"][0]["mass"] = 0, scene["bodies"][0]["constraints"][0]["type"] = "distanse";
  scene["bodies"][1]["shape"] = {{"shpere", 1}};
  scene["environment"][0]["friction"] = -1;
  scene.erase("duration");
  const std::string refused = scene_refusal(scene.dump());
  EXPECT_EQ(places_of_faults(refused),
            (std::vector<std::string>{"/solver/subteps", "/solver/dt", "/bodies/0/mass", "/bodies/0/constraints/0/type",
                                      "/bodies/1/shape/shpere", "/environment/0/friction",
                                      "found no key 'duration'; allowed"}))
      << refused;
}

TEST(ParseScene, DoesNotRefuseWhatAFaultEntails) {
  // These are names that expectations and self-collision use, rows of a shape without rows, and a mass that is
  // misspelt.
  for (const auto& [pointer, value] :
       {std::pair{"/bodies/1/shape", R"({"gird": {}})"}, {"/bodies/0/name", "1"}, {"/bodies/2/mas", "1"}})
    EXPECT_EQ(places_of_faults(scene_refusal(changed_scene(pointer, value))).size(), 1u) << pointer;
}

TEST(ParseScene, EndsALongListOfFaults) {
  nlohmann::ordered_json scene = nlohmann::ordered_json::parse(full_scene());
  for (int i = 0; i < 50; ++i) scene["expect"]["key_" + std::to_string(i)] = 1;
  const std::string refused = scene_refusal(scene.dump());
  EXPECT_EQ(std::ranges::count(refused, '\n'), 20);
  EXPECT_NE(refused.find("\n... and 30 more"), std::string::npos);
}

TEST(ParseScene, SuggestsByMeaning) {
  for (const auto& [word, here] : {std::pair{"spring", "distance"},
                                   {"Stretch", "distance"},
                                   {"cloth", "membrane"},
                                   {"shell", "membrane"},
                                   {"fem", "neo_hookean"},
                                   {"solid", "neo_hookean"},
                                   {"tether", "long_range"},
                                   {"inflate", "pressure"},
                                   {"balloon", "pressure"},
                                   {"hinge", "bending"},
                                   {"edge", "distance"},
                                   {"area", "membrane"},
                                   {"strain", "membrane"},
                                   {"ARAP", "neo_hookean"},
                                   {"shape matching", "neo_hookean"},
                                   {"volume preservation", "volume"},
                                   {"strain-limit", "distance_limit"}}) {
    const std::string refused =
        scene_refusal(changed_scene("/bodies/0/constraints/0/type", std::string("\"") + word + "\""));
    EXPECT_NE(refused.find(std::string("(did you mean '") + here + "'?"), std::string::npos) << refused;
  }
}

TEST(ParseScene, SuggestsSolversAndKeysOfTheCameraByMeaning) {
  for (const auto& [word, here] :
       {std::pair{"xpbd", "pbd"}, {"vbd", "pbd"}, {"FEM", "pbd"}, {"projective-dynamics", "desbrun"}}) {
    const std::string refused = scene_refusal(changed_scene("/solver/type", std::string("\"") + word + "\""));
    EXPECT_NE(refused.find(std::string("(did you mean '") + here + "'?"), std::string::npos) << refused;
  }
  const std::string refused = scene_refusal(changed_scene(
      "/outputs", R"({"pictures": {"camera": {"from": [0, 0, 1], "target": [0, 0, 0], "eye": [0, 0, 1]}}})"));
  EXPECT_NE(refused.find("/camera/from: found unknown key 'from' (did you mean 'eye'?"), std::string::npos) << refused;
}

TEST(ParseScene, NamesTheNewNameOfAKeyThatWasRenamed) {
  for (const auto& [pointer, value, now] :
       {std::tuple{"/solver", R"({"type": "pbd", "levels_every": 1})", "levels_interval"},
        {"/solver", R"({"type": "pbd", "stiffness_of": "step"})", "stiffness_basis"},
        {"/bodies/1/pins/0/until", "1", "release_time"},
        {"/bodies/0/constraints/0/on", "[\"edges\"]", "elements"},
        {"/bodies/0/shape", R"({"cloud": {}})", "lattice"},
        {"/bodies/0/shape", R"({"listed": {}})", "mesh_data"},
        {"/outputs/page", R"({"megabytes": 10})", "max_megabytes"},
        {"/expect/inside", "{}", "bounds"},
        {"/solver", R"({"type": "desbrun", "refine": 1})", "refinement_iterations"},
        {"/solver", R"({"type": "desbrun", "filtered": "all"})", "filter_external_forces"}}) {
    const std::string refused = scene_refusal(changed_scene(pointer, value));
    EXPECT_NE(refused.find(std::string("'") + now + "' now"), std::string::npos) << refused;
  }
}

TEST(ParseScene, SaysWhatStrictJsonLacks) {
  const auto says = [](const std::string& text, const std::string& place, const std::string& words) {
    const std::string refused = scene_refusal(text);
    return refused.starts_with("s.json: " + place + ": ") && refused.find(words) != std::string::npos;
  };
  EXPECT_TRUE(says("{\n// a scene\n\"name\": 1}", "line 2, column 1", "no comments"));
  EXPECT_TRUE(says("{\"name\": 1, # a scene\n}", "line 1, column 13", "no comments"));
  EXPECT_TRUE(says("{\"name\": [1, 2, ]}", "line 1, column 17", "no comma after the last"));
  EXPECT_TRUE(says("{\"name\": 1,\n}", "line 2, column 1", "no comma after the last"));
  EXPECT_FALSE(says("{\"name\": ]}", "line 1, column 10", "strict"));
}

}  // namespace
}  // namespace malha
