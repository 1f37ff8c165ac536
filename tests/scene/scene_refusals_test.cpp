// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "host/scene/kinds_in_scenes.h"
#include "tests/full_scene.h"

namespace malha {
namespace {

// What is put where, and the refusal: "s.json: " and then this.
struct Refusal {
  std::string name, pointer, value, message;
};
void PrintTo(const Refusal& r, std::ostream* out) { *out << r.pointer << " = " << r.value; }

class ParseSceneRefuses : public testing::TestWithParam<Refusal> {};

TEST_P(ParseSceneRefuses, It) {
  EXPECT_EQ(scene_refusal(changed_scene(GetParam().pointer, GetParam().value)), "s.json: " + GetParam().message);
}

std::string name_of_refusal(const testing::TestParamInfo<Refusal>& info) { return info.param.name; }

const std::string positive_kg = "; allowed: a number > 0 (kg)";
const std::string ratio = "; allowed: a number in [0, 1]";
const std::string other_name = "; allowed: a name that no other body or environment object has";
const std::string file_name = "; allowed: a name without '/' and '\\', and without '.' in front";

INSTANTIATE_TEST_SUITE_P(
    Whole, ParseSceneRefuses,
    testing::Values(
        Refusal{"AList", "", "[]",
                "found a list of 0; allowed: an object with the keys $schema, name, solver, gravity, wind, sleep, "
                "bodies, environment, self_collision, duration, outputs, expect"},
        Refusal{"UnknownKey", "/gravitiy", "1",
                "/gravitiy: found unknown key 'gravitiy' (did you mean 'gravity'?); allowed: $schema, name, solver, "
                "gravity, wind, sleep, bodies, environment, self_collision, duration, outputs, expect"},
        Refusal{"ZeroBodies", "/bodies", "[]", "/bodies: found no body; allowed: at least one"},
        Refusal{"NoBodies", "/bodies", "remove", "found no key 'bodies'; allowed: an object with the key 'bodies'"},
        Refusal{
            "UnknownSolver", "/solver/type", "\"xpbd\"",
            "/solver/type: found unknown solver \"xpbd\" (did you mean 'pbd'? A constraint's \"compliance\" makes it "
            "XPBD); allowed: pbd, desbrun"},
        Refusal{"ZeroDt", "/solver/dt", "0", "/solver/dt: found 0; allowed: a number > 0 (s)"},
        Refusal{"NegativeDt", "/solver/dt", "-1", "/solver/dt: found -1; allowed: a number > 0 (s)"},
        Refusal{"ZeroSubsteps", "/solver/substeps", "0",
                "/solver/substeps: found 0; allowed: an integer in [1, 100000]"},
        Refusal{"TooManySubsteps", "/solver/substeps", "100001",
                "/solver/substeps: found 100001; allowed: an integer in [1, 100000]"},
        Refusal{"HalfAnIteration", "/solver/iterations", "0.5",
                "/solver/iterations: found 0.5; allowed: an integer in [1, 100000]"},
        Refusal{"SpringConstantAsItWasCalled", "/solver/stiffness", "500",
                "/solver/stiffness: found 'stiffness', which is a constraint's, from 0 to 1; allowed: "
                "'spring_constant' (N/m)"},
        Refusal{"ZeroSpringConstant", "/solver/spring_constant", "0",
                "/solver/spring_constant: found 0; allowed: a number > 0 (N/m)"},
        Refusal{"UnknownPrecision", "/solver/precision", "\"half\"",
                "/solver/precision: found unknown precision \"half\"; allowed: float, double"},
        Refusal{"GravityAsANumber", "/gravity", "-9.81",
                "/gravity: found -9.81; allowed: a list of 3, each a number (m/s^2)"},
        Refusal{"NegativeDrag", "/wind/drag", "-1",
                "/wind/drag: found -1; allowed: a number >= 0 (N s/m per particle)"},
        Refusal{"WindThatDoesNothing", "/wind", R"({"velocity": [1, 0, 0]})",
                "/wind: found neither 'drag' nor 'density'; allowed: 'drag' (acts on particles), 'density' (acts on "
                "faces) or both"},
        Refusal{"NegativeAir", "/wind/density", "-1",
                "/wind/density: found -1; allowed: a number >= 0 (kg/m^3 of air)"},
        Refusal{"CoefficientWithoutAir", "/wind", R"({"velocity": [1, 0, 0], "drag": 1, "lift_coefficient": 1})",
                "/wind/lift_coefficient: found 'lift_coefficient' without 'density'; allowed: 'density' beside it"},
        Refusal{"NegativeLift", "/wind/lift_coefficient", "-1",
                "/wind/lift_coefficient: found -1; allowed: a number >= 0"},
        Refusal{"SleepAtNoSpeed", "/sleep/speed", "0", "/sleep/speed: found 0; allowed: a number > 0 (m/s)"},
        Refusal{"SleepBeforeRest", "/sleep/after", "-1", "/sleep/after: found -1; allowed: a number >= 0 (s)"},
        Refusal{"SoftLongRange", "/bodies/5/constraints/0/stiffness", "0.5",
                "/bodies/5/constraints/0/stiffness: found unknown key 'stiffness'; allowed: type, limit"},
        Refusal{"ShorterLongRange", "/bodies/5/constraints/0/limit", "-0.1",
                "/bodies/5/constraints/0/limit: found -0.1; allowed: a number >= 0"},
        Refusal{"ZeroDuration", "/duration", "0", "/duration: found 0; allowed: a number > 0 (s)"},
        Refusal{"EndlessDuration", "/duration", "1e12",
                "/duration: found 1000000000000; allowed: at most 1000000000 steps of /solver/dt"},
        Refusal{"RepeatedName", "/bodies/2/name", "\"sheet\"", "/bodies/2/name: found \"sheet\"" + other_name},
        Refusal{"EnvironmentNamedAsABody", "/environment/0/name", "\"sheet\"",
                "/environment/0/name: found \"sheet\"" + other_name},
        Refusal{"EmptyName", "/bodies/0/name", "\"\"",
                "/bodies/0/name: found \"\"; allowed: a non-empty string of one line"},
        Refusal{"NameThatLeavesTheFolder", "/bodies/0/name", "\"../x\"", "/bodies/0/name: found \"../x\"" + file_name},
        Refusal{"NameWithASlash", "/name", "\"a/b\"", "/name: found \"a/b\"" + file_name}),
    name_of_refusal);

INSTANTIATE_TEST_SUITE_P(
    Attachments, ParseSceneRefuses,
    testing::Values(
        Refusal{"PinUntilTheStart", "/bodies/1/pins/4/release_time", "0",
                "/bodies/1/pins/4/release_time: found 0; allowed: a number > 0 (s)"},
        Refusal{"PinThatJumps", "/bodies/1/pins/4/motion/0/translate", "[0, 0, 1]",
                "/bodies/1/pins/4/motion/0: found a first keyframe that moves the particles; allowed: one without "
                "translate and rotate"},
        Refusal{"PinKeyframesOutOfOrder", "/bodies/1/pins/4/motion/1/time", "0.5",
                "/bodies/1/pins/4/motion/1/time: found 0.5; allowed: a time after that of the keyframe before it (s)"},
        Refusal{
            "PinWithoutAPlace", "/bodies/1/pins/0", R"({"release_time": 1})",
            "/bodies/1/pins/0: found none of these keys; allowed: exactly one of row, box, sphere, nearest, particles"},
        Refusal{"PinUtnil", "/bodies/1/pins/0/relaese_time", "1",
                "/bodies/1/pins/0/relaese_time: found unknown key 'relaese_time' (did you mean 'release_time'?); "
                "allowed: row, box, sphere, "
                "nearest, particles, motion, release_time"},
        Refusal{"AttachmentOfNothing", "/bodies/1/attachments/0/at", "remove",
                "/bodies/1/attachments/0: found no key 'at'; allowed: an object with the key 'at'"},
        Refusal{"AttachmentAtNoPlace", "/bodies/1/attachments/0/at", "{}",
                "/bodies/1/attachments/0/at: found an empty object; allowed: exactly one of row, box, sphere, nearest, "
                "particles"},
        Refusal{"AttachmentToTwoThings", "/bodies/1/attachments/0/to/point", "[0, 0, 0]",
                "/bodies/1/attachments/0/to: found environment, point; allowed: exactly one of environment, point"},
        Refusal{"AttachmentToANumber", "/bodies/1/attachments/0/to/environment", "1",
                "/bodies/1/attachments/0/to/environment: found 1; allowed: a non-empty string of one line"},
        Refusal{"AttachmentToAMeshOnAPathOfItsOwn", "/bodies/1/attachments/0/motion", "[]",
                "/bodies/1/attachments/0/motion: found 'motion' of an attachment to an environment object; allowed: "
                "the 'motion' of that object"},
        Refusal{"AttachmentThatJumps", "/bodies/1/attachments/2/motion/0/rotate",
                R"({"axis": [0, 1, 0], "degrees": 1})",
                "/bodies/1/attachments/2/motion/0: found a first keyframe that moves the particles; allowed: one "
                "without translate and rotate"},
        Refusal{"AttachmentStiffAndCompliant", "/bodies/1/attachments/0/stiffness", "1",
                "/bodies/1/attachments/0/compliance: found both 'stiffness' and 'compliance'; allowed: one of them"},
        Refusal{"AttachmentStiffnessAboveOne", "/bodies/1/attachments/1/stiffness", "2",
                "/bodies/1/attachments/1/stiffness: found 2" + ratio},
        Refusal{"AttachmentNegativeCompliance", "/bodies/1/attachments/0/compliance", "-1",
                "/bodies/1/attachments/0/compliance: found -1; allowed: a number >= 0 (m/N)"},
        Refusal{"AttachmentUntilBefore", "/bodies/1/attachments/0/release_time", "-1",
                "/bodies/1/attachments/0/release_time: found -1; allowed: a number > 0 (s)"},
        Refusal{"TearWithoutStrain", "/bodies/1/tear", "{}",
                "/bodies/1/tear: found no key 'strain'; allowed: an object with the key 'strain'"},
        Refusal{"TearAtRest", "/bodies/1/tear/strain", "0", "/bodies/1/tear/strain: found 0; allowed: a number > 0"},
        Refusal{"TearOfABalloon", "/bodies/0/tear", R"({"strain": 1})",
                "/bodies/0/tear: found 'tear' of a body with pressure; allowed: a body without pressure, which needs a "
                "closed mesh"},
        Refusal{"TearOfDust", "/bodies/6/tear", R"({"strain": 1})",
                "/bodies/6/tear: found 'tear' of loose particles; allowed: a body with edges"}),
    name_of_refusal);

INSTANTIATE_TEST_SUITE_P(
    Bodies, ParseSceneRefuses,
    testing::Values(
        Refusal{"MisspeltMass", "/bodies/2/mas", "1",
                "/bodies/2/mas: found unknown key 'mas' (did you mean 'mass'?); allowed: name, shape, transform, "
                "velocity, spin, mass, density, damping, pins, attachments, tear, constraints"},
        Refusal{"NoName", "/bodies/2/name", "remove",
                "/bodies/2: found no key 'name'; allowed: an object with the key 'name'"},
        Refusal{"NoShape", "/bodies/2/shape", "remove",
                "/bodies/2: found no key 'shape'; allowed: an object with the key 'shape'"},
        Refusal{"NoMass", "/bodies/2/mass", "remove",
                "/bodies/2: found neither 'mass' nor 'density'; allowed: exactly one of them"},
        Refusal{"MassAndDensity", "/bodies/2/density", "1",
                "/bodies/2: found both 'mass' and 'density'; allowed: exactly one of them"},
        Refusal{"NegativeMass", "/bodies/2/mass", "-1", "/bodies/2/mass: found -1" + positive_kg},
        Refusal{"ZeroMass", "/bodies/2/mass", "0", "/bodies/2/mass: found 0" + positive_kg},
        Refusal{"MassAsText", "/bodies/2/mass", "\"1 kg\"", "/bodies/2/mass: found \"1 kg\"" + positive_kg},
        Refusal{"ZeroDensity", "/bodies/0/density", "0",
                "/bodies/0/density: found 0; allowed: a number > 0 (kg/m^2 of surface, kg/m of lines, kg/m^3 of "
                "tetrahedra)"},
        Refusal{"DampingAboveOne", "/bodies/0/damping", "1.1", "/bodies/0/damping: found 1.1" + ratio},
        Refusal{"NegativeDamping", "/bodies/0/damping", "-0.1", "/bodies/0/damping: found -0.1" + ratio},
        Refusal{
            "DensityOfACloud", "/bodies/6",
            R"({"name": "c", "density": 1, "shape": {"lattice": {"min": [0,0,0], "max": [1,1,1], "count": [2,2,2]}}})",
            "/bodies/6/density: found a density of loose particles; allowed: 'mass' (kg)"},
        Refusal{"TwoPinsInOne", "/bodies/1/pins/0/nearest", "[0, 0, 0]",
                "/bodies/1/pins/0: found row, nearest; allowed: exactly one of row, box, sphere, nearest, particles"},
        Refusal{"UnknownRow", "/bodies/1/pins/0/row", "\"lats\"",
                "/bodies/1/pins/0/row: found unknown row \"lats\" (did you mean 'last'?); allowed: first, last"},
        Refusal{"RowOfASphere", "/bodies/2/pins", "[{\"row\": \"first\"}]",
                "/bodies/2/pins/0/row: found a row of a shape that has no rows; allowed: rows of a grid or a chain"},
        Refusal{"PinBoxInsideOut", "/bodies/1/pins/1/box/max", "[1, -1, 2]",
                "/bodies/1/pins/1/box/max/1: found -1; allowed: a number not below that of 'min' (m)"},
        Refusal{"PinSphereWithoutRadius", "/bodies/1/pins/2/sphere/radius", "0",
                "/bodies/1/pins/2/sphere/radius: found 0; allowed: a number > 0 (m)"},
        Refusal{"NegativePinnedParticle", "/bodies/1/pins/4/particles", "[-1]",
                "/bodies/1/pins/4/particles/0: found -1; allowed: an integer in [0, 2147483647]"},
        Refusal{"NoPinnedParticle", "/bodies/1/pins/4/particles", "[]",
                "/bodies/1/pins/4/particles: found a list of 0; allowed: a list of particle numbers, from 0"}),
    name_of_refusal);

INSTANTIATE_TEST_SUITE_P(
    Constraints, ParseSceneRefuses,
    testing::Values(
        Refusal{"NoType", "/bodies/0/constraints/0/type", "remove",
                "/bodies/0/constraints/0: found no key 'type'; allowed: an object with the key 'type'"},
        Refusal{"StiffnessAboveOne", "/bodies/0/constraints/0/stiffness", "1.5",
                "/bodies/0/constraints/0/stiffness: found 1.5" + ratio},
        Refusal{"NegativeStiffness", "/bodies/0/constraints/0/stiffness", "-0.5",
                "/bodies/0/constraints/0/stiffness: found -0.5" + ratio},
        Refusal{"NegativeCompliance", "/bodies/0/constraints/1/compliance", "-1",
                "/bodies/0/constraints/1/compliance: found -1; allowed: a number >= 0 (m/N for lengths, rad/(N m) for "
                "angles, m^5/N for volumes)"},
        Refusal{"StiffnessAndCompliance", "/bodies/0/constraints/0/compliance", "1",
                "/bodies/0/constraints/0/compliance: found both 'stiffness' and 'compliance'; allowed: one of them"},
        Refusal{
            "StiffnessAndRigidity", "/bodies/0/constraints/0/rigidity", "1",
            "/bodies/0/constraints/0/rigidity: found 'rigidity' beside 'stiffness' or 'compliance'; allowed: one of "
            "them"},
        Refusal{"NoRigidity", "/bodies/0/constraints/2/rigidity", "0",
                "/bodies/0/constraints/2/rigidity: found 0; allowed: a number > 0 (N m)"},
        Refusal{"UnknownElement", "/bodies/0/constraints/0/elements", "[\"edge\"]",
                "/bodies/0/constraints/0/elements/0: found unknown element \"edge\" (did you mean 'edges'?); allowed: "
                "edges, "
                "shear"},
        Refusal{"NoElement", "/bodies/0/constraints/0/elements", "[]",
                "/bodies/0/constraints/0/elements: found a list of 0; allowed: a list of edges, shear"},
        Refusal{"ZeroRestScaleOfDistance", "/bodies/0/constraints/0/rest_scale", "0",
                "/bodies/0/constraints/0/rest_scale: found 0; allowed: a number > 0"},
        Refusal{"NegativeLimit", "/bodies/0/constraints/1/limit", "-0.1",
                "/bodies/0/constraints/1/limit: found -0.1; allowed: a number >= 0"},
        Refusal{"NegativeRestScaleOfBending", "/bodies/0/constraints/2/rest_scale", "-1",
                "/bodies/0/constraints/2/rest_scale: found -1; allowed: a number >= 0"},
        Refusal{"ElementsOfBending", "/bodies/0/constraints/2/elements", "[\"edges\"]",
                "/bodies/0/constraints/2/elements: found unknown key 'elements'; allowed: type, stiffness, compliance, "
                "rest_scale, "
                "rigidity"},
        Refusal{"NegativeRestScaleOfVolume", "/bodies/7/constraints/0/rest_scale", "-1",
                "/bodies/7/constraints/0/rest_scale: found -1; allowed: a number >= 0"},
        Refusal{"NoYoungModulus", "/bodies/7/constraints/1/young_modulus", "remove",
                "/bodies/7/constraints/1: found no key 'young_modulus'; allowed: an object with the key "
                "'young_modulus'"},
        Refusal{"ZeroYoungModulus", "/bodies/7/constraints/1/young_modulus", "0",
                "/bodies/7/constraints/1/young_modulus: found 0; allowed: a number > 0 (Pa)"},
        Refusal{"Incompressible", "/bodies/7/constraints/1/poisson_ratio", "0.5",
                "/bodies/7/constraints/1/poisson_ratio: found 0.5; allowed: a number in [0, 0.499]"},
        Refusal{"NoYoungModulusOfAMembrane", "/bodies/2/constraints/2/young_modulus", "remove",
                "/bodies/2/constraints/2: found no key 'young_modulus'; allowed: an object with the key "
                "'young_modulus'"},
        Refusal{"ZeroYoungModulusOfAMembrane", "/bodies/2/constraints/2/young_modulus", "0",
                "/bodies/2/constraints/2/young_modulus: found 0; allowed: a number > 0 (N/m)"},
        Refusal{"AsStiffAgainstAreaAsCanBe", "/bodies/2/constraints/2/poisson_ratio", "1",
                "/bodies/2/constraints/2/poisson_ratio: found 1; allowed: a number in [0, 0.95]"},
        Refusal{"StiffnessOfAMaterial", "/bodies/7/constraints/1/stiffness", "1",
                "/bodies/7/constraints/1/stiffness: found unknown key 'stiffness'; allowed: type, poisson_ratio, "
                "young_modulus"},
        Refusal{"ZeroVolumeRatio", "/bodies/0/constraints/3/volume_ratio", "0",
                "/bodies/0/constraints/3/volume_ratio: found 0; allowed: a number > 0"},
        Refusal{"PressureAsItWasCalled", "/bodies/0/constraints/3/pressure", "1.2",
                "/bodies/0/constraints/3/pressure: found 'pressure', which is a ratio of volumes, not a pressure; "
                "allowed: 'volume_ratio'"}),
    name_of_refusal);

INSTANTIATE_TEST_SUITE_P(
    Shapes, ParseSceneRefuses,
    testing::Values(
        Refusal{"None", "/bodies/0/shape", "{}",
                "/bodies/0/shape: found an empty object; allowed: exactly one of mesh, grid, sphere, box, bar, "
                "mesh_data, chain, lattice, tet_box"},
        Refusal{"Unknown", "/bodies/0/shape", "{\"shpere\": {}}",
                "/bodies/0/shape/shpere: found unknown key 'shpere' (did you mean 'sphere'?); allowed: mesh, grid, "
                "sphere, box, bar, mesh_data, chain, lattice, tet_box, weld"},
        Refusal{"EmptyPath", "/bodies/0/shape/mesh", "\"\"",
                "/bodies/0/shape/mesh: found \"\"; allowed: a non-empty string of one line"},
        Refusal{"ZeroCells", "/bodies/1/shape/grid/cells", "[0, 1]",
                "/bodies/1/shape/grid/cells/0: found 0; allowed: an integer in [1, 100000]"},
        Refusal{"TooManyCells", "/bodies/1/shape/grid/cells", "[100000, 100000]",
                "/bodies/1/shape/grid/cells: found [100000, 100000], which makes 10000200001 particles; allowed: "
                "counts that make at most 20000000 particles"},
        Refusal{"TooManyBoxCells", "/bodies/3/shape/box/cells", "[100000, 100000, 1]",
                "/bodies/3/shape/box/cells: found [100000, 100000, 1], which makes 20000400002 particles; allowed: "
                "counts that make at most 20000000 particles"},
        Refusal{"TooManyBarCells", "/bodies/4/shape/bar/cells", "100000",
                "/bodies/4/shape/bar/cells: found 100000; allowed: a number of cells for which at most 100000 fit "
                "along the length"},
        Refusal{"TooManyLooseParticles", "/bodies/6/shape/lattice/count", "[100000, 1000, 1]",
                "/bodies/6/shape/lattice/count: found [100000, 1000, 1], which makes 100000000 particles; allowed: "
                "counts that make at most 20000000 particles"},
        Refusal{"TooManySubdivisions", "/bodies/2/shape/sphere/subdivisions", "11",
                "/bodies/2/shape/sphere/subdivisions: found 11; allowed: an integer in [0, 10]"},
        Refusal{"ZeroRadius", "/bodies/2/shape/sphere/radius", "0",
                "/bodies/2/shape/sphere/radius: found 0; allowed: a number > 0 (m)"},
        Refusal{"ChainWithoutLength", "/bodies/5/shape/chain/to", "[0, 0, 0]",
                "/bodies/5/shape/chain/to: found the same point as 'from'; allowed: another point"},
        Refusal{"TooManyTetrahedra", "/bodies/7/shape/tet_box/cells", "[1000, 1000, 1000]",
                "/bodies/7/shape/tet_box/cells: found [1000, 1000, 1000], which makes 1003003001 particles; allowed: "
                "counts that make at most 20000000 particles"},
        Refusal{"FlatTetBox", "/bodies/7/shape/tet_box/size/1", "0",
                "/bodies/7/shape/tet_box/size/1: found 0; allowed: a number > 0 (m)"},
        Refusal{"ListedFaceOfTwo", "/bodies/8/shape/mesh_data/faces/0", "[0, 1]",
                "/bodies/8/shape/mesh_data/faces/0: found a list of 2; allowed: a list of 3 or 4 vertices, from 0"},
        Refusal{"NoListedPoint", "/bodies/8/shape/mesh_data/points", "[]",
                "/bodies/8/shape/mesh_data/points: found a list of 0; allowed: a list of points (m)"},
        Refusal{"CloudInsideOut", "/bodies/6/shape/lattice/max", "[1, 0, 0]",
                "/bodies/6/shape/lattice/max/1: found 0; allowed: a number above that of 'min' (m)"},
        Refusal{"ZeroAxis", "/bodies/0/transform/rotate/axis", "[0, 0, 0]",
                "/bodies/0/transform/rotate/axis: found a zero axis; allowed: a direction"},
        Refusal{"ZeroScale", "/bodies/1/transform/scale", "0",
                "/bodies/1/transform/scale: found 0; allowed: a number > 0 (a ratio, one for all directions or a list "
                "of 3)"},
        Refusal{"NegativeScale", "/bodies/0/transform/scale", "[1, -1, 1]",
                "/bodies/0/transform/scale/1: found -1; allowed: a number > 0"}),
    name_of_refusal);

INSTANTIATE_TEST_SUITE_P(
    Surroundings, ParseSceneRefuses,
    testing::Values(
        Refusal{
            "ShapeWithoutFaces", "/environment/1/shape",
            R"({"chain": {"from": [0,0,0], "to": [1,0,0], "segments": 1}})",
            "/environment/1/shape/chain: found unknown key 'chain'; allowed: mesh, grid, sphere, box, bar, mesh_data, "
            "weld"},
        Refusal{"UnknownSides", "/environment/0/sides", "\"twosided\"",
                "/environment/0/sides: found unknown value of sides \"twosided\" (did you mean 'two_sided'?); allowed: "
                "solid, one_sided, two_sided"},
        Refusal{"ZeroThickness", "/environment/1/thickness", "0",
                "/environment/1/thickness: found 0; allowed: a number > 0 (m)"},
        Refusal{"NegativeFriction", "/environment/1/friction", "-1",
                "/environment/1/friction: found -1; allowed: a number >= 0"},
        Refusal{"RestitutionAboveOne", "/environment/1/restitution", "1.01",
                "/environment/1/restitution: found 1.01" + ratio},
        Refusal{"NegativeRestitution", "/environment/1/restitution", "-1",
                "/environment/1/restitution: found -1" + ratio},
        Refusal{"TimesThatDoNotIncrease", "/environment/3/motion/2/time", "0.5",
                "/environment/3/motion/2/time: found 0.5; allowed: a time after that of the keyframe before it (s)"},
        Refusal{"ZeroAxisOfMotion", "/environment/3/motion/2/rotate/axis", "[0, 0, 0]",
                "/environment/3/motion/2/rotate/axis: found a zero axis; allowed: a direction"},
        Refusal{
            "UnknownFormat", "/outputs/frames/formats", "[\"vtk\"]",
            "/outputs/frames/formats/0: found unknown format \"vtk\" (did you mean 'vtp'?); allowed: vtp, pc2, ply, "
            "obj, glb"},
        Refusal{"NegativeEvery", "/outputs/frames/every", "-1",
                "/outputs/frames/every: found -1; allowed: an integer in [0, 1000000000]"},
        Refusal{"TooSmallAPage", "/outputs/page/max_megabytes", "1",
                "/outputs/page/max_megabytes: found 1; allowed: a number in [2, 400] (MB)"},
        Refusal{"EmptyPicture", "/outputs/pictures/size", "[0, 720]",
                "/outputs/pictures/size/0: found 0; allowed: an integer in [1, 16384]"},
        Refusal{"CameraInItsTarget", "/outputs/pictures/camera/target", "[1, 2, 3]",
                "/outputs/pictures/camera/target: found the same point as 'eye'; allowed: another point"},
        Refusal{"FlatView", "/outputs/pictures/camera/fov_degrees", "180",
                "/outputs/pictures/camera/fov_degrees: found 180; allowed: a number in [1, 170] (degrees)"},
        Refusal{"NegativeStrain", "/expect/max_strain", "-1", "/expect/max_strain: found -1; allowed: a number >= 0"},
        Refusal{"RoomInsideOut", "/expect/bounds/min", "[-1, 3, -3]",
                "/expect/bounds/max/1: found 2; allowed: a number not below that of 'min' (m)"},
        Refusal{"HalfInverted", "/expect/inverted_tetrahedra", "0.5",
                "/expect/inverted_tetrahedra: found 0.5; allowed: an integer in [0, 1000000000]"},
        Refusal{"StrainInWords", "/expect/max_strain", "\"small\"",
                "/expect/max_strain: found \"small\"; allowed: a number >= 0, or an object with at_least, at_most"},
        Refusal{"StrainOfNothing", "/expect/max_strain", "{}",
                "/expect/max_strain: found an empty object; allowed: at least one of at_least, at_most"},
        Refusal{"StrainInReverse", "/expect/max_strain", R"({"at_least": 0.2, "at_most": 0.1})",
                "/expect/max_strain/at_most: found 0.1; allowed: a number not below that of 'at_least'"},
        Refusal{"StrainMisspelt", "/expect/rms_strain/at_leest", "1",
                "/expect/rms_strain/at_leest: found unknown key 'at_leest' (did you mean 'at_least'?); allowed: "
                "at_least, at_most"},
        Refusal{"EnergyInReverse", "/expect/energy_not_below", "5",
                "/expect/energy_not_above: found -5; allowed: a number not below 'energy_not_below' (J)"},
        Refusal{
            "BoxOfAStranger", "/expect/bodies/0/name", "\"bal\"",
            "/expect/bodies/0/name: found unknown body \"bal\" (did you mean 'ball'?); allowed: from a file, sheet, "
            "ball, crate, beam, rope, shot, jelly, in place"},
        Refusal{"BoxTwice", "/expect/bodies/1", R"({"name": "ball", "bounds": {"min": [0, 0, 0], "max": [1, 1, 1]}})",
                "/expect/bodies/1/name: found \"ball\"; allowed: each body once"},
        Refusal{"BoxOfNoBody", "/expect/bodies", "[]", "/expect/bodies: found no body; allowed: at least one"},
        Refusal{"VolumesInReverse", "/expect/volume_ratio", "[1, 0.5]",
                "/expect/volume_ratio/1: found 0.5; allowed: a number not below the first"}),
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

/// The places of a refusal's lines.
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
  // The names that expectations and self-collision use, rows of a shape that is none, a mass that is misspelt.
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
