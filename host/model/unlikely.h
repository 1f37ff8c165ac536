// SPDX-License-Identifier: Apache-2.0
// The default thickness of contacts, and settings that can be meant but seldom are: other units, a thickness that the
// mesh does not go with, a body that nothing holds together.
#pragma once
#include <string>
#include <vector>

#include "host/model/body.h"
#include "host/model/model.h"

namespace malha {

/// m: the smallest of the bodies' median edges; infinite without edges.
double finest_edge(const std::vector<Body>& bodies);

/// What an object that names no thickness has, m: 5 mm, or a fifth of the finest body's edges where that is less, so
/// that no body floats visibly.
double default_thickness(double finest_edge);

/// A line for each setting of the scene that is probably not meant, with the ratio that gave it away. The model's
/// scene, look and environment are as they will be simulated.
std::vector<std::string> unlikely_settings(const Model& model, const std::vector<Body>& bodies);

}  // namespace malha
