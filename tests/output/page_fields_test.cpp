// SPDX-License-Identifier: Apache-2.0
// Fields in a page of a run: patches and their colours, speeds, numbers with units, and names.
#include <algorithm>
#include <map>
#include <set>

#include "host/fields/fields.h"
#include "host/output/page.h"
#include "host/solver/solver.h"
#include "malha/text.h"
#include "tests/output/page_of_a_run.h"

namespace malha {
namespace {

class PageFields : public PageOfARun {
 protected:
  std::string text_of_panel() { return browser().evaluate("document.getElementById('panel').innerText"); }
};

/// A sheet with several patches in two colours.
Json many_patches() {
  Json scene = swinging_sheet(false);
  scene["bodies"][0]["shape"]["grid"]["cells"] = {90, 90};
  scene["duration"] = 0.06;
  return scene;
}

TEST_F(PageFields, ShowAsManyHuesAsThereArePatchesAndColours) {
  NEEDS_BROWSER;
  const Json scene = many_patches();
  browser().open(page(scene));
  const Simulation simulation(parsed(scene), {.threads = 1});
  const Structure layout = structure(simulation.model());
  ASSERT_GT(layout.patches, 4);
  ASSERT_EQ(layout.colours, 2);
  for (const char* look : {"patch", "colour"}) {
    browser().press(look == std::string("patch") ? "6" : "7");
    browser().screenshot();
    EXPECT_EQ(browser().evaluate("malha.look"), look);
    const Json colours = evaluated("Array.from(malha.views[0].stage.colours.array)");
    const std::vector<int>& number = look == std::string("patch") ? layout.patch : layout.colour;
    ASSERT_EQ(colours.size(), 3 * number.size());
    std::map<int, Json> colour_of;
    std::set<std::string> all;
    for (std::size_t i = 0; i < number.size(); ++i) {
      const Json colour{colours[3 * i], colours[3 * i + 1], colours[3 * i + 2]};
      const Json& first = colour_of.emplace(number[i], colour).first->second;
      ASSERT_EQ(colour, first) << "particle " << i << " of " << look << " " << number[i];
      all.insert(colour.dump());
    }
    const int expected = look == std::string("patch") ? layout.patches : layout.colours;
    EXPECT_EQ(all.size(), static_cast<std::size_t>(expected)) << look;
    EXPECT_EQ(evaluated("malha.views[0].legend.textContent"),
              counted(expected, look, look == std::string("patch") ? "patches" : "colours"));
  }
  // On the screen, too, patches of colour 0 have another hue than those of colour 1, whatever the light.
  const Image picture = browser().screenshot();
  const auto hue = [&](int i) {
    const Json at = evaluated("malha.pixelOf(0, " + std::to_string(i) + ")");
    const std::size_t px = std::size_t(at[0].get<double>()), py = std::size_t(at[1].get<double>());
    const unsigned char* const rgb = &picture.pixels[3 * (py * std::size_t(picture.width) + px)];
    return int(std::max_element(rgb, rgb + 3) - rgb) * 3 + int(std::min_element(rgb, rgb + 3) - rgb);
  };
  const auto in_colour = [&](int colour) {  // a particle in the middle of a patch
    std::vector<int> of;
    for (int i = 0; i < 91 * 91; ++i)
      if (layout.colour[i] == colour && layout.colour[std::max(i - 1, 0)] == colour && i % 91 > 5 && i % 91 < 85)
        of.push_back(i);
    return of[of.size() / 2];
  };
  EXPECT_NE(hue(in_colour(0)), hue(in_colour(1)));
  expect_no_complaints();
}

TEST_F(PageFields, OfPatchesAreNotOfferedWhereTheFilterDoesAll) {
  NEEDS_BROWSER;
  Json scene = swinging_sheet(false);
  scene["solver"]["type"] = "desbrun";
  scene["solver"].erase("iterations");
  const auto path = page(scene);
  EXPECT_FALSE(runs_in(path)[0]["meshes"][0].contains("patch"));
  browser().open(path);
  EXPECT_EQ(browser().evaluate("document.getElementById('look').options.length"), 7) << "with residuals and forces";
  browser().press("6");
  browser().screenshot();
  EXPECT_EQ(browser().evaluate("malha.look"), "shaded");
  expect_no_complaints();
}

TEST_F(PageFields, OfSpeedAreRightInTheFirstFrameAndAfterTears) {
  NEEDS_BROWSER;
  // All particles move alike, also where they tear from each other: the speed of each is 3 m/s.
  Json scene = swinging_sheet(false);
  scene.erase("gravity"), scene.erase("wind"), scene["bodies"][0].erase("pins"), scene["bodies"][0].erase("damping");
  scene["bodies"][0]["velocity"] = {0, 3, 0};
  scene["duration"] = 0.1;
  const auto still = page(scene);
  browser().open(still);
  browser().evaluate("malha.setLook('speed')");
  const std::string speeds =
      "(async () => { const v = malha.views[0], k = v.stage.shown, b = v.frames.beside(k);"
      "const mesh = await v.frames.mesh(k), last = renumbered(await v.frames.positions(b), await v.frames.mesh(b), "
      "mesh);"
      "return JSON.stringify(Array.from(speeds(mesh, await v.frames.positions(k), last,"
      "Math.abs(v.frames.all[k].time - v.frames.all[b].time)))); })()";
  const auto now = [&] { return Json::parse(browser().evaluate(speeds).get<std::string>()); };
  for (const Json& speed : now()) EXPECT_NEAR(speed.get<double>(), 3, 0.01) << "places are rounded";
  const Json first = evaluated("Array.from(malha.views[0].stage.colours.array)");
  browser().evaluate("malha.seek(0.04)");
  const Json later = evaluated("Array.from(malha.views[0].stage.colours.array)");
  for (std::size_t i = 0; i < later.size(); ++i)
    EXPECT_NEAR(first[i].get<double>(), later[i].get<double>(), 0.05) << "colours of 3 m/s and 3 m/s";

  // A sheet that the wind tears, and after it a rope, whose numbers change with the tears.
  Json torn = swinging_sheet(false);
  torn["bodies"][0]["tear"] = {{"strain", 0.2}};
  torn["wind"] = {{"velocity", {0, 0, 60}}, {"drag", 0.5}};
  torn["bodies"].push_back({{"name", "rope"},
                            {"shape", {{"chain", {{"from", {2, 0, 0}}, {"to", {3, 0, 0}}, {"segments", 5}}}}},
                            {"mass", 0.1},
                            {"constraints", {{{"type", "distance"}, {"stiffness", 1}}}}});
  Simulation simulation(parsed(torn), {.threads = 1});
  std::vector<std::vector<Vec3>> places{simulation.positions()};
  for (int step = 0; step < 40; ++step) simulation.step(), places.push_back(simulation.positions());
  const auto path = page(torn, "torn");
  const Json run = runs_in(path)[0];
  ASSERT_EQ(run["frames"].size(), places.size());
  browser().open(path);
  browser().evaluate("malha.setLook('speed')");
  int tears = 0;
  for (std::size_t k = 1; k < places.size(); ++k) {
    const Json& frame = run["frames"][k];
    if (frame["mesh"] == run["frames"][k - 1]["mesh"]) continue;
    ++tears;
    browser().evaluate("malha.seek(" + frame["time"].dump() + ")");
    const Json all = now();
    const std::size_t b = browser().evaluate("malha.views[0].frames.beside(" + std::to_string(k) + ")");
    const std::vector<Vec3>&here = places[k], &there = places[b];
    ASSERT_EQ(all.size(), here.size());
    const auto expect_speed = [&](std::size_t i, std::size_t j) {  // the same particle in both runs
      const double moved = std::hypot(here[i][0] - there[j][0], here[i][1] - there[j][1], here[i][2] - there[j][2]);
      // Both positions are rounded, in all three coordinates; a page reads them in float.
      const double rounded = 2 * std::sqrt(3.0) * run["rounding"].get<double>() / 0.02;
      EXPECT_NEAR(all[i].get<double>(), moved / 0.02, rounded + 1e-3) << "particle " << i << " of frame " << k;
    };
    for (std::size_t i = 0; i < 49; ++i) expect_speed(i, i);  // particles of the sheet before it tore
    for (std::size_t i = 1; i <= 6; ++i) expect_speed(here.size() - i, there.size() - i);
    for (std::size_t i = 1; i < all.size(); ++i) {  // 0 is pinned
      ASSERT_TRUE(all[i].is_number());
      EXPECT_LT(all[i].get<double>(), 1.5 * frame["measures"]["speed_max"].get<double>());
      EXPECT_GT(all[i].get<double>(), 0) << "particle " << i << ", also where it is torn off";
    }
  }
  EXPECT_GT(tears, 1);
  expect_no_complaints();
}

TEST_F(PageFields, SaysUnitsTimesNamesAndWhereAResumedRunBegan) {
  NEEDS_BROWSER;
  Json scene = swinging_sheet(true);
  scene["bodies"].push_back({{"name", "rope"},
                             {"shape", {{"chain", {{"from", {2, 0, 0}}, {"to", {3, 0, 0}}, {"segments", 5}}}}},
                             {"mass", 0.1},
                             {"constraints", {{{"type", "distance"}, {"stiffness", 1}}}}});
  browser().open(page(scene, "run", 11));
  EXPECT_FALSE(has(text_of_panel(), "resumed"));
  EXPECT_EQ(evaluated("[...document.querySelectorAll('.bodies span')].map((one) => one.textContent)"),
            Json({"sheet", "rope"}));
  EXPECT_EQ(evaluated("new Set([...document.querySelectorAll('.bodies i')].map((one) => one.style.background)).size"),
            2);
  browser().open(page(scene, "run", {}, true));
  EXPECT_TRUE(has(text_of_panel(), "resumed at step 11")) << text_of_panel();
  const Json rows = evaluated(
      "Object.fromEntries([...document.querySelectorAll('#panel tr')].map((row) => [row.cells[0].textContent, "
      "row.cells[2].textContent]))");
  EXPECT_EQ(rows["kinetic"], "J");
  EXPECT_EQ(rows["speed max"], "m/s");
  EXPECT_EQ(rows["angular momentum"], "kg m²/s");
  EXPECT_EQ(rows["contacts"], "") << "a number";
  const Json labels = evaluated(
      "[...document.querySelector('#panel svg').querySelectorAll('text')].map((one) => "
      "one.textContent)");
  EXPECT_NE(std::find(labels.begin(), labels.end(), "0.22 s"), labels.end()) << labels;
  EXPECT_NE(std::find(labels.begin(), labels.end(), "0.8 s"), labels.end()) << labels;
  expect_no_complaints();
}

TEST_F(PageFields, TellsRunsApartByTheirFolders) {
  NEEDS_BROWSER;
  Json scene = swinging_sheet(false);
  std::filesystem::create_directories(folder_ / "soft" / "it"), std::filesystem::create_directories(folder_ / "firm");
  scene["duration"] = 0.04;
  page(scene, "soft/it"), page(scene, "firm/it"), page(scene, "a<b");
  const auto names = [&](const char* one, const char* other) {
    write_comparison(folder_ / one, folder_ / other, folder_ / "both.html");
    open_still(folder_ / "both.html");
    return evaluated("[...document.querySelectorAll('.view .name')].map((one) => one.textContent.split(',')[0])");
  };
  EXPECT_EQ(names("soft/it", "firm/it/page.html"), Json({"soft/it", "firm/it"}));
  EXPECT_EQ(names("soft/it", "a<b"), Json({"it", "a<b"}));
  expect_no_complaints();
}

// Both move uniformly, so that positions between their frames are known.
TEST_F(PageFields, OfTwoRunsAreComparedBetweenFramesToo) {
  NEEDS_BROWSER;
  const auto contact_free_steps = [&](double dt, const char* name) {
    Json scene = swinging_sheet(false);
    scene.erase("wind"), scene["bodies"][0].erase("pins"), scene["gravity"] = {0, 0, 0};
    scene["bodies"][0]["velocity"] = {name == std::string("fast") ? 3 : 1, 0, 0};
    scene["solver"]["dt"] = dt, scene["duration"] = 0.6;
    return page(scene, name).parent_path();
  };
  write_comparison(contact_free_steps(0.02, "slow"), contact_free_steps(0.03, "fast"), folder_ / "both.html");
  open_still(folder_ / "both.html");
  for (const double time : {0.06, 0.02, 0.03, 0.25, 0.5}) {
    browser().evaluate("malha.seek(" + std::to_string(time) + ")");
    const std::string said = browser().evaluate("document.getElementById('apart').textContent");
    EXPECT_NEAR(std::stod(said), 2 * time, 0.006 * 2 * time + 5e-5) << said << " at " << time << ": three digits";
  }
  expect_no_complaints();
}

TEST_F(PageFields, TheSummarySaysHowManyFramesAreKept) {
  Json scene = swinging_sheet(false);
  scene["outputs"]["page"] = Json::object();
  const RunResult all = run_quietly(scene, {.out = (folder_ / "run").string()});
  EXPECT_TRUE(has(all.summary, "replay      41 frames, one a step\n")) << all.summary;
  scene["solver"]["dt"] = 0.005;
  const RunResult some = run_quietly(scene, {.out = (folder_ / "run").string()});
  const Json run = runs_in(folder_ / "run" / "page.html")[0];
  EXPECT_TRUE(has(some.summary, "replay      " + std::to_string(run["frames"].size()) + " frames, one every 3 steps\n"))
      << some.summary;
  scene["outputs"].erase("page");
  EXPECT_FALSE(has(run_quietly(scene, {.out = (folder_ / "run").string()}).summary, "replay"));
}

}  // namespace
}  // namespace malha
