// SPDX-License-Identifier: Apache-2.0
// Which pins each particle of a body hangs on, and how far from them it may go (Kim, Chentanez, Müller 2012).
#pragma once
#include <vector>

#include "malha/mesh.h"

namespace malha {

/// Attachments of particles to pins, item by item: those of item k are begin[k] .. begin[k + 1] - 1.
struct LongRangeSet {
  std::vector<int> particle;
  std::vector<int> begin;
  std::vector<int> anchor;    // pinned particles; of an item the farthest first
  std::vector<double> reach;  // m
  int items() const { return static_cast<int>(particle.size()); }
};

/// With more groups of pins than this a particle hangs on its nearest pin alone.
inline constexpr int kMostPinGroups = 8;

/// Adds every movable particle of a body that some pin can be reached from. It hangs on the nearest pin of each group
/// of connected pins (a row of pins is a group, two corners are two), at most (1 + limit) times as far along the mesh
/// as at rest. Particle i of the mesh becomes name[i].
void attach_long_range(const Mesh& mesh, const std::vector<Edge>& edges, const std::vector<bool>& pinned, double limit,
                       const std::vector<int>& name, LongRangeSet& set);

}  // namespace malha
