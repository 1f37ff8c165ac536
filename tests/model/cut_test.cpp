// SPDX-License-Identifier: Apache-2.0
// Cuts by the user: the parts that they separate, and what stays unchanged.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "host/mesh/topology.h"
#include "host/model/tear.h"
#include "host/solver/solver.h"
#include "tests/mesh/irregular_mesh.h"
#include "tests/refusal.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

BodySpec cloth_to_cut(const Shape& shape) {
  BodySpec cloth;
  cloth.name = "cloth", cloth.mass = 0.2, cloth.shape = shape;
  cloth.constraints = {stiff("distance", {"edges"}), compliant("bending", 0.01)};
  cloth.tear = Tear{100};  // so high that only cuts separate the mesh
  return cloth;
}

/// The edges that a knife cuts: those from a vertex where `way` is negative to one where it is not.
using Knife = std::function<double(const Vec3&)>;
std::vector<Edge> crossed_by(
    const Simulation& simulation, const Knife& way,
    const std::function<bool(const Vec3&)>& reaches = [](const Vec3&) { return true; }) {
  const RenderMesh& render_mesh = simulation.model().render_mesh;
  const std::vector<Vec3> x = simulation.positions();
  std::vector<Edge> crossed;
  for (std::size_t b = 0; b + 1 < render_mesh.body_begin.size(); ++b)
    for (Edge e : edges(body_mesh(render_mesh, b))) {
      for (int& end : e) end += render_mesh.body_begin[b];
      const Vec3 middle{(x[e[0]][0] + x[e[1]][0]) / 2, (x[e[0]][1] + x[e[1]][1]) / 2, (x[e[0]][2] + x[e[1]][2]) / 2};
      if ((way(x[e[0]]) < 0) == (way(x[e[1]]) < 0) || !reaches(middle)) continue;
      crossed.push_back(way(x[e[0]]) < 0 ? e : Edge{e[1], e[0]});
    }
  return crossed;
}

/// The number of parts that all faces and lines with shared vertices form, and the part of each particle.
int parts_of(const Simulation& simulation, std::vector<int>* of = nullptr) {
  const RenderMesh& render_mesh = simulation.model().render_mesh;
  std::vector<Edge> all;
  for (const Quad& f : render_mesh.faces)
    for (int k = 1; k < 4; ++k)
      if (f[k] >= 0) all.push_back({f[0], f[k]});
  all.insert(all.end(), render_mesh.lines.begin(), render_mesh.lines.end());
  int count = 0;
  const std::vector<int> part = components(simulation.model().count(), all, count);
  if (of) *of = part;
  return count;
}

double mass_left(const Simulation& simulation) {
  double sum = 0;
  for (const double w : simulation.model().w) sum += w > 0 ? 1 / w : 0;
  return sum;
}

/// Vertices of faces and lines that no cut edge crosses: elements that are crossed can be separated from them.
std::vector<bool> beside(const Simulation& simulation, const std::vector<Edge>& crossed) {
  const RenderMesh& render_mesh = simulation.model().render_mesh;
  std::vector<bool> found(simulation.model().count(), false);
  const auto visit = [&](const auto& element) {
    const auto has_it = [&](int end) { return std::find(element.begin(), element.end(), end) != element.end(); };
    for (const Edge& e : crossed)
      if (has_it(e[0]) && has_it(e[1])) return;
    for (const int corner : element)
      if (corner >= 0) found[corner] = true;
  };
  for (const Quad& face : render_mesh.faces) visit(face);
  for (const Edge& line : render_mesh.lines) visit(line);
  return found;
}

void expect_parted(const Simulation& simulation, const std::vector<Edge>& edges) {
  const RenderMesh& render_mesh = simulation.model().render_mesh;
  const auto has_both = [](const auto& element, const Edge& e) {
    return std::find(element.begin(), element.end(), e[0]) != element.end() &&
           std::find(element.begin(), element.end(), e[1]) != element.end();
  };
  for (const Edge& e : edges) {
    for (const Quad& face : render_mesh.faces) EXPECT_FALSE(has_both(face, e)) << e[0] << "-" << e[1];
    for (const Edge& line : render_mesh.lines) EXPECT_FALSE(has_both(line, e)) << e[0] << "-" << e[1];
  }
}

