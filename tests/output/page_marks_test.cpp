// SPDX-License-Identifier: Apache-2.0
// Marks in a page of a run: contacts, residuals and batches that the solver's library measured.
#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "host/fields/contacts.h"
#include "host/fields/fields.h"
#include "host/fields/forces.h"
#include "host/mesh/vectors.h"
#include "host/output/page.h"
#include "malha/simulation.h"
#include "malha/text.h"
#include "tests/mesh/irregular_sheet.h"
#include "tests/output/page_of_a_run.h"

namespace malha {
namespace {

class PageMarks : public PageOfARun {
 protected:
  /// An irregular sheet that falls onto a ball that moves, and onto the ground.
  Json falling() {
    Json scene = swinging_sheet(true);
    Random random(6);
    const std::string file = folder_.write("sheet.obj", irregular_sheet(1, 1, 14, 14, random) + "v 9 9 9\n");
    Json& body = scene["bodies"][0];
    body["shape"] = {{"mesh", file}};
    body["transform"] = {{"translate", {-0.2, 0.4, -0.5}}};  // so that it slips off
    body.erase("pins");
    body["constraints"] = {{{"type", "distance"}, {"compliance", 1e-4}}, {{"type", "bending"}, {"stiffness", 0.2}}};
    return scene;
  }
  Json awaited(const std::string& expression) {
    return Json::parse(browser()
                           .evaluate("(async () => JSON.stringify(await (async () => {" + expression + "})()))()")
                           .get<std::string>());
  }
  static void go(Simulation& simulation, std::int64_t step) {
    while (simulation.steps() < step) simulation.step();
  }
};

double dot(const Json& a, const Vec3& b) {
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) sum += a[k].get<double>() * b[k];
  return sum;
}

TEST_F(PageMarks, ShowWhereTheEnvironmentIsTouched) {
  NEEDS_BROWSER;
  const Json scene = falling();
  browser().open(page(scene));
  Simulation simulation(parsed(scene), {.threads = 1});
  const Contacts contacts(simulation.model());
  std::set<int> objects;
  for (const int step : {0, 15, 40}) {
    go(simulation, step);
    const std::vector<ContactPoint> expected =
        contacts(simulation.positions(), simulation.model().environment, simulation.time());
    browser().evaluate("malha.seek(" + shown(simulation.time()) + ")");
    browser().press("9");
    browser().screenshot();
    ASSERT_EQ(browser().evaluate("malha.look"), "contact");
    const Json found = awaited(
        "const stage = malha.views[0].stage, {marks, data} = stage, p = marks.geometry.attributes.position;"
        "return {particles: Array.from(data.touches.particles), ends: Array.from(p.array), shown: marks.visible,"
        "        far: data.touches.far, red: Array.from(stage.colours.array)}");
    ASSERT_EQ(found["particles"].size(), expected.size()) << "step " << step;
    EXPECT_TRUE(found["shown"]);
    std::set<int> touching;
    for (std::size_t t = 0; t < expected.size(); ++t) {
      const ContactPoint& touch = expected[t];
      ASSERT_EQ(found["particles"][t], touch.particle);
      const auto end = [&](std::size_t from) {
        return Json(std::vector<Json>(found["ends"].begin() + int(from), found["ends"].begin() + int(from) + 3));
      };
      const Json from = end(6 * t), to = end(6 * t + 3);
      // The particle's position is rounded by 1e-4 m; its distance by half of 127 steps, and so is the normal.
      const double rounding = 1e-4 + found["far"].get<double>() / 127;
      Vec3 way{};
      for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_NEAR(from[k].get<double>(), touch.at[k], rounding);
        way[k] = to[k].get<double>() - from[k].get<double>();
      }
      const double length = std::sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
      EXPECT_GT(dot(Json{way[0], way[1], way[2]}, touch.normal) / length, 0.999);
      EXPECT_NEAR(length, 0.16, 0.06) << "twice an edge of about 0.08 m";
      touching.insert(touch.particle), objects.insert(touch.object);
    }
    const Json& red = found["red"];
    for (std::size_t i = 0; i < red.size() / 3; ++i)
      ASSERT_EQ(red[3 * i + 1].get<double>() < 0.2, touching.count(int(i)) > 0) << "particle " << i << " is red";
    EXPECT_EQ(evaluated("malha.views[0].legend.textContent"),
              counted(std::int64_t(touching.size()), "particle") + (touching.size() == 1 ? " touches" : " touch"));
  }
  EXPECT_EQ(objects.size(), 2u) << "the scene should touch both objects";
  browser().press("1");
  browser().screenshot();
  EXPECT_FALSE(evaluated("malha.views[0].stage.marks.visible").get<bool>());
  expect_no_complaints();
}

