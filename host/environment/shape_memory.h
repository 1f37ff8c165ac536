// SPDX-License-Identifier: Apache-2.0
// State of contacts with exact shapes that later substeps depend on, for checkpoints.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "host/environment/layout_map.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {

/// An overlap of a particle and a shape that is kept, m; pair = shape * particles + particle.
struct OverlapRecord {
  std::int64_t pair = 0;
  double overlap = 0;
};

/// This says what the next detection does about overlaps, before it detects.
enum class OverlapUpdate : std::int64_t {
  None,
  Start,  // it finds them, as at the start of a run
  Keep,   // it finds them anew, because pins were released
};

struct ShapeMemory {
  OverlapUpdate update = OverlapUpdate::Start;
  std::vector<OverlapRecord> overlaps;  // by increasing pair
};

/// Throws InputError for memory that no run can have saved.
inline void check(const ShapeMemory& memory, std::int64_t pairs, const std::string& file) {
  if (memory.update < OverlapUpdate::None || memory.update > OverlapUpdate::Keep)
    refuse(file, "shapes", "an unknown update of overlaps", "0, 1 or 2");
  std::int64_t least = 0;
  for (const auto& [pair, overlap] : memory.overlaps) {
    if (pair < least || pair >= pairs)
      refuse(file, "shapes", "pair " + std::to_string(pair),
             std::to_string(least) + " to " + std::to_string(pairs - 1));
    if (!(overlap > 0 && std::isfinite(overlap))) refuse(file, "shapes", shown(overlap) + " m of overlap", "a length");
    least = pair + 1;
  }
}

/// Memory in another layout, of a layout with this many particles.
inline ShapeMemory remapped(const ShapeMemory& before, std::int64_t particles, const LayoutMap& map) {
  ShapeMemory all{before.update, {}};
  std::vector<double> overlaps(static_cast<std::size_t>(particles));
  for (std::size_t shape = 0; shape < map.shapes.size(); ++shape) {
    if (map.shapes[shape] == LayoutMap::kNew) continue;
    const std::int64_t first = map.shapes[shape] * particles;
    std::ranges::fill(overlaps, 0);
    for (const OverlapRecord& of : before.overlaps)
      if (of.pair >= first && of.pair < first + particles)
        overlaps[static_cast<std::size_t>(of.pair - first)] = of.overlap;
    for (std::size_t i = 0; i < map.particles.size(); ++i) {
      const int from = map.particles[i];
      const double overlap = from == LayoutMap::kNew ? 0 : overlaps[static_cast<std::size_t>(from)];
      if (overlap > 0) all.overlaps.push_back({static_cast<std::int64_t>(shape * map.particles.size() + i), overlap});
    }
  }
  return all;
}

/// Adds the overlaps of new pairs, which were `found`, to those that others keep.
inline void add_new(const ShapeMemory& found, const LayoutMap& map, ShapeMemory& memory) {
  const auto particles = std::ssize(map.particles);
  for (const OverlapRecord& of : found.overlaps)
    if (map.is_new(map.shapes, static_cast<std::size_t>(of.pair / particles),
                   static_cast<std::size_t>(of.pair % particles)))
      memory.overlaps.push_back(of);
  std::ranges::sort(memory.overlaps, {}, &OverlapRecord::pair);
}

}  // namespace malha
