// What a later substep knows of the pairs of particles and environment meshes: part of the state of a run.
#pragma once
#include <vector>

#include "kernels/nearby.h"

namespace malha {

/// Mesh after mesh. Empty: nothing has been seen.
struct ContactMemory {
  std::vector<WordBall> balls;    // of each word: what is far has nothing else
  std::vector<PlaceSeen> places;  // of each particle of the words without a ball
  std::vector<SeenOfPair> near;   // of what is near, ascending
};

/// How many words hold so many particles.
inline std::size_t words_of(std::size_t particles) { return (particles + kWord - 1) / kWord; }

/// How many places there are of one mesh, whose first ball this is.
inline std::size_t places_of(const WordBall* balls, std::size_t particles) {
  std::size_t sum = 0;
  for (std::size_t first = 0; first < particles; first += kWord)
    if (!balls[first / kWord].keeps_all()) sum += particles - first < kWord ? particles - first : kWord;
  return sum;
}

}  // namespace malha