TEST_F(PageMarks, ColourResidualsOnOneScaleForAllTimes) {
  NEEDS_BROWSER;
  Json scene = falling();
  scene["bodies"][0]["tear"] = {{"strain", 0.3}};
  scene["wind"] = {{"velocity", {0, 0, 60}}, {"drag", 0.5}};
  browser().open(page(scene));
  browser().press("0");
  browser().screenshot();
  ASSERT_EQ(browser().evaluate("malha.look"), "residual");
  Simulation simulation(parsed(scene), {.threads = 1});
  int torn = 0;
  const Json scale = evaluated("malha.views[0].stage.scales.residual");
  for (const int step : {0, 4, 12, 40}) {
    go(simulation, step);
    const std::vector<float> expected = Residuals(simulation.model())(simulation.positions());
    const std::vector<Json> found =
        awaited("return Array.from(await malha.views[0].frames.residuals(" + std::to_string(step) + "))");
    ASSERT_EQ(found.size(), expected.size());
    const float most = *std::max_element(expected.begin(), expected.end());
    for (std::size_t i = 0; i < expected.size(); ++i)
      ASSERT_NEAR(found[i].get<double>(), expected[i], most / 510 + 1e-7) << "step " << step << ", particle " << i;
    browser().evaluate("malha.seek(" + shown(simulation.time()) + ")");
    EXPECT_EQ(evaluated("malha.views[0].stage.scales.residual"), scale);
    torn = simulation.tears();
  }
  EXPECT_GT(torn, 0) << "the scene should tear";
  const std::string legend = evaluated("malha.views[0].legend.textContent");
  EXPECT_EQ(legend.find("residual: 0 to "), 0u) << legend;
  EXPECT_NE(legend.find(" m and more; here at most "), std::string::npos) << legend;
  expect_no_complaints();
}

TEST_F(PageMarks, LinesOfABatchHaveOneColour) {
  NEEDS_BROWSER;
  const Json scene = falling();
  browser().open(page(scene));
  browser().press("8");
  browser().screenshot();
  ASSERT_EQ(browser().evaluate("malha.look"), "batch");
  const Simulation simulation(parsed(scene), {.threads = 1});
  const Structure layout = structure(simulation.model());
  std::multiset<std::array<int, 3>> expected, found;
  for (std::size_t l = 0; l < layout.lines.size(); ++l) {
    const auto [low, high] = std::minmax(layout.lines[l][0], layout.lines[l][1]);
    expected.insert({low, high, layout.batch[l]});
  }
  ASSERT_GT(expected.size(), 400u);
  const Json all = awaited(
      "const stage = malha.views[0].stage, colours = stage.marks.geometry.attributes.color.array;"
      "return {ends: Array.from(stage.data.ends), numbers: Array.from(stage.data.numbers),"
      "        colours: Array.from(colours)}");
  std::map<int, Json> colour_of;
  std::set<std::string> colours;
  for (std::size_t l = 0; l < all["numbers"].size(); ++l) {
    const std::size_t number = all["numbers"][l];
    found.insert({all["ends"][2 * l].get<int>(), all["ends"][2 * l + 1].get<int>(), int(number)});
    for (const std::size_t end : {2 * l, 2 * l + 1}) {
      const Json colour{all["colours"][3 * end], all["colours"][3 * end + 1], all["colours"][3 * end + 2]};
      ASSERT_EQ(colour, colour_of.emplace(int(number), colour).first->second);
      colours.insert(colour.dump());
    }
  }
  EXPECT_EQ(found, expected);
  EXPECT_EQ(colours.size(), colour_of.size()) << "batches differ in colour";
  EXPECT_EQ(evaluated("malha.views[0].legend.textContent"),
            "at most " + counted(layout.batches, "batch", "batches") + " a patch");
  expect_no_complaints();
}

