// SPDX-License-Identifier: Apache-2.0
// Helpers for tests of pages: runs that write one, its contents, and a browser.
#pragma once
#include <gtest/gtest.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/base/file.h"
#include "tests/output/browser.h"
#include "tests/run_scenes.h"
#include "tests/support.h"

namespace malha {

/// The data of the run in a page, or of each of two.
inline std::vector<Json> runs_in(const std::filesystem::path& path) {
  const std::string page = read_whole(path), begin = "class=\"run\">";
  std::vector<Json> runs;
  for (std::size_t at = page.find(begin); at != std::string::npos; at = page.find(begin, at + 1)) {
    const std::size_t from = at + begin.size();
    runs.push_back(Json::parse(page.substr(from, page.find("</script>", from) - from)));
  }
  return runs;
}

class PageOfARun : public testing::Test {
 protected:
  /// The page of the swinging sheet of 40 steps, in a folder.
  std::filesystem::path page(Json scene, const std::string& name = "run", std::optional<std::int64_t> steps = {},
                             bool resume = false) {
    if (!scene["outputs"].contains("page")) scene["outputs"]["page"] = Json::object();
    run_quietly(scene, {.out = (folder_ / name).string(), .steps = steps, .resume = resume});
    return folder_ / name / "page.html";
  }
  Browser& browser() {
    static Browser one(1000, 600);
    return one;
  }
  /// The page of two runs, paused at their start.
  void open_still(const std::filesystem::path& path) {
    browser().open(path);
    browser().evaluate("malha.pause(), malha.seek(malha.start)");
  }
  Json evaluated(const std::string& expression) {
    return Json::parse(browser().evaluate("JSON.stringify(" + expression + ")").get<std::string>());
  }
  void expect_no_complaints() { EXPECT_TRUE(browser().complaints().empty()) << browser().complaints()[0]; }
  TemporaryFolder folder_;
};

#define NEEDS_BROWSER \
  if (Browser::command().empty()) GTEST_SKIP() << "no chromium: tools/setup browser"

}  // namespace malha
