// SPDX-License-Identifier: Apache-2.0
// The scenes of the study "parsimony": what a feature is added to, and the scene with it.
#pragma once
#include <string>
#include <vector>

#include "malha/scene.h"

namespace malha::study {

/// A scene, and the same without one feature.
struct FeatureCase {
  std::string feature;  // "air on faces"
  std::string base;     // "cloth"
  Scene without, with;
};

/// Each feature alone, added to the least scene that can have it. The first adds nothing: how far the times of one and
/// the same scene lie apart.
std::vector<FeatureCase> single_features(bool quick);

/// One cloth that is asked for more and more: every rung has all features of those before it.
std::vector<FeatureCase> feature_ladder(bool quick);

}  // namespace malha::study
