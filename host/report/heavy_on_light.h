// SPDX-License-Identifier: Apache-2.0
// Mass ratio of a heavy body that falls on a light one.
#pragma once
#include "host/model/model.h"

namespace malha {

/// A free body that falls on a lighter free body, where self-collision detects their contact. Among the pairs of bodies
/// that start one above the other with nothing between them, it is the one with the largest mass ratio. The lighter
/// body, between the heavier one and its support, opens and closes its contacts many times in each bounce. Without
/// damping, the slightest asymmetry grows tenfold in a few bounces, and the heavier body drifts off sideways. Finite
/// elements of the same bodies with steps of 4e-5 s and no internal friction drift likewise (Figures.*HeavyOnLight*);
/// they stay in place with a material relaxation time of 0.2 ms. A body that is laid on without a fall stays in place.
struct HeavyOnLight {
  double ratio = 0;  // of the masses; 0: no such pair
  int heavy = 0, light = 0;
  double drag = 0;  // N s/m of each particle, with which the heavier body stays in place
};
HeavyOnLight worst_heavy_on_light(const Model& model);

}  // namespace malha
