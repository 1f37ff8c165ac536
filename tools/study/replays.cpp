// SPDX-License-Identifier: Apache-2.0
#include "tools/study/replays.h"

#include "host/output/page.h"
#include "host/run/run.h"
#include "tools/study/interrupted.h"

namespace malha::study {

std::string replay_file(const Study& study, const Replay& replay) { return study.name + "_" + replay.name + ".html"; }

namespace {

/// Runs the scene and writes its page into the folder.
void replay(Scene scene, const std::filesystem::path& folder, const std::atomic<bool>& stop) {
  scene.outputs = {}, scene.expect = {};
  scene.outputs.page = PageSpec{4};  // MB: two small runs fit on a page that opens at once
  RunOptions options;
  options.out = folder.string();
  try {
    run(
        scene, {.threads = 1}, options, [](const Progress&) {}, stop);
  } catch (const Diverged&) {  // the page shows it
  }
  if (stop) throw Interrupted{};
}

}  // namespace

void write_replays(const std::filesystem::path& folder, const Study& study, const Findings& findings,
                   const std::function<void(const std::string&)>& show, const std::atomic<bool>& stop) {
  const auto runs = folder / (study.name + "_replays");
  for (const Section& section : findings.sections)
    for (const Replay& one : section.replays) {
      show("replay " + one.name);
      // A page names each side by its folder.
      const auto left = runs / one.left.name, right = runs / one.right.name;
      replay(one.left, left, stop), replay(one.right, right, stop);
      write_comparison(left, right, folder / replay_file(study, one));
    }
  std::filesystem::remove_all(runs);
}

}  // namespace malha::study