class CutOf : public testing::TestWithParam<int> {};

/// A knife from boundary to boundary: straight, slanting or curved, through triangles and quads.
TEST_P(CutOf, FromRimToRimLeavesTwoParts) {
  const TemporaryFolder folder;
  const Knife ways[] = {[](const Vec3& x) { return x[0] - 0.517; }, [](const Vec3& x) { return 0.517 - x[0]; },
                        [](const Vec3& x) { return x[2] - 0.31 - 0.43 * x[0]; },
                        [](const Vec3& x) { return x[2] - 0.5 - 0.2 * std::sin(7 * x[0] + 1); },
                        [](const Vec3& x) { return std::hypot(x[0] - 0.02, x[2] - 0.03) - 0.61; }};
  std::vector<Shape> shapes{GridShape{{1, 1}, {17, 13}}};
  for (unsigned seed = 1; seed < 6; ++seed)
    shapes.push_back(MeshFile{folder.write(std::to_string(seed) + ".obj", irregular_obj(1, 1, 19, 16, 0.3, seed))});
  for (std::size_t shape = 0; shape < shapes.size(); ++shape) {
    Scene scene = scene_of({cloth_to_cut(shapes[shape])}, kEarth, 0.01, 4);
    scene.bodies[0].spin = {0, 2, 0};
    Simulation simulation(scene, {.threads = 1});
    const Knife& way = ways[GetParam()];
    const std::vector<Edge> crossed = crossed_by(simulation, way);
    std::vector<Edge> partable = crossed;
    const std::vector<bool> left = beside(simulation, crossed);
    std::erase_if(partable, [&](const Edge& e) { return !left[e[0]]; });
    ASSERT_GT(partable.size(), crossed.size() * 3 / 4);
    ASSERT_EQ(parts_of(simulation), 1);
    const double mass = mass_left(simulation), kinetic = simulation.measure().kinetic;
    const std::vector<Vec3> x = simulation.positions(), v = simulation.velocities();

    const int split = simulation.cut(crossed);
    ASSERT_GT(split, 8);
    EXPECT_EQ(simulation.tears(), split);
    ASSERT_EQ(simulation.positions().size(), x.size() + split);
    EXPECT_TRUE(std::equal(x.begin(), x.end(), simulation.positions().begin())) << "all stay in their places";
    EXPECT_TRUE(std::equal(v.begin(), v.end(), simulation.velocities().begin()));
    EXPECT_NEAR(mass_left(simulation), mass, 1e-14);
    EXPECT_NEAR(simulation.measure().kinetic, kinetic, 1e-12) << "duplicates move as what they were";
    std::vector<int> part;
    EXPECT_EQ(parts_of(simulation, &part), 2) << "shape " << shape;
    expect_parted(simulation, partable);
    // Each part is what lies on one side of the knife, except the faces that it went through.
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (std::abs(way(x[i])) > 0.15) {
        EXPECT_EQ(part[i] == part[0], (way(x[i]) < 0) == (way(x[0]) < 0)) << i;
      }
    }
    EXPECT_EQ(simulation.cut(crossed), 0) << "nothing is left to cut";
    run_for(simulation, scene, 0.1);
  }
}

INSTANTIATE_TEST_SUITE_P(Knives, CutOf, testing::Range(0, 5));

TEST(Cut, ThatEndsInTheSheetLeavesItInOnePart) {
  Simulation simulation(scene_of({cloth_to_cut(GridShape{{1, 1}, {20, 20}})}, kEarth, 0.01), {.threads = 1});
  const std::vector<Edge> crossed = crossed_by(
      simulation, [](const Vec3& x) { return x[0] - 0.51; }, [](const Vec3& x) { return x[2] > 0.19 && x[2] < 0.81; });
  ASSERT_EQ(crossed.size(), 13u);
  EXPECT_GT(simulation.cut(crossed), 8);
  EXPECT_EQ(parts_of(simulation), 1);
  expect_parted(simulation, crossed);
}

