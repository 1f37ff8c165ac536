// How the constraints of one kind lie in memory: colour after colour, each cut into packs.
#pragma once
#include <vector>

#include "host/solver/colour.h"
#include "kernels/constraint.h"

namespace malha {

struct Layout {
  std::vector<int> constraint;  // of each slot; padding repeats the last constraint of its colour
  std::vector<Batch> batches;   // one a colour
};

/// Colours start at a multiple of `lanes`. Within a colour the constraints without pinned particles come first: their
/// packs are written back whole, the rest lane by lane.
Layout lay_out(const std::vector<int>& particles, int arity, const std::vector<bool>& pinned,
               const Colouring& colouring, int lanes);

}  // namespace malha
