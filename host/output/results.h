// SPDX-License-Identifier: Apache-2.0
// Names of the files that a run writes to its folder.
#pragma once
#include <filesystem>

namespace malha {

struct Results {
  explicit Results(const std::filesystem::path& folder_path);

  std::filesystem::path folder;
  std::filesystem::path report;      // report.json
  std::filesystem::path checkpoint;  // checkpoint.malha
  std::filesystem::path picture;     // picture.png, of the end
  std::filesystem::path storyboard;  // storyboard.png
  std::filesystem::path page;        // page.html
  std::filesystem::path frames;      // frames/, see host/output/frames.h
  std::filesystem::path pictures;    // pictures/picture_000000.png ...

  /// Removes the files of an earlier run, and nothing else. Throws std::runtime_error (permissions).
  void remove() const;
};

}  // namespace malha
