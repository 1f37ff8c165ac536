// What a person may want to know of the contacts with the environment.
#pragma once
#include <cstddef>

namespace malha {

struct ContactFacts {
  long long looks = 0;                        // since the start, at particles that may have come near
  long long queries = 0;                      // of all triangles of a mesh among them, by Embree
  int near = 0;                               // particles near a surface now, once for each mesh
  std::size_t near_bytes = 0, far_bytes = 0;  // of what is remembered of them, and of all others
  std::size_t cell_bytes = 0;                 // of the meshes' lists of near triangles
};

}  // namespace malha