/// A strip hangs by its first row and is cut across: the lower part falls freely, the upper one still hangs.
TEST(Cut, LetsTheLowerPartOfAStripFallFreely) {
  for (const char* const method : {"pbd", "desbrun"})
    for (const double at : {0.46, 0.02}) {  // in the middle, and right below its pins
      BodySpec strip = cloth_to_cut(GridShape{{0.25, 1}, {5, 20}});
      strip.transform.axis = {1, 0, 0}, strip.transform.degrees = 90;  // down
      strip.constraints = {compliant("distance", 1e-6, {"edges", "shear"})};
      strip.pins = {RowPin{}};
      Scene scene = scene_of({strip}, kEarth, 0.002, 1);
      scene.solver.type = method, scene.solver.iterations = 10;
      Simulation simulation(scene, {.threads = 1});
      ASSERT_LT(simulation.positions().back()[1], -0.99) << "it hangs down";
      const int split = simulation.cut(crossed_by(simulation, [at](const Vec3& x) { return -x[1] - at; }));
      EXPECT_EQ(split, 6) << "a row";
      std::vector<int> part;
      ASSERT_EQ(parts_of(simulation, &part), 2) << at;
      const std::vector<Vec3> x = simulation.positions();
      run_for(simulation, scene, 0.3);
      const std::vector<Vec3> now = simulation.positions();
      const double t = 0.3, fall = -kG * t * (t + 0.002) / 2;  // of symplectic steps, exactly
      for (std::size_t i = 0; i < x.size(); ++i) {
        if (part[i] == part[0]) {
          EXPECT_NEAR(now[i][1], x[i][1], 0.01) << method << ": what is above hangs on";
        } else {  // rounding of 150 steps
          EXPECT_NEAR(now[i][1] - x[i][1], fall, 1e-9) << method << ": particle " << i << " falls";
        }
      }
    }
}

/// The cut goes down through the row of pins: each half keeps its own pins.
TEST(Cut, ThroughPinsLeavesThemToBothParts) {
  BodySpec cloth = cloth_to_cut(GridShape{{1, 1}, {8, 8}});
  cloth.pins = {RowPin{}};
  const Scene scene = scene_of({cloth}, kEarth, 0.01, 10);
  Simulation simulation(scene, {.threads = 1});
  EXPECT_EQ(simulation.cut(crossed_by(simulation, [](const Vec3& x) { return x[0] - 0.4; })), 9);
  EXPECT_EQ(parts_of(simulation), 2);
  run_for(simulation, scene, 1);
  EXPECT_GT(simulation.positions()[8][1], -1e-6);
  for (const Vec3& x : simulation.positions()) EXPECT_GT(x[1], -1.2) << "nothing falls";
}

TEST(Cut, OfARopeCutsItOnce) {
  BodySpec rope = hung_chain({0, 0, 0}, {0, -1, 0}, 10);
  rope.constraints = {stiff("distance", {"edges"})}, rope.tear = Tear{10};
  const Scene scene = scene_of({rope}, kEarth, 0.01, 10);
  Simulation simulation(scene, {.threads = 1});
  const Edge edge{4, 5};
  EXPECT_EQ(simulation.cut({edge}), 1);
  EXPECT_EQ(parts_of(simulation), 2);
  EXPECT_EQ(simulation.cut({edge}), 0);
  run_for(simulation, scene, 0.5);
  EXPECT_LT(simulation.positions()[10][1], -2) << "its end falls";
  EXPECT_GT(simulation.positions()[4][1], -0.5) << "what hangs stays";
}

