// SPDX-License-Identifier: Apache-2.0
// What particles are coloured by.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "tools/view/looks.h"
#include "tools/view/painter.h"

namespace malha::view {

/// A place on the scale from blue to red (turbo, Mikhailov 2019), from 0 to 1.
Colour turbo(double part);
/// Of things that are counted: neighbours differ.
Colour distinct(int number);

/// Colours of a frame, what is drawn beside it, and what is at the red end of the scale; none: a look without one.
struct Coloured {
  std::vector<Colour> colours;
  Marks marks;
  std::optional<double> most;
  std::string legend;
};
/// What `looks` does not know of this frame's bodies is not coloured.
Coloured coloured(const Frame& frame, const Looks& looks, Look look);

}  // namespace malha::view
