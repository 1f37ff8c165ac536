// SPDX-License-Identifier: Apache-2.0
// Cutting by a knife: the vertex splits that separate the edges it crosses.
#pragma once
#include <vector>

#include "host/model/tear.h"

namespace malha {

/// The splits that separate the two ends of these edges (the user's numbering), each given as {left, right} of the
/// knife. The cut runs along edges of the mesh, on the left of the knife, or on the right if fewer ends are pinned
/// there. Crossed faces stay whole, on the other side of the cut. A vertex all of whose faces are crossed is not split.
/// Pinned vertices split too, and both resulting particles are pinned. Ends that no longer share a face or line are
/// left as they are. `pinned`: see pinned_now(). Throws InputError for an index out of range, for an edge between two
/// bodies, and for a body without "tear".
std::vector<Split> find_cuts(const Model& model, const std::vector<Edge>& crossed, const std::vector<bool>& pinned);

}  // namespace malha
