// SPDX-License-Identifier: Apache-2.0
// Heavy bodies that fall on light ones.
#pragma once
#include "host/model/model.h"

namespace malha {

/// A free body that falls on a free one that is lighter, and that self-collision lets touch: of the pairs of bodies
/// that start one above the other, with nothing between, the one of which the masses differ most. The lighter one,
/// between the heavier one and what it lies on, opens and closes its contacts many times in each bounce, and while
/// nothing damps that, the slightest difference between its sides grows tenfold in a few bounces: the heavier one walks
/// off. So it does by finite elements of the same bodies with steps of 4e-5 s and no friction inside
/// (Figures.*HeavyOnLight*), which stay where they are with a relaxation time of 0.2 ms of their material. What is laid
/// on stays.
struct HeavyOnLight {
  double ratio = 0;  // of their masses; 0: there is none
  int heavy = 0, light = 0;
  double drag = 0;  // N s/m of each particle, with which it stays
};
HeavyOnLight worst_heavy_on_light(const Model& model);

}  // namespace malha
