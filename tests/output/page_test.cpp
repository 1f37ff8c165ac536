// SPDX-License-Identifier: Apache-2.0
// A run as a page: its contents, and what a browser shows of it. The second half needs chromium.
#include "host/output/page.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <limits>

#include "host/base/file.h"
#include "host/output/page_pack.h"
#include "host/render/picture.h"
#include "tests/numbers.h"
#include "tests/output/page_of_a_run.h"
#include "tests/refusal.h"

namespace malha {
namespace {

std::string inflated(const std::string& bytes, std::size_t size) {
  std::string all(size, '\0');
  uLongf length = size;
  EXPECT_EQ(uncompress(reinterpret_cast<Bytef*>(all.data()), &length, reinterpret_cast<const Bytef*>(bytes.data()),
                       static_cast<uLong>(bytes.size())),
            Z_OK);
  EXPECT_EQ(length, size);
  return all;
}

/// Decodes as the page's script does: planes of bytes of differences.
std::vector<std::uint32_t> unpacked(const std::string& data, std::size_t count, std::size_t stride, std::size_t bytes) {
  const std::string planes = inflated(data, count * bytes);
  std::vector<std::uint32_t> numbers(count);
  for (std::size_t i = 0; i < count; ++i) {
    std::uint32_t step = 0;
    for (std::size_t b = 0; b < bytes; ++b)
      step |= static_cast<std::uint32_t>(static_cast<unsigned char>(planes[b * count + i])) << (8 * b);
    numbers[i] = (step + (i < stride ? 0 : numbers[i - stride])) & (0xffffffffu >> (32 - 8 * bytes));
  }
  return numbers;
}

TEST(PackedPoints, ComeBackAsNearAsTheySay) {
  Random random(3);
  for (const double far : {0.0, 1e3, -1e6}) {
    std::vector<Vec3> points;
    for (int i = 0; i < 1000; ++i) points.push_back({far + random(-1, 1), random(0, 5), 2.5});
    const PackedPoints all = packed(points);
    const std::vector<std::uint32_t> steps = unpacked(all.data, 3 * points.size(), 3, 2);
    EXPECT_NEAR(all.rounding(), 5.0 / 65535 / 2, 1e-6) << "the longest side is 5 m";
    for (std::size_t i = 0; i < points.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k)
        ASSERT_NEAR(all.low[k] + all.side[k] * steps[3 * i + k] / 65535, points[i][k], all.rounding() + 1e-9);
  }
}

TEST(PackedNumbers, ComeBackAsTheyWere) {
  Random random(4);
  std::vector<std::uint32_t> numbers{0, 0xffffffffu, 1, 0x80000000u};
  for (int i = 0; i < 1000; ++i) numbers.push_back(static_cast<std::uint32_t>(random.below(1 << 30)) * 4 + 3);
  EXPECT_EQ(unpacked(packed(numbers, 4, 4), numbers.size(), 4, 4), numbers);
  EXPECT_TRUE(unpacked(packed(std::vector<std::uint32_t>{}, 1, 4), 0, 1, 4).empty());
}

TEST(PackedValues, ComeBackAsNearAsAStepOfTheLargest) {
  Random random(5);
  std::vector<float> values{0, std::numeric_limits<float>::infinity(), 0};
  for (int i = 0; i < 1000; ++i) values.push_back(static_cast<float>(random(0, 3)));
  const PackedValues huge = packed(values);
  EXPECT_EQ(huge.most, std::numeric_limits<float>::max()) << "what is infinite is no number of JSON";
  EXPECT_EQ(unpacked(huge.data, values.size(), values.size(), 1)[1], 255u);
  values.erase(values.begin() + 1);
  const PackedValues all = packed(values);
  const std::vector<std::uint32_t> steps = unpacked(all.data, values.size(), values.size(), 1);
  for (std::size_t i = 0; i < values.size(); ++i)
    ASSERT_NEAR(all.most / 255 * steps[i], values[i], all.most / 510 + 1e-6);
  EXPECT_EQ(packed(std::vector<float>{0, 0}).most, 0);
  EXPECT_TRUE(packed(std::vector<float>{}).data == packed(std::vector<std::uint32_t>{}, 1, 1));
}

TEST(PackedContacts, KeepTheSideThatAParticleIsOn) {
  const std::vector<ContactPoint> touches{
      {.particle = 7, .object = 0, .at = {0, 0, 0}, .normal = {0, 1, 0}, .distance = 0.02},
      {.particle = 3, .object = 1, .at = {0, 0, 0}, .normal = {-0.6, 0, 0.8}, .distance = -0.01}};
  const PackedContacts all = packed(touches);
  EXPECT_EQ(all.count, 2u);
  EXPECT_EQ(all.far, 0.02);
  EXPECT_EQ(unpacked(all.particles, 2, 1, 4), (std::vector<std::uint32_t>{7, 3}));
  const std::vector<std::uint32_t> ways = unpacked(all.ways, 8, 4, 1);
  const double expected[] = {0, 1, 0, 1, -0.6, 0, 0.8, -0.5};
  for (std::size_t k = 0; k < 8; ++k) EXPECT_NEAR(ways[k] / 127.0 - 1, expected[k], 0.5 / 127) << k;
  EXPECT_EQ(packed(std::vector<ContactPoint>{}).far, 0) << "and nothing is divided by it";
}

TEST(Base64, IsThatOfTheStandard) {  // RFC 4648, section 10
  const std::pair<const char*, const char*> words[] = {{"", ""},
                                                       {"f", "Zg=="},
                                                       {"fo", "Zm8="},
                                                       {"foo", "Zm9v"},
                                                       {"foob", "Zm9vYg=="},
                                                       {"fooba", "Zm9vYmE="},
                                                       {"foobar", "Zm9vYmFy"}};
  for (const auto& [plain, coded] : words) EXPECT_EQ(base64(plain), coded);
}

TEST_F(PageOfARun, KeepsEveryFrameWithinItsSizeLimit) {
  const Json run = runs_in(page(swinging_sheet(true)))[0];
  ASSERT_EQ(run["frames"].size(), 41u);
  for (int k = 0; k <= 40; ++k) EXPECT_EQ(run["frames"][k]["step"], k);
  EXPECT_EQ(run["report"]["status"], "finished");
  EXPECT_EQ(run["report"]["input"]["scene"]["name"], "swinging sheet");
  EXPECT_EQ(run["frames"][0]["poses"].size(), 1u) << "the ball moves";
}

TEST_F(PageOfARun, NeedsNoNetwork) {
  const std::string text = read_whole(page(swinging_sheet(true)));
  for (const char* from : {"src=", "href=\"http", "@import", "fetch("}) {
    const std::size_t after_three = text.rfind("// Reads what host");
    EXPECT_EQ(text.find(from, after_three), std::string::npos) << from;
    EXPECT_EQ(text.substr(0, text.find("(function(")).find(from), std::string::npos) << from;
  }
}

/// A scene whose positions no coder compresses well.
Json rough_scene(int cells, double max_megabytes) {
  Json scene = swinging_sheet(false);
  scene["bodies"][0]["shape"]["grid"]["cells"] = {cells, cells};
  scene["wind"]["velocity"] = {3, 5, 9};
  scene["duration"] = 0.62;  // 31 steps
  scene["outputs"]["page"] = {{"max_megabytes", max_megabytes}};
  return scene;
}

TEST_F(PageOfARun, KeepsFewerFramesWhereAllExceedTheSizeLimit) {
  const auto path = page(rough_scene(120, 2));
  const Json run = runs_in(path)[0];
  EXPECT_LE(std::filesystem::file_size(path), 2'000'000u);
  EXPECT_GT(std::filesystem::file_size(path), 1'200'000u) << "half of the room for frames is used, or more";
  const std::int64_t every = run["every"];
  EXPECT_GT(every, 1);
  EXPECT_EQ(every & (every - 1), 0) << "a power of two";
  for (std::size_t k = 0; k + 1 < run["frames"].size(); ++k)
    EXPECT_EQ(run["frames"][k]["step"], static_cast<std::int64_t>(k) * every);
  EXPECT_EQ(run["frames"].back()["step"], 31) << "the end is always there";
}

TEST_F(PageOfARun, KeepsTheEndWhereNothingFitsTheSizeLimit) {
  const Json run = runs_in(page(rough_scene(400, 2), "run", 3))[0];
  ASSERT_GE(run["frames"].size(), 1u);
  EXPECT_EQ(run["frames"].back()["step"], 3);
}

TEST_F(PageOfARun, GoesWithTheNextRunThatHasNone) {
  const auto path = page(swinging_sheet(false));
  EXPECT_TRUE(std::filesystem::exists(path));
  run_quietly(swinging_sheet(false), {.out = (folder_ / "run").string()});
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST_F(PageOfARun, GoesWithAPartThatHasNone) {
  const auto path = page(swinging_sheet(false), "run", 11);
  run_quietly(swinging_sheet(false), {.out = (folder_ / "run").string(), .resume = true});
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST_F(PageOfARun, OfAResumedRunHasTheFramesOfThatRun) {
  Json scene = swinging_sheet(true);
  page(scene, "run", 11);
  const Json run = runs_in(page(scene, "run", {}, true))[0];
  EXPECT_EQ(run["frames"][0]["step"], 11);
  EXPECT_EQ(run["frames"].back()["step"], 40);
}

// 2^118 m a step: beyond the largest float of 2^128 at the 1024th.
TEST_F(PageOfARun, ThatDivergesEndsBeforeIt) {
  const Json here{{"lattice", {{"min", {0, 1, 0}}, {"max", {0, 1, 0}}, {"count", {1, 1, 1}}}}};
  const Json scene{{"name", "rush"},
                   {"solver", {{"type", "pbd"}, {"dt", 0x1p59}, {"substeps", 1}}},
                   {"bodies", {{{"name", "rushing"}, {"shape", here}, {"mass", 1}, {"velocity", {0x1p59, 0, 0}}}}},
                   {"duration", 0x1p59}};
  EXPECT_THROW(page(scene, "run", 2000), Diverged);
  const Json run = runs_in(folder_ / "run" / "page.html")[0];
  EXPECT_EQ(run["report"]["status"], "diverged");
  EXPECT_EQ(run["frames"].back()["step"], 1023);
  EXPECT_TRUE(has(run["warnings"].back(), "has no finite position")) << run["warnings"].back();
}

TEST_F(PageOfARun, ScriptsInNamesStayNames) {
  Json scene = swinging_sheet(false);
  scene["name"] = "<!--<script>alert(1)";
  const std::string text = read_whole(page(scene));
  EXPECT_EQ(text.find("<!--<script>"), std::string::npos);
  EXPECT_EQ(runs_in(folder_ / "run" / "page.html")[0]["report"]["scene"], scene["name"]);
}

TEST_F(PageOfARun, IsComparedOnlyWithAnother) {
  page(swinging_sheet(false), "a");
  std::filesystem::create_directory(folder_ / "empty");
  folder_.write("empty/page.html", "<html></html>");
  EXPECT_TRUE(has(refusal([&] { write_comparison(folder_ / "a", folder_ / "none", folder_ / "both.html"); }),
                  "allowed: a folder of results of malha run --page"));
  EXPECT_TRUE(
      has(refusal([&] { write_comparison(folder_ / "a", folder_ / "empty", folder_ / "both.html"); }), "no run in it"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "both.html"));
  page(swinging_sheet(false), "b");
  const std::string before = read_whole(folder_ / "a" / "page.html");
  EXPECT_TRUE(has(refusal([&] { write_comparison(folder_ / "a", folder_ / "b", folder_ / "b/../a/page.html"); }),
                  "found a page that is compared"));
  EXPECT_EQ(read_whole(folder_ / "a" / "page.html"), before);
  write_comparison(folder_ / "a", folder_ / "b" / "page.html", folder_ / "new" / "both.html");
  EXPECT_EQ(runs_in(folder_ / "new" / "both.html").size(), 2u);
}

/// The blue in which the first body is drawn, lit or in shadow.
bool is_cloth(const Image& image, double x, double y) {
  const int i = static_cast<int>(std::lround(x)), j = static_cast<int>(std::lround(y));
  if (i < 0 || j < 0 || i >= image.width || j >= image.height) return false;
  const unsigned char* const rgb = &image.pixels[3 * (std::size_t(j) * image.width + i)];
  return rgb[2] > rgb[0] + 40;
}

TEST_F(PageOfARun, ShowsTheClothWhereItIs) {
  NEEDS_BROWSER;
  Json scene = swinging_sheet(true);
  browser().open(page(scene));
  Simulation simulation(parsed(scene), {.threads = 1});
  for (const int step : {0, 17, 40}) {
    while (simulation.steps() < step) simulation.step();
    browser().evaluate("malha.seek(" + std::to_string(simulation.time()) + ")");
    const Json shown = Json::parse(
        browser()
            .evaluate("JSON.stringify([Array.from(malha.views[0].stage.x.array), malha.views[0].run.rounding])")
            .get<std::string>());
    const std::vector<Vec3> x = simulation.positions();
    ASSERT_EQ(shown[0].size(), 3 * x.size());
    for (std::size_t i = 0; i < x.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k)
        ASSERT_NEAR(shown[0][3 * i + k].get<double>(), x[i][k], shown[1].get<double>() + 1e-6);  // 1e-6: its floats
    // Where particles are, the picture shows cloth; beyond all of them, none.
    const Image picture = browser().screenshot();
    const Json pixels = Json::parse(
        browser().evaluate("JSON.stringify([...Array(49).keys()].map((i) => malha.pixelOf(0, i)))").get<std::string>());
    double low[2] = {1e9, 1e9}, high[2] = {-1e9, -1e9};
    int there = 0;
    for (const Json& pixel : pixels) {
      for (int k = 0; k < 2; ++k)
        low[k] = std::min(low[k], pixel[k].get<double>()), high[k] = std::max(high[k], pixel[k].get<double>());
      bool near = false;  // at a boundary the pixel itself may be beside the cloth
      for (int dx = -3; dx <= 3; ++dx)
        for (int dy = -3; dy <= 3; ++dy)
          near = near || is_cloth(picture, pixel[0].get<double>() + dx, pixel[1].get<double>() + dy);
      there += near;
    }
    EXPECT_GE(there, 40) << "some of 49 may lie behind the ball, at step " << step;
    const double canvas = browser().evaluate("malha.views[0].canvas.clientWidth");
    const double height = browser().evaluate("malha.views[0].canvas.clientHeight");
    for (double px = 0; px < canvas; px += 7)
      for (double py = 0; py < height; py += 7)
        if (px < low[0] - 4 || px > high[0] + 4 || py < low[1] - 4 || py > high[1] + 4) {
          ASSERT_FALSE(is_cloth(picture, px, py)) << px << " " << py << " at step " << step;
        }
  }
  EXPECT_TRUE(browser().complaints().empty()) << browser().complaints()[0];
}

TEST_F(PageOfARun, HasItsPrecisionFarFromTheOriginToo) {
  NEEDS_BROWSER;
  Json scene = swinging_sheet(false, "double");
  scene["bodies"][0]["transform"]["translate"] = {1e6, 5e5, -1e6};
  browser().open(page(scene));
  browser().evaluate("malha.seek(0.8)");
  const Json shown = Json::parse(
      browser().evaluate("JSON.stringify([Array.from(malha.views[0].stage.x.array), origin])").get<std::string>());
  Simulation simulation(parsed(scene), {.threads = 1});
  while (simulation.steps() < 40) simulation.step();
  const std::vector<Vec3> x = simulation.positions();
  for (std::size_t i = 0; i < x.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)  // a step of 2 m over 65535, and a float's digits of 2 m
      ASSERT_NEAR(shown[0][3 * i + k].get<double>() + shown[1][k].get<double>(), x[i][k], 2.0 / 65535);
  EXPECT_TRUE(browser().complaints().empty()) << browser().complaints()[0];
}

TEST_F(PageOfARun, AnswersToKeysMouseAndTouch) {
  NEEDS_BROWSER;
  browser().open(page(swinging_sheet(true)));
  const auto number = [&](const char* expression) { return browser().evaluate(expression).get<double>(); };
  const auto after_key = [&](const char* key, const char* expression) {
    browser().press(key);
    browser().screenshot();
    return browser().evaluate(expression);
  };
  EXPECT_EQ(after_key("End", "malha.views[0].stage.shown"), 40);
  EXPECT_EQ(after_key("ArrowLeft", "malha.views[0].stage.shown"), 39);
  EXPECT_EQ(after_key("Home", "malha.views[0].stage.shown"), 0);
  EXPECT_EQ(after_key("ArrowRight", "malha.views[0].stage.shown"), 1);
  const char* const looks[] = {"shaded", "wire", "particles", "strain", "speed"};
  for (int k = 0; k < 5; ++k) EXPECT_EQ(after_key(std::to_string(k + 1).c_str(), "malha.look"), looks[k]);
  for (const double slower : {0.5, 0.25, 0.1, 0.05}) EXPECT_EQ(after_key("-", "malha.speed"), slower);
  // The page plays so slowly that a busy machine does not reach the run's end between two keys.
  EXPECT_EQ(after_key(" ", "malha.playing"), true);
  EXPECT_EQ(after_key(" ", "malha.playing"), false);
  EXPECT_EQ(after_key("Home", "malha.time"), 0.0);
  browser().press(" ");
  browser().evaluate(  // waits for at most 20 s on a busy machine
      "new Promise((done) => { let waits = 0; const timer = setInterval(() => {"
      "  if (malha.time > 0.05 || ++waits > 1000) clearInterval(timer), done(); }, 20); })");
  EXPECT_GT(number("malha.time"), 0.05) << "it plays";
  browser().press(" ");
  for (const bool by_finger : {false, true}) {
    const double before = number("malha.camera.position.x");
    if (by_finger)
      browser().swipe(300, 250, 120, 10);
    else
      browser().drag(300, 250, 120, 10);
    browser().screenshot();
    EXPECT_GT(std::fabs(number("malha.camera.position.x") - before), 0.05) << by_finger;
  }
  EXPECT_TRUE(browser().complaints().empty()) << browser().complaints()[0];
}

TEST_F(PageOfARun, OfTwoSaysHowFarTheyAreApart) {
  NEEDS_BROWSER;
  Json few = swinging_sheet(false), many = few;
  many["solver"]["substeps"] = 12;
  page(few, "few"), page(many, "many");
  write_comparison(folder_ / "few", folder_ / "many", folder_ / "both.html");
  ASSERT_EQ(runs_in(folder_ / "both.html").size(), 2u);
  open_still(folder_ / "both.html");
  Simulation one(parsed(few), {.threads = 1}), other(parsed(many), {.threads = 1});
  while (one.steps() < 25) one.step(), other.step();
  double most = 0;
  const std::vector<Vec3> a = one.positions(), b = other.positions();
  for (std::size_t i = 0; i < a.size(); ++i)
    most = std::max(most, std::hypot(a[i][0] - b[i][0], a[i][1] - b[i][1], a[i][2] - b[i][2]));
  browser().evaluate("malha.seek(" + std::to_string(one.time()) + ")");
  const std::string said = browser().evaluate("document.getElementById('apart').textContent");
  // Three digits are printed; both positions are rounded by some 1e-5 m.
  EXPECT_NEAR(std::stod(said), most, 0.006 * most + 5e-5) << said;
  EXPECT_EQ(browser().evaluate("malha.views.length"), 2);
  EXPECT_TRUE(browser().complaints().empty()) << browser().complaints()[0];
}

TEST_F(PageOfARun, OfTwoPlaysAndShowsAllThatThePictureShows) {
  NEEDS_BROWSER;
  Json scene = swinging_sheet(false);
  const Simulation simulation(parsed(scene), {.threads = 1});
  std::vector<std::array<float, 3>> points;
  for (const Vec3& x : simulation.positions()) points.push_back({float(x[0]), float(x[1]), float(x[2])});
  const Camera camera = frame_all(points, 3);  // very wide, and filled by the sheet
  scene["outputs"]["pictures"] = {
      {"size", {96, 32}},
      {"camera", {{"eye", camera.eye}, {"target", camera.target}, {"fov_degrees", camera.fov_degrees}}}};
  page(scene, "a"), page(scene, "b");
  write_comparison(folder_ / "a", folder_ / "b", folder_ / "both.html");
  browser().open(folder_ / "both.html");
  EXPECT_EQ(browser().evaluate("malha.playing"), true);
  browser().evaluate(  // waits for at most 20 s on a busy machine
      "new Promise((done) => { let waits = 0; const timer = setInterval(() => {"
      "  if (malha.time > 0.05 || ++waits > 1000) clearInterval(timer), done(); }, 20); })");
  EXPECT_GT(browser().evaluate("malha.time").get<double>(), 0.05);
  browser().evaluate("malha.pause(), malha.seek(malha.start)");
  browser().screenshot();
  for (const char* view : {"0", "1"}) {
    const Json port = evaluated(std::string("malha.views[") + view + "].canvas.getBoundingClientRect()");
    EXPECT_LT(port["width"].get<double>(), 2 * port["height"].get<double>()) << "narrower than the picture";
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Json at = evaluated(std::string("malha.pixelOf(") + view + ", " + std::to_string(i) + ")");
      const double right = at[0].get<double>() - port["left"].get<double>(),
                   down = at[1].get<double>() - port["top"].get<double>();
      EXPECT_TRUE(right > 0 && right < port["width"].get<double>() && down > 0 && down < port["height"].get<double>())
          << "particle " << i << " of view " << view << " is at " << right << ", " << down;
    }
  }
  expect_no_complaints();
}

TEST_F(PageOfARun, ShowsBodiesThatTearAndBodiesOfLinesAndPoints) {
  NEEDS_BROWSER;
  Json scene = swinging_sheet(false);
  scene["bodies"][0]["tear"] = {{"strain", 0.2}};
  scene["wind"] = {{"velocity", {0, 0, 60}}, {"drag", 0.5}};
  Json rope{{"name", "rope"},
            {"shape", {{"chain", {{"from", {0, 0, 0}}, {"to", {1, 0, 0}}, {"segments", 5}}}}},
            {"mass", 0.1},
            {"transform", {{"translate", {2, 0, 0}}}},
            {"constraints", {{{"type", "distance"}, {"stiffness", 1}}}}};
  scene["bodies"].push_back(rope);
  const auto path = page(scene);
  const Json run = runs_in(path)[0];
  EXPECT_GT(run["meshes"].size(), 1u) << "it tears";
  browser().open(path);
  for (const char* look : {"shaded", "wire", "particles", "strain", "speed"})
    for (const char* time : {"0", "0.3", "0.8"}) {
      browser().evaluate("malha.setLook('" + std::string(look) + "')");
      browser().evaluate("malha.seek(" + std::string(time) + ")");
      browser().screenshot();
    }
  EXPECT_EQ(browser().evaluate("malha.views[0].stage.x.array.length").get<std::size_t>(),
            3 * run["meshes"].back()["count"].get<std::size_t>());
  EXPECT_TRUE(browser().complaints().empty()) << browser().complaints()[0];
}

}  // namespace
}  // namespace malha
