// SPDX-License-Identifier: Apache-2.0
#include "tools/view/decimated_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace malha::view {

namespace {

constexpr unsigned kNone = std::numeric_limits<unsigned>::max();

/// Adjacency lists of the particles in compressed form.
struct Neighbours {
  std::vector<std::size_t> begin;
  std::vector<unsigned> all;

  Neighbours(std::size_t count, const std::vector<std::array<unsigned, 2>>& edges) : begin(count + 1, 0) {
    for (const auto& edge : edges)
      for (const unsigned i : edge) ++begin[i + 1];
    for (std::size_t i = 0; i < count; ++i) begin[i + 1] += begin[i];
    all.resize(begin[count]);
    std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
    for (const auto& [a, b] : edges) all[next[a]++] = b, all[next[b]++] = a;
  }
  std::size_t size() const { return begin.size() - 1; }
};

/// Returns a maximal set of particles that are at least `edges` edges apart.
std::vector<unsigned> apart(const Neighbours& of, int edges) {
  std::vector<unsigned> chosen, queue;
  std::vector<unsigned> seen(of.size(), kNone);
  std::vector<bool> covered(of.size(), false);
  for (unsigned i = 0; i < of.size(); ++i) {
    if (covered[i] || of.begin[i] == of.begin[i + 1]) continue;
    chosen.push_back(i);
    queue = {i}, seen[i] = i;
    for (std::size_t from = 0, ring = 1; int(ring) < edges; ++ring)
      for (const std::size_t end = queue.size(); from < end; ++from)
        for (std::size_t k = of.begin[queue[from]]; k < of.begin[queue[from] + 1]; ++k)
          if (const unsigned j = of.all[k]; seen[j] != i) seen[j] = i, queue.push_back(j);
    for (const unsigned j : queue) covered[j] = true;
  }
  return chosen;
}

/// Returns for each particle the index in `chosen` of the one that is fewest edges away.
std::vector<unsigned> nearest(const Neighbours& of, const std::vector<unsigned>& chosen) {
  std::vector<unsigned> owner(of.size(), kNone), queue = chosen;
  for (unsigned c = 0; c < chosen.size(); ++c) owner[chosen[c]] = c;
  for (std::size_t from = 0; from < queue.size(); ++from)
    for (std::size_t k = of.begin[queue[from]]; k < of.begin[queue[from] + 1]; ++k)
      if (const unsigned j = of.all[k]; owner[j] == kNone) owner[j] = owner[queue[from]], queue.push_back(j);
  return owner;
}

}  // namespace

DecimatedMesh decimate(std::size_t count, const std::vector<std::array<unsigned, 3>>& triangles,
                       const std::vector<std::array<unsigned, 2>>& edges, double share) {
  const Neighbours neighbours(count, edges);
  // On an irregular sheet with a distance of r edges about one in 1.2 r^2 particles is chosen.
  const int rings = std::max(2, int(std::lround(std::sqrt(share / 1.2))));
  DecimatedMesh decimated{apart(neighbours, rings), {}, {}};
  const std::vector<unsigned> owner = nearest(neighbours, decimated.particles);
  for (const auto& [a, b, c] : triangles)
    if (owner[a] != owner[b] && owner[b] != owner[c] && owner[c] != owner[a])
      decimated.triangles.push_back({owner[a], owner[b], owner[c]});
  for (const auto& [a, b] : edges)
    if (owner[a] != owner[b]) decimated.edges.push_back({std::min(owner[a], owner[b]), std::max(owner[a], owner[b])});
  std::sort(decimated.edges.begin(), decimated.edges.end());
  decimated.edges.erase(std::unique(decimated.edges.begin(), decimated.edges.end()), decimated.edges.end());
  return decimated;
}

}  // namespace malha::view
