// SPDX-License-Identifier: Apache-2.0
// The pictures of a run: one of the end, a series if asked for, and a storyboard.
#pragma once
#include <vector>

#include "host/model/model.h"
#include "host/output/results.h"
#include "host/render/image.h"
#include "host/render/picture.h"

namespace malha {

/// Bodies (positions in the user's order) and environment at a time (s), ready to be rendered.
std::vector<Drawing> draw(const Model& model, const std::vector<Vec3>& positions, double time);

class Gallery {
 public:
  /// The scene's outputs say which pictures to make (outputs.picture is set); the run goes from step `first` to `last`.
  Gallery(const Model& model, const Results& results, std::int64_t first, std::int64_t last, int threads,
          const std::atomic<bool>* stop = nullptr);

  /// Call at the start and after every step. What is not drawn when the run is stopped is left out.
  void look(std::int64_t step, double time, const std::vector<Vec3>& positions);
  /// Whether look would make a picture of this step: positions need not be fetched for the others.
  bool wants(std::int64_t step) const;
  /// The picture of the end, which is drawn whole.
  void finish(double time, const std::vector<Vec3>& positions) const;
  /// Of what was seen so far.
  void write_storyboard() const;

 private:
  Image take(double time, const std::vector<Vec3>& positions, int divisor, const std::atomic<bool>* stop) const;
  bool in_series(std::int64_t step) const;
  bool in_storyboard(std::int64_t step) const;

  const Model& model_;
  Results results_;
  std::int64_t first_, last_;
  int threads_;
  Camera camera_;
  const std::atomic<bool>* stop_;
  std::vector<Image> storyboard_;
};

}  // namespace malha