TEST_F(PageMarks, ShowForcesOnPins) {
  NEEDS_BROWSER;
  Json scene = swinging_sheet(false);
  scene["bodies"][0]["pins"] = {{{"particles", {0, 4, 6}}}};
  // substeps that resolve the compliance
  scene["bodies"][0]["constraints"][0]["compliance"] = 0.01, scene["solver"]["substeps"] = 30;
  browser().open(page(scene));
  Simulation simulation(parsed(scene), {.threads = 1});
  const PinForces forces(simulation.model());
  std::vector<double> lengths;  // m/N, of lines
  for (const int step : {5, 40}) {
    go(simulation, step);
    browser().evaluate("malha.seek(" + shown(simulation.time()) + ")");
    browser().evaluate("malha.setLook('force')");
    const Json found = awaited(
        "const {marks, data} = malha.views[0].stage;"
        "return {particles: Array.from(data.particles), newtons: Array.from(data.newtons),"
        "        ends: Array.from(marks.geometry.attributes.position.array)}");
    const std::vector<PinForce> expected = forces(simulation.positions(), simulation.time());
    ASSERT_EQ(expected.size(), 3u);
    double largest = 0;
    for (const PinForce& one : expected) largest = std::max(largest, norm(one.force));
    for (std::size_t f = 0; f < 3; ++f) {
      ASSERT_EQ(found["particles"][f], expected[f].particle);
      Vec3 line{};
      for (std::size_t k = 0; k < 3; ++k) {
        // Forces are rounded to 65535 steps over the box of all forces, and to single precision.
        EXPECT_NEAR(found["newtons"][3 * f + k].get<double>(), expected[f].force[k], 1e-4 * largest);
        line[k] = found["ends"][6 * f + 3 + k].get<double>() - found["ends"][6 * f + k].get<double>();
      }
      EXPECT_GT(dot(Json{line[0], line[1], line[2]}, expected[f].force), 0.999 * norm(line) * norm(expected[f].force));
      lengths.push_back(norm(line) / norm(expected[f].force));
    }
    const std::string legend = evaluated("malha.views[0].legend.textContent");
    EXPECT_EQ(legend.find("at most "), 0u) << legend;
    const std::string left = ", without " + std::to_string(forces.left_out()) + " constraints that are too stiff";
    EXPECT_NE(legend.find(left), std::string::npos) << "bending has no compliance: " << legend;
  }
  for (const double one : lengths) EXPECT_NEAR(one, lengths[0], 1e-3 * lengths[0]) << "one scale for all times";
  EXPECT_GT(lengths[0], 1e-3);
  expect_no_complaints();
}

TEST_F(PageMarks, OfWhatARunLacksAreNotOffered) {
  NEEDS_BROWSER;
  // With two runs beside each other, a field that one of them has is offered, and the other one shows that it has none.
  const auto touching = page(falling(), "falls");
  const auto free = page(swinging_sheet(false), "swings");
  browser().open(free);
  const std::string looks = "Array.from(document.getElementById('look').options, (option) => option.value)";
  EXPECT_EQ(evaluated(looks),
            (Json{"shaded", "wire", "particles", "strain", "speed", "patch", "colour", "batch", "residual"}));
  browser().press("9");
  browser().screenshot();
  EXPECT_EQ(browser().evaluate("malha.look"), "shaded");
  const auto both = folder_ / "both.html";
  write_comparison(touching, free, both);
  open_still(both);
  browser().press("9");
  browser().screenshot();
  EXPECT_EQ(browser().evaluate("malha.look"), "contact");
  EXPECT_EQ(evaluated("malha.views[1].legend.textContent"), "nothing to touch");
  EXPECT_NE(evaluated("malha.views[0].legend.textContent"), "nothing to touch");
  expect_no_complaints();
}

}  // namespace
}  // namespace malha