TEST(Cut, GivesTheSameBitsOnAnyThreadsAndAfterAResume) {
  BodySpec cloth = cloth_to_cut(GridShape{{1, 1}, {40, 40}});  // several patches
  cloth.pins = {RowPin{}};
  BodySpec other = cloth;
  other.name = "other", other.transform.translate = {2, 0, 0}, other.tear.reset();
  const Scene scene = scene_of({cloth, other}, kEarth, 0.01, 4, Precision::Float);
  const auto part_now = [](Simulation& simulation) {
    std::vector<Edge> crossed = crossed_by(simulation, [](const Vec3& x) { return x[2] - 0.51 - 0.3 * x[0]; });
    // without those of the other cloth, which is not cut
    std::erase_if(crossed, [](const Edge& e) { return e[0] >= 41 * 41; });
    return simulation.cut(crossed);
  };
  const TemporaryFolder folder;
  std::uint64_t expected = 0;
  for (const int threads : {1, 2, 3}) {
    Simulation whole = after(scene, 0.1, {.threads = threads});
    ASSERT_GT(part_now(whole), 20);
    run_for(whole, scene, 0.1);
    whole.save_checkpoint(folder / "checkpoint");
    run_for(whole, scene, 0.2);
    if (threads == 1) expected = whole.state_hash();
    EXPECT_EQ(whole.state_hash(), expected);
    Simulation resumed(scene, {.threads = 2});
    resumed.load_checkpoint(folder / "checkpoint");
    EXPECT_EQ(resumed.tears(), whole.tears());
    run_for(resumed, scene, 0.2);
    EXPECT_EQ(resumed.state_hash(), expected);
  }
  // After the state of before the cut is restored, the run is as if there had been none.
  Simulation undone = after(scene, 0.1);
  const std::string before = undone.save_state();
  part_now(undone);
  run_for(undone, scene, 0.1);
  undone.restore_state(before);
  EXPECT_EQ(undone.tears(), 0);
  run_for(undone, scene, 0.3);
  EXPECT_EQ(undone.state_hash(), after(scene, 0.4).state_hash());
}

TEST(Cut, KeepsParticleHandles) {
  BodySpec cloth = cloth_to_cut(GridShape{{1, 1}, {10, 10}});
  const Scene scene = scene_of({cloth, particle({5, 0, 0})}, kEarth, 0.01, 4);
  Simulation simulation(scene, {.threads = 1, .interactive = true});
  simulation.pull(60, {0.5, 0.5, 0.5}, 1e-3), simulation.pull(121, {5, 1, 0}, 1e-3);
  const int split = simulation.cut(crossed_by(simulation, [](const Vec3& x) { return x[0] - 0.52; }));
  ASSERT_EQ(split, 11) << "the column of particle 60";
  ASSERT_EQ(simulation.handles().size(), 2u);
  EXPECT_EQ(simulation.handles()[0].particle, 60);
  EXPECT_EQ(simulation.handles()[1].particle, 121 + split);
  run_for(simulation, scene, 1);
  EXPECT_LT(simulation.positions()[10][1], -3) << "the half that nobody holds falls";
  EXPECT_GT(simulation.positions()[60][1], -0.5);
}

TEST(Cut, WakesWhatSleeps) {
  BodySpec rope = hung_chain({0, 0, 0}, {0, -1, 0}, 4);
  rope.constraints = {stiff("distance", {"edges"})}, rope.tear = Tear{10};
  Scene scene = scene_of({rope}, kEarth, 0.01, 10);
  scene.sleep = Sleep{1, 0.05};
  Simulation simulation = after(scene, 0.2);
  ASSERT_EQ(simulation.solver().sleep()->particles, 5);
  simulation.cut({{1, 2}});
  simulation.step();
  EXPECT_EQ(simulation.solver().sleep()->particles, 0);
}

TEST(Cut, RefusesWhatItCannotCut) {
  BodySpec firm = cloth_to_cut(GridShape{{1, 1}, {2, 2}});
  firm.name = "firm", firm.tear.reset();
  Simulation simulation(scene_of({cloth_to_cut(GridShape{{1, 1}, {2, 2}}), firm}, kEarth, 0.01), {.threads = 1});
  EXPECT_EQ(refusal([&] {
              simulation.cut({{0, 1}, {9, 10}});
            }),
            "cut: found body 'firm', which does not tear; allowed: one with \"tear\"");
  EXPECT_EQ(refusal([&] { simulation.cut({{0, 18}}); }), "cut: found particle 18; allowed: 0 to 17");
  EXPECT_EQ(refusal([&] {
              simulation.cut({{8, 9}});
            }),
            "cut: found particle 8 of body 'cloth' and particle 0 of body 'firm'; allowed: both of one body");
  EXPECT_EQ(simulation.tears(), 0);
  EXPECT_EQ(simulation.cut({}), 0);
  EXPECT_EQ(simulation.cut({{0, 8}}), 0) << "they share nothing";
}

}  // namespace
}  // namespace malha
