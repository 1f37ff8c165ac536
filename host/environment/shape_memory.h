// SPDX-License-Identifier: Apache-2.0
// State of contacts with exact shapes that later substeps depend on, for checkpoints.
#pragma once
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

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

/// Memory of renumbered particles: particle i was particle from[i] of `particles`.
inline ShapeMemory remapped(const ShapeMemory& before, std::int64_t particles, const std::vector<int>& from) {
  ShapeMemory all{before.update, {}};
  auto next = before.overlaps.begin();
  for (std::int64_t shape = 0; next != before.overlaps.end(); ++shape) {
    std::vector<double> overlaps(static_cast<std::size_t>(particles), 0);
    for (; next != before.overlaps.end() && next->pair < (shape + 1) * particles; ++next)
      overlaps[static_cast<std::size_t>(next->pair - shape * particles)] = next->overlap;
    for (std::size_t i = 0; i < from.size(); ++i)
      if (const double overlap = overlaps[static_cast<std::size_t>(from[i])]; overlap > 0)
        all.overlaps.push_back({shape * std::ssize(from) + static_cast<std::int64_t>(i), overlap});
  }
  return all;
}

}  // namespace malha
