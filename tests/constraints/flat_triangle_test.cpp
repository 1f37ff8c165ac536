// SPDX-License-Identifier: Apache-2.0
// Desbrun's method on meshes with a nearly flat triangle, as public meshes have them: its hinges are no stiffer than
// others, or a message names them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "host/mesh/generate.h"
#include "host/mesh/vectors.h"
#include "tests/filter/filter_reference.h"
#include "tests/refusal.h"

namespace malha {
namespace {

constexpr double kFlatness = 3e-6;  // height of the flattest triangle over its edge

/// A sphere of which one vertex lies nearly on the opposite edge of one of its triangles: between the edge's ends, or
/// `beyond` one of them by that many of its lengths.
BodySpec flattened_sphere(double along, std::vector<ConstraintSpec> constraints) {
  Mesh mesh = generate(SphereShape{0.5, 2});
  const Quad face = mesh.faces[57];
  const Vec3 a = mesh.points[face[0]], e = minus(mesh.points[face[1]], a), h = minus(mesh.points[face[2]], a);
  for (int k = 0; k < 3; ++k)
    mesh.points[face[2]][k] = a[k] + along * e[k] + kFlatness * (h[k] - dot(h, e) / dot(e, e) * e[k]);
  BodySpec body;
  body.name = "ball", body.mass = 1;
  body.shape = MeshDataShape{mesh.points, mesh.faces, {}, {}};
  body.constraints = std::move(constraints);
  return body;
}

std::string refusal_of(Scene scene) {
  scene.file = "test.json";
  return refusal([&] { Simulation(scene, {.threads = 1}); });
}

/// A stiff spring that is stretched or folded conserves its energy: a body that gains any diverges.
TEST(AFlatTriangle, KeepsNoHingeFromTheFilterWhateverTheSpringConstant) {
  for (const char* type : {"bending", "isometric_bending"})
    for (const double along : {0.5, 0.1, 1.5})
      for (const double constant : {1.0, 1e4, 1e6}) {
        SCOPED_TRACE(std::string(type) + " " + std::to_string(along) + " " + std::to_string(constant));
        const BodySpec ball = flattened_sphere(along, {stiff("distance", {"edges"}), stiff(type)});
        Scene scene = desbrun_scene({ball}, constant, Precision::Float);
        scene.gravity = kEarth;
        ASSERT_EQ(refusal_of(scene), "");
        Simulation simulation(scene, {.threads = 1});
        for (int step = 0; step < 30; ++step) simulation.step();
        // It falls without deforming: only rounding pulls at it, 1e-7 of 10 N m of momentum over some mg.
        EXPECT_LT(simulation.measure().strain_rms, 1e-4);
      }
}

TEST(AFlatTriangle, IsNamedWhereItsComplianceMakesItTooStiffForTheOthers) {
  const BodySpec ball = flattened_sphere(0.5, {stiff("distance", {"edges"}), compliant("bending", 1e-12)});
  const std::string said = refusal_of(desbrun_scene({ball}, 1e4, Precision::Float));
  EXPECT_NE(said.find("/solver/dt: found "), std::string::npos) << said;
  EXPECT_NE(said.find("'bending' at vertices "), std::string::npos) << said;
  EXPECT_NE(said.find(" of body 'ball' is "), std::string::npos) << said;
}

/// A triangle with a face on either side, as in scans and welded models: each of its hinges has one vertex twice.
TEST(QuadsWithTwoCommonEdges, PutNothingIntoTheFilterThatIsOfOneParticleAlone) {
  for (const char* type : {"bending", "isometric_bending"}) {
    BodySpec body = flattened_sphere(0.5, {stiff("distance", {"edges"}), stiff(type)});
    auto& shape = std::get<MeshDataShape>(body.shape);
    const int n = static_cast<int>(shape.points.size());
    for (const Vec3& at : {Vec3{0.1, 1, 0}, {0, 1, 0}, {0, 1, 0.1}, {0.1, 1, 0.1}, {0.12, 1, 0.12}})
      shape.points.push_back(at);
    shape.faces.push_back({n, n + 1, n + 2, n + 3}), shape.faces.push_back({n + 2, n + 1, n, n + 4});
    const Scene scene = desbrun_scene({body}, 1e4);
    ASSERT_EQ(refusal_of(scene), "");
    const Model model = build_model(scene);
    const SpringSystem system = spring_system(model, 0.01);
    for (int i = 0; i < system.count(); ++i)
      for (int k = system.begin[i]; k < system.begin[i + 1]; ++k) ASSERT_NE(system.column[k], i);
  }
}

}  // namespace
}  // namespace malha
