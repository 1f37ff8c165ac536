// SPDX-License-Identifier: Apache-2.0
// Scenes of the study "parsimony": pairs of scenes without and with a feature.
#pragma once
#include <string>
#include <vector>

#include "malha/scene.h"

namespace malha::study {

/// A scene with a feature, and the same scene without it.
struct FeatureCase {
  std::string feature;  // "air on faces"
  std::string base;     // "cloth"
  Scene without, with;
};

/// Each feature alone, added to the smallest scene that can have it. The first one adds nothing, and shows by how much
/// the times of the same scene differ.
std::vector<FeatureCase> single_features(bool quick);

/// A cloth with more and more features: every rung has all features of the rungs before it.
std::vector<FeatureCase> feature_ladder(bool quick);

}  // namespace malha::study
