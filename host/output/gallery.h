// SPDX-License-Identifier: Apache-2.0
// Pictures of a run: one of the end, a series if the scene names one, and a storyboard.
#pragma once
#include <vector>

#include "host/model/model.h"
#include "host/output/results.h"
#include "host/render/image.h"
#include "host/render/picture.h"
#include "malha/simulation.h"

namespace malha {

/// Returns drawings of bodies (positions in the user's order) and environment at a time (s).
std::vector<Drawing> draw(const Model& model, const std::vector<Vec3>& positions, double time);

class Gallery {
 public:
  /// Draws the pictures that the scene's outputs name (outputs.picture is set) of a run from step `first` to `last`.
  Gallery(const Simulation& simulation, const Results& results, std::int64_t first, std::int64_t last,
          const std::atomic<bool>* stop = nullptr);

  /// Draws the pictures that are due at this step; called at the start and after every step. Pictures that `stop`
  /// interrupts are left out.
  void draw_if_due(std::int64_t step, double time, const std::vector<Vec3>& positions);
  /// Returns whether this step has a picture, so that positions are fetched for no other.
  bool is_due(std::int64_t step) const;
  /// Writes the picture of the end, which `stop` does not interrupt.
  void finish(double time, const std::vector<Vec3>& positions) const;
  /// Writes the storyboard of the pictures so far.
  void write_storyboard() const;

 private:
  Image render_image(double time, const std::vector<Vec3>& positions, int divisor, const std::atomic<bool>* stop) const;
  bool in_series(std::int64_t step) const;
  bool in_storyboard(std::int64_t step) const;

  const Simulation& simulation_;
  Results results_;
  std::int64_t first_, last_;
  Camera camera_;
  const std::atomic<bool>* stop_;
  std::vector<Image> storyboard_;
};

}  // namespace malha
