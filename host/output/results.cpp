// SPDX-License-Identifier: Apache-2.0
#include "host/output/results.h"

#include <string>
#include <vector>

namespace malha {

namespace fs = std::filesystem;

namespace {

/// Returns whether a file is a frame or a picture, or the temporary file of one that a killed run left.
bool is_ours(const fs::path& path) {
  std::string name = path.filename().string();
  if (name.ends_with(".tmp")) name.resize(name.size() - 4);
  for (const char* one : {"frames.pvd", "points.pc2", "rest.obj", "run.glb", "run.glb.part"})
    if (name == one) return true;
  const std::size_t dot = name.find('.');
  const std::size_t number = name.find_first_of("0123456789");
  if (dot == std::string::npos || number >= dot || name.find_first_not_of("0123456789", number) != dot) return false;
  const std::string before = name.substr(0, number), after = name.substr(dot);
  if (before == "picture_") return after == ".png";
  return before == "frame_" && (after == ".vtp" || after == ".ply" || after == ".obj");
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
