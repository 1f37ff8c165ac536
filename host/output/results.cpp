// SPDX-License-Identifier: Apache-2.0
#include "host/output/results.h"

#include <regex>
#include <string>
#include <vector>

namespace malha {

namespace fs = std::filesystem;

namespace {

/// Returns whether a file is a frame or a picture, or the temporary file of one that a killed run left.
bool is_ours(const fs::path& path) {
  static const std::regex ours(
      "(frames\\.pvd|points_.*\\.pc2|rest\\.obj|materials\\.mtl|run\\.(glb|usda)(\\.part)?|picture_[0-9]+\\.png|"
      "frame_[0-9]+\\.(vtp|ply|obj))(\\.tmp)?");
  return std::regex_match(path.filename().string(), ours);
}

}  // namespace

Results::Results(const fs::path& folder_path)
    : folder(folder_path),
      report(folder / "report.json"),
      checkpoint(folder / "checkpoint.malha"),
      picture(folder / "picture.png"),
      storyboard(folder / "storyboard.png"),
      page(folder / "page.html"),
      frames(folder / "frames"),
      pictures(folder / "pictures") {}

void Results::remove() const {
  for (const fs::path& path : {report, checkpoint, picture, storyboard, page}) {
    fs::remove(path);
    fs::remove(path.string() + ".tmp");
  }
  for (const fs::path& series : {frames, pictures}) {
    if (!fs::is_directory(series)) continue;
    std::vector<fs::path> ours;
    for (const auto& entry : fs::directory_iterator(series))
      if (is_ours(entry.path())) ours.push_back(entry.path());
    for (const fs::path& path : ours) fs::remove(path);
    if (fs::is_empty(series)) fs::remove(series);
  }
}

}  // namespace malha
