// SPDX-License-Identifier: Apache-2.0
// Cutting by hand: which vertices split where a knife crosses edges.
#pragma once
#include <vector>

#include "host/model/tear.h"

namespace malha {

/// The splits that part the ends of these edges (the user's numbers), each given as {left, right} of the knife. The
/// cut runs along edges of the mesh, on one side of the knife: on the left, or on the right where fewer of the ends are
/// pinned. What is crossed stays whole on the other side. A vertex that has nothing but crossed faces goes with them.
/// Pinned vertices split too, and pins hold both parts. What shares no face or line any more is left as it is.
/// `pinned`: of each particle, see pinned_now(). Throws InputError for particles that are not there or are of two
/// bodies, and for a body without "tear".
std::vector<Split> find_cuts(const Model& model, const std::vector<Edge>& crossed, const std::vector<bool>& pinned);

}  // namespace malha
