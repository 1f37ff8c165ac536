// What particles are coloured by.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "tools/view/frame.h"
#include "tools/view/painter.h"

namespace malha::view {

enum class Look { Bodies, Strain, Speed };
inline constexpr std::array kLookNames{"bodies", "strain", "speed"};

/// A place on the scale from blue to red (turbo, Mikhailov 2019), from 0 to 1.
Colour turbo(double part);

/// Colours of a frame, and what is at the red end of the scale; none: a look without one.
struct Coloured {
  std::vector<Colour> colours;
  std::optional<double> most;
  std::string unit{};
};
/// `most`: what is to be red; 0: the most of this frame.
Coloured coloured(const Frame& frame, Look look, double most);

/// |l - l0| / l0, the mean over the edges at each particle; l0 at the start of the scene.
std::vector<float> mean_strains(const Frame& frame);

}  // namespace malha::view
