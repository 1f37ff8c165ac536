// What a person may want to know of contacts with edges and corners of the environment.
#pragma once
#include <cstddef>
#include <cstdint>

namespace malha {

struct EdgeFacts {
  int edges = 0, corners = 0;   // of the environment, that can touch
  std::int64_t candidates = 0;  // pairs that may come near in the next substeps
  std::int64_t pairs = 0;       // that may in this one
  std::int64_t searches = 0;    // for pairs, at times more than one in a substep
  std::int64_t laid_again = 0;  // in which constraints pulled so far that pairs were looked at twice
  std::int64_t held = 0;        // in which something would have crossed
  std::size_t bytes = 0;

  EdgeFacts& operator+=(const EdgeFacts& o) {
    edges += o.edges, corners += o.corners, candidates += o.candidates, pairs += o.pairs;
    searches += o.searches, laid_again += o.laid_again, held += o.held, bytes += o.bytes;
    return *this;
  }
};

}  // namespace malha
