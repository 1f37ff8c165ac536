// What is known of the self-collision of a run.
#pragma once
#include <cstdint>

namespace malha {

/// What a person may want to know.
struct SelfFacts {
  int particles = 0, edges = 0, triangles = 0;
  std::int64_t crossings = 0;       // at the start
  std::int64_t searches = 0;        // for pairs, at times more than one in a substep
  std::int64_t held = 0;            // substeps in which something would have crossed
  std::int64_t driven_through = 0;  // substeps in which bodies could not get out of the way of pins or objects
  std::int64_t candidates = 0;      // that the last search looked at
  std::int64_t pairs = 0;           // and found
  int phases = 0;                   // patches of a phase share no particle
};

}  // namespace malha
