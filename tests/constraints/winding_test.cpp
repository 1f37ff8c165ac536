// SPDX-License-Identifier: Apache-2.0
// Face orientation does not change bending: a sheet with randomly flipped faces has the energy and the sag of the sheet
// whose faces agree.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "host/measure/measure.h"
#include "host/mesh/generate.h"
#include "host/mesh/io/mesh_io.h"
#include "host/mesh/topology.h"
#include "host/report/warnings.h"
#include "malha/error.h"
#include "malha/simulation.h"
#include "tests/constraints/cantilever.h"
#include "tests/constraints/mixed_sheet.h"
#include "tests/mesh/irregular_mesh.h"
#include "tests/support.h"

namespace malha {
namespace {

/// Flips half of the faces, keeping their first corner, so that quads are split along the same diagonals.
Mesh wound_by_chance(Mesh mesh, unsigned seed) {
  Random random(seed);
  for (Quad& face : mesh.faces)
    if (random.below(2) == 0) std::swap(face[1], face[is_triangle(face) ? 2 : 3]);
  return mesh;
}

struct Wound {
  std::string name;
  Shape alike, by_chance;
};

/// Sheets of width x length: a grid of quads, and an irregular triangulation.
std::vector<Wound> wound_sheets(const TemporaryFolder& folder, double width, double length, int across, int along) {
  std::vector<Wound> all;
  const auto add = [&](const std::string& name, const Mesh& mesh) {
    all.push_back({name, MeshFile{folder.write(name + ".obj", obj_of(mesh))},
                   MeshFile{folder.write(name + "_wound.obj", obj_of(wound_by_chance(mesh, 7)))}});
  };
  add("quads", generate(GridShape{{width, length}, {across, along}}));
  add("triangles", read_mesh(folder.write("source.obj", irregular_obj(width, length, across, along, 0.25, 5, 2))));
  return all;
}

/// Energy of a saddle that a sheet of such a shape is bent to, J.
double energy_of_a_saddle(const Shape& shape, const ConstraintSpec& bends, const std::string& method) {
  BodySpec body;
  body.name = "sheet", body.shape = shape, body.mass = 1, body.constraints = {bends};
  if (method == "desbrun") body.constraints.push_back(compliant("distance", 1e-2, {"edges"}));
  Scene scene = scene_of({body}, {0, 0, 0}, 1.0 / 60);
  scene.solver.type = method;
  const Model model = build_model(scene);
  std::vector<Vec3> x = model.x;
  for (Vec3& at : x) at[1] = 0.3 * at[0] * at[0] - 0.2 * at[0] * at[2] - 0.1 * at[2] * at[2];
  Measures measures;
  measure_constraints(Serial{}, model, x, measures);
  return measures.elastic;
}

ConstraintSpec of_rigidity(const std::string& type, double rigidity) {
  ConstraintSpec spec = stiff(type, {}, 1, type == "plate" ? 0 : 1);
  spec.rigidity = rigidity;
  return spec;
}

TEST(Winding, DoesNotChangeTheEnergyOfWhatBends) {
  const TemporaryFolder folder;
  for (const auto& [name, alike, by_chance] : wound_sheets(folder, 1, 1.5, 8, 12))
    for (const char* type : {"bending", "isometric_bending", "plate"})
      for (const char* method : {"pbd", "desbrun"}) {
        std::vector<ConstraintSpec> ways{of_rigidity(type, 0.1)};
        if (std::string(type) != "plate") ways.push_back(compliant(type, 10));
        for (const ConstraintSpec& bends : ways) {
          const double expected = energy_of_a_saddle(alike, bends, method);
          EXPECT_GT(expected, 1e-6) << name << ", " << type << ", " << method;
          // The sum of some hundred terms is taken in another order.
          EXPECT_NEAR(energy_of_a_saddle(by_chance, bends, method) / expected, 1, 1e-12)
              << name << ", " << type << ", " << method;
        }
      }
}

TEST(Winding, DoesNotChangeHowFarAStripSags) {
  constexpr double L = 0.3, W = L / 3;
  const double D = 0.2 * 9.81 * std::pow(L, 3) / (8 * 0.1);
  const TemporaryFolder folder;
  for (const auto& [name, alike, by_chance] : wound_sheets(folder, W, L, 2, 6))
    for (const char* type : {"bending", "isometric_bending", "plate"})
      for (const char* method : {"pbd", "desbrun"}) {
        const auto sag = [&](const Shape& shape) {
          return sag_of({shape, W, L, 2, 6}, of_rigidity(type, D), D, method);
        };
        const double expected = sag(alike);
        EXPECT_GT(expected, 0.02 * L) << name << ", " << type << ", " << method << ": it does sag";
        // The order of faces determines the order of constraints. A sweep that has not converged depends on it: by 1e-3
        // of the sag.
        EXPECT_NEAR(sag(by_chance) / expected, 1, 2e-3) << name << ", " << type << ", " << method;
      }
}

TEST(Winding, OfAMoebiusStripLeavesNoEdgeWithoutAHinge) {
  Mesh strip;  // no orientation of its faces agrees everywhere
  const int around = 24;
  for (int i = 0; i < around; ++i)
    for (const double side : {-0.2, 0.2}) {
      const double turn = 2 * kPi * i / around, half = turn / 2, r = 1 + side * std::cos(half);
      strip.points.push_back({r * std::cos(turn), side * std::sin(half), r * std::sin(turn)});
    }
  for (int i = 0; i < around; ++i) {
    const int a = 2 * i, b = a + 1, last = i + 1 == around;
    const int c = last ? 1 : a + 2, d = last ? 0 : a + 3;
    strip.faces.push_back({a, b, c, -1}), strip.faces.push_back({b, d, c, -1});
  }
  EXPECT_EQ(hinges(strip).size(), std::size_t{2 * around}) << "a strip of as many triangles has one after each";
}

/// Three triangulated sheets of 2 x 3 cells each that share an edge of three sides.
Mesh three_leaves() {
  Mesh mesh;
  for (int j = 0; j <= 3; ++j) mesh.points.push_back({0, 0, 0.1 * j});
  for (int leaf = 0; leaf < 3; ++leaf) {
    const double turn = 2 * kPi * leaf / 3;
    for (int i = 1; i <= 2; ++i)
      for (int j = 0; j <= 3; ++j) mesh.points.push_back({0.1 * i * std::cos(turn), 0.1 * i * std::sin(turn), 0.1 * j});
    const auto at = [leaf](int i, int j) { return i == 0 ? j : 4 + 8 * leaf + 4 * (i - 1) + j; };
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j < 3; ++j) {
        mesh.faces.push_back({at(i, j), at(i + 1, j), at(i, j + 1), -1});
        mesh.faces.push_back({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1), -1});
      }
  }
  return mesh;
}

