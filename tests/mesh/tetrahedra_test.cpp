// SPDX-License-Identifier: Apache-2.0
// Bodies of tetrahedra: their surface, mass, volume and edges, and the options that scenes allow for them.
#include "host/mesh/tetrahedra.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "host/mesh/check_mesh.h"
#include "host/mesh/generate.h"
#include "host/mesh/topology.h"
#include "malha/error.h"
#include "malha/simulation.h"
#include "tests/mesh/mesh_files.h"
#include "tests/scene_builders.h"

namespace malha {
namespace {

const TetBoxShape box{{1, 2, 3}, {2, 3, 4}};

TEST(TetBox, FillsItsBoxWithFiveTetrahedraACell) {
  const Mesh mesh = generate(box);
  EXPECT_EQ(mesh.points.size(), 3u * 4 * 5);
  EXPECT_EQ(mesh.tetrahedra.size(), 5u * 2 * 3 * 4);
  double sum = 0;
  for (const Tetrahedron& t : mesh.tetrahedra) {
    const double V = volume(mesh.points, t), cell = 6.0 / 24;
    EXPECT_TRUE(std::abs(V - cell / 6) < 1e-12 || std::abs(V - cell / 3) < 1e-12) << V;
    sum += V;
  }
  EXPECT_NEAR(sum, 6, 1e-12);
}

TEST(Tetrahedra, HaveAClosedSurfaceThatFacesOutwards) {
  Mesh mesh = generate(box);
  EXPECT_NO_THROW(require_closed(mesh, "box", "a test"));
  EXPECT_NEAR(signed_volume(mesh.points, triangles(mesh)), 6, 1e-12);
  EXPECT_EQ(mesh.faces.size(), 4u * (2 * 3 + 3 * 4 + 4 * 2));
  EXPECT_EQ(check_mesh(mesh, "box", false), 0);
}

TEST(Tetrahedra, HaveTheEdgesInsideToo) {
  const Mesh mesh = generate(TetBoxShape{{1, 1, 1}, {2, 2, 2}});
  // Euler: points - edges + triangles - tetrahedra = 1 for a full ball.
  const int tets = 40, surface = 48, inner = (4 * tets - surface) / 2;
  EXPECT_EQ(static_cast<int>(edges(mesh).size()), 27 + surface + inner - tets - 1);
}

TEST(Tetrahedra, ShareMassByVolume) {
  const Mesh mesh = generate(box);
  const std::vector<double> by_density = masses_by_density(mesh, 1000), by_total = masses_by_total(mesh, 6000);
  EXPECT_NEAR(std::accumulate(by_density.begin(), by_density.end(), 0.0), 6000, 1e-9);
  for (std::size_t i = 0; i < by_density.size(); ++i) EXPECT_NEAR(by_density[i], by_total[i], 1e-9);
  Mesh one;
  one.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  one.tetrahedra = {{0, 1, 2, 3}};
  complete_tetrahedra(one, "one");
  for (const double m : masses_by_density(one, 24)) EXPECT_NEAR(m, 1, 1e-15) << "a quarter of 24 kg/m^3 / 6 m^3";
}

TEST(TetrahedraWithVolumeConstraints, TakeTheVolumeThatTheyAreTold) {
  BodySpec jelly = body("jelly", TetBoxShape{{1, 1, 1}, {2, 2, 2}},
                        {with_compliance("distance", 1e-2), with_compliance("volume", 0, 1.25)});
  jelly.damping = 0.2;
  Scene scene = scene_of({jelly});
  Simulation simulation(scene, {.threads = 1});
  for (int step = 0; step < 120; ++step) simulation.step();
  const Measures m = simulation.measure();
  ASSERT_EQ(m.volume_ratios.size(), 1u);
  EXPECT_NEAR(m.volume_ratios[0], 1.25, 0.01) << "against soft edges";
  EXPECT_EQ(m.inverted_tetrahedra, 0);
}

TEST(TetrahedraInScenes, AreNeededByTheirConstraintsAndExpectations) {
  const auto said = [](const Scene& scene) { return refusal([&] { Simulation simulation(scene, {.threads = 1}); }); };
  for (const ConstraintSpec& spec : {constraint("volume"), neo_hookean(1e5, 0.3)})
    EXPECT_NE(said(scene_of({body("ball", SphereShape{}, {spec})}))
                  .find("found a mesh without elements for " + spec.type +
                        "; allowed: a mesh of tetrahedra: tet_box, .mesh, .msh, .node and .ele"),
              std::string::npos);
  Scene scene = scene_of({body("ball", SphereShape{}, {constraint("distance")})});
  scene.expect.inverted_tetrahedra = 0;
  EXPECT_NE(
      said(scene).find("/expect/inverted_tetrahedra: found an expectation about tetrahedra in a scene without any"),
      std::string::npos);
}

TEST(TetrahedraUnderDesbrun, HaveEdgesAsSpringsAndVolumesProjectedAfterThem) {
  BodySpec jelly =
      body("jelly", TetBoxShape{{1, 1, 1}, {2, 2, 2}}, {constraint("distance"), constraint("volume", 1.2)});
  Scene scene = scene_of({jelly});
  scene.solver.type = "desbrun", scene.solver.substeps = 1, scene.solver.iterations = 10;
  scene.solver.desbrun.spring_constant = 10;
  Simulation simulation(scene, {.threads = 1});
  for (int step = 0; step < 30; ++step) simulation.step();
  EXPECT_NEAR(simulation.measure().volume_ratios[0], 1.2, 0.05);
}

}  // namespace
}  // namespace malha
