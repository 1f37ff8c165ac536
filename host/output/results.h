// SPDX-License-Identifier: Apache-2.0
// What a run leaves in its folder, by name.
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

  /// Removes what an earlier run left, and nothing else. Throws std::runtime_error (permissions).
  void remove() const;
};

}  // namespace malha
