// SPDX-License-Identifier: Apache-2.0
// Replays of the studies: pages with two runs side by side.

#include <atomic>
#include <set>

#include "tests/output/page_of_a_run.h"
#include "tests/tools/study/quick_study.h"
#include "tools/study/accuracy/accuracy.h"
#include "tools/study/interrupted.h"
#include "tools/study/page.h"
#include "tools/study/replays.h"
#include "tools/study/results.h"

namespace malha::study {
namespace {

/// The replays of a quick study, in a temporary folder.
class StudyAccuracyReplays : public testing::Test {
 protected:
  const Study& study_ = studies()[0];
  const Findings& findings_ = quick_findings<run_accuracy>();
  std::atomic<bool> stop_ = false;
  TemporaryFolder folder_;

  void write() {
    write_replays(
        folder_ / "", study_, findings_, [](const std::string&) {}, stop_);
  }
  std::vector<Replay> all() const {
    std::vector<Replay> replays;
    for (const Section& section : findings_.sections)
      replays.insert(replays.end(), section.replays.begin(), section.replays.end());
    return replays;
  }
};

TEST_F(StudyAccuracyReplays, AreTheOnlyFilesAndLinkedByThePage) {
  ASSERT_EQ(all().size(), 3u);
  write();
  std::set<std::string> expected, found;
  for (const Replay& one : all()) expected.insert(replay_file(study_, one));
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / ""))
    found.insert(entry.path().filename().string());
  EXPECT_EQ(found, expected);

  const Json build{{"malha_version", ""}, {"compiler", ""}, {"flags", ""},
                   {"instructions", ""},  {"cpu", ""},      {"cores", 1}};
  const Json json = to_json(study_, findings_, true, "malha study accuracy --quick", std::vector<Json>(1, build));
  folder_.write("accuracy.json", json.dump());
  const std::string index = page(folder_ / "");
  for (const Replay& one : all()) EXPECT_TRUE(has(index, "<a href=\"" + replay_file(study_, one) + "\">")) << one.name;
  std::filesystem::remove(folder_ / replay_file(study_, all()[0]));
  EXPECT_FALSE(has(page(folder_ / ""), replay_file(study_, all()[0]))) << "no link to a missing file";
}

TEST_F(StudyAccuracyReplays, ShowFewSubstepsBesideTheReferenceAndADivergingRun) {
  write();
  const std::vector<Json> few = runs_in(folder_ / "accuracy_sheet7_1.html");
  ASSERT_EQ(few.size(), 2u);
  EXPECT_EQ(few[0]["report"]["scene"], "1 substep");
  EXPECT_EQ(few[1]["report"]["scene"], "1024 substeps");
  const std::vector<Json> shells = runs_in(folder_ / "accuracy_shell_correctors.html");
  ASSERT_EQ(shells.size(), 2u);
  EXPECT_EQ(shells[0]["report"]["status"], "diverged");
  EXPECT_EQ(shells[1]["report"]["status"], "finished");
}

TEST_F(StudyAccuracyReplays, EndWhenTheyAreInterrupted) {
  stop_ = true;
  EXPECT_THROW(write(), Interrupted);
}

TEST_F(StudyAccuracyReplays, OfADivergingRunShowTheBodyInItsInitialSize) {
  NEEDS_BROWSER;
  write();
  Browser browser(1000, 600);
  browser.open(folder_ / "accuracy_shell_correctors.html");
  const double size = browser.evaluate("malha.views[0].stage.box().getSize(new THREE.Vector3()).length()");
  EXPECT_LT(size, 20) << "m; the shell is 1 m wide, and its last frame 1e28 m";
  EXPECT_GT(size, 1);
}

}  // namespace
}  // namespace malha::study