TEST(Winding, WhereMoreThanTwoFacesMeetIsSaidToHaveNoBending) {
  const TemporaryFolder folder;
  folder.write("leaves.obj", obj_of(three_leaves()));
  for (const char* type : {"bending", "isometric_bending", "plate"}) {
    const std::string bends = std::string(type) == "bending" ? R"("stiffness": 0.5)" : R"("rigidity": 0.1)";
    folder.write("leaves.json", std::string(R"({"name": "leaves", "solver": {"type": "pbd", "dt": 0.01},
      "bodies": [{"name": "book", "shape": {"mesh": "leaves.obj"}, "mass": 1, "constraints": [{"type": ")") +
                                    type + "\", " + bends + R"(}]}], "duration": 0.01})");
    const std::string said = std::string("body 'book': \"") + type + "\" does not act at 3 edges with more than two";
    const Ended plan = malha_command({"plan", "leaves.json"}, folder / ""),
                run = malha_command({"run", "leaves.json"}, folder / "");
    EXPECT_EQ(plan.status, 0) << plan.err;
    EXPECT_TRUE(has(plan.err, said)) << plan.err;
    EXPECT_TRUE(has(run.err, said)) << run.err;
    EXPECT_TRUE(has(malha_command({"check", "leaves.json"}, folder / "").out, said));
    EXPECT_TRUE(has(bytes_of(folder / "out/leaves/report.json"), "3 edges with more than two"));
  }
  EXPECT_TRUE(warnings(build_model(scene_of({[&] {
                                              BodySpec body;
                                              body.name = "sheet", body.shape = GridShape{}, body.mass = 1;
                                              body.constraints = {stiff("bending")};
                                              return body;
                                            }()},
                                            {}, 0.01)))
                  .empty());
}

TEST(Winding, OfAClosedBodyMattersToPressureWhichSaysSo) {
  const TemporaryFolder folder;
  BodySpec ball;
  ball.name = "ball", ball.mass = 1, ball.constraints = {stiff("pressure")};
  ball.shape = MeshFile{folder.write("ball.obj", obj_of(wound_by_chance(generate(SphereShape{1, 2}), 3)))};
  try {
    build_model(scene_of({ball}, {}, 0.01));
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_TRUE(has(error.what(), "two faces have opposite orientations")) << error.what();
    EXPECT_TRUE(has(error.what(), "pressure needs a closed mesh")) << error.what();
  }
}

}  // namespace
}  // namespace malha
