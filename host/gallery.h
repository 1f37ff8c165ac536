// The pictures of a run: one of the end, a series if asked for, and a storyboard.
#pragma once
#include <filesystem>
#include <vector>

#include "host/image.h"
#include "host/model.h"
#include "host/picture.h"

namespace malha {

/// Bodies (positions in the user's order) and environment at a time (s), ready to be rendered.
std::vector<Drawing> draw(const Model& model, const std::vector<Vec3>& positions, double time);

class Gallery {
 public:
  /// Pictures go to `folder`: picture.png, storyboard.png and pictures/picture_000000.png ... The scene's outputs say
  /// which (outputs.picture is set), `steps` is how many steps the run will have.
  Gallery(const Model& model, const std::filesystem::path& folder, std::int64_t steps, int threads);

  /// Call at the start and after every step.
  void look(std::int64_t step, double time, const std::vector<Vec3>& positions);
  /// Whether look would make a picture of this step: positions need not be fetched for the others.
  bool wants(std::int64_t step) const;
  /// The picture of the end, and the storyboard of what was seen.
  void finish(double time, const std::vector<Vec3>& positions);

 private:
  Image take(double time, const std::vector<Vec3>& positions, int divisor) const;
  bool in_series(std::int64_t step) const;
  bool in_storyboard(std::int64_t step) const;

  const Model& model_;
  std::filesystem::path folder_;
  std::int64_t steps_;
  int threads_;
  Camera camera_;
  std::vector<Image> storyboard_;
};

}  // namespace malha
