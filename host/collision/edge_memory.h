// What of edges of the environment a later substep depends on, besides positions in which nothing crosses.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

namespace malha {

/// Of the last search of every group of objects, one group after the other, in the frame of its objects.
template <class R>
struct EdgeMemory {
  std::vector<std::array<R, 3>> from, way;  // m, of every particle: where it started, and how far it was expected to go
  std::vector<R> contact_distance;          // m, of every particle
  std::vector<std::int64_t> serves;         // of every group: 1 where there is a search
};

/// Of so many groups, without a search that serves.
template <class R>
EdgeMemory<R> unsearched_edges(std::size_t groups, std::size_t particles) {
  const std::vector<std::array<R, 3>> none(groups * particles);
  return {none, none, std::vector<R>(groups * particles), std::vector<std::int64_t>(groups)};
}

}  // namespace malha
