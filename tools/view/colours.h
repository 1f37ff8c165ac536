// SPDX-License-Identifier: Apache-2.0
// Colours of particles by a visual field.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "tools/view/painter.h"
#include "tools/view/visual_fields.h"

namespace malha::view {

/// Returns the colour at 0 to 1 on the scale from blue to red (turbo, Mikhailov 2019).
Colour turbo(double part);
/// Returns the colour of a number; consecutive numbers differ clearly.
Colour distinct(int number);

/// Colours of a frame, lines that are drawn beside it, and the value at the red end of the scale, if the field has one.
struct Coloured {
  std::vector<Colour> colours;
  Marks marks;
  std::optional<double> most;
  std::string legend;
};
/// Colours a frame by a visual field; by body where `fields` lacks that field of the frame's bodies.
Coloured coloured(const Frame& frame, const VisualFields& fields, VisualField field);

}  // namespace malha::view
