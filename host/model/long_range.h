// SPDX-License-Identifier: Apache-2.0
// Long-range attachments: the pins that limit the distance of each particle (Kim, Chentanez, Müller 2012).
#pragma once
#include <vector>

#include "malha/mesh.h"

namespace malha {

/// Attachments of particles to pins. Those of particle[k] are begin[k] .. begin[k + 1] - 1.
struct LongRangeSet {
  std::vector<int> particle;
  std::vector<int> begin;
  std::vector<int> anchor;           // pinned particle of each attachment; for each particle the farthest first
  std::vector<double> max_distance;  // m, of each attachment
  int items() const { return static_cast<int>(particle.size()); }
};

/// With more groups of pins than this, each particle is attached to its nearest pin only.
inline constexpr int kMostPinGroups = 8;

/// Adds attachments for every movable particle of a body that is connected with a pin. It is attached to the nearest
/// pin of each group of connected pins (a row of pins is one group, two corners are two), at a distance of at most (1 +
/// limit) times the geodesic distance at rest. Point i of the mesh is the particle solver_index[i].
void attach_long_range(const Mesh& mesh, const std::vector<Edge>& edges, const std::vector<bool>& pinned, double limit,
                       const std::vector<int>& solver_index, LongRangeSet& set);

}  // namespace malha
