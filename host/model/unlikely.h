// SPDX-License-Identifier: Apache-2.0
// Default thickness of contacts, and warnings about valid settings that are probably mistakes: other units, a thickness
// that does not fit the mesh, a body without constraints.
#pragma once
#include <string>
#include <vector>

#include "host/model/body.h"
#include "host/model/model.h"

namespace malha {

/// The smallest of the median edge lengths of the bodies (m); infinite without edges.
double finest_edge(const std::vector<Body>& bodies);

/// The thickness (m) of an object that has none in the scene: 5 mm, or a fifth of `finest_edge` (m) if that is less, so
/// that no body floats visibly.
double default_thickness(double finest_edge);

/// A line of text for each setting of the scene that is probably a mistake, with the ratio that shows it. Of the model
/// only the scene, the render mesh and the environment are used.
std::vector<std::string> unlikely_settings(const Model& model, const std::vector<Body>& bodies);

}  // namespace malha
