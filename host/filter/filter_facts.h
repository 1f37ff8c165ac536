// What a person may want to know of a filter.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

namespace malha {

struct FilterFacts {
  std::string kind;     // "dense" or "sparse"
  std::string storage;  // "float", "double" or "int16"
  std::string why;      // the scene's word, or the costs that were compared
  int unknowns = 0, bodies = 0;
  std::int64_t numbers = 0;  // stored, each read once (dense) or twice (sparse) a product
  std::size_t bytes = 0;
  int launches = 0;                                                  // of a product
  double order_seconds = 0, factor_seconds = 0, column_seconds = 0;  // of set-up; columns: of the dense S
};

/// Relative errors |S~ F - S F| / |S F|, over forces of independent random numbers and over elastic ones (A - M) d /
/// dt^2 of random displacements d, which S takes most of away. S F: in double, to rounding, by iterative refinement.
struct FilterErrors {
  double noise = 0, elastic = 0;
};
/// How much of a long set-up is done, in [0, 1]; called by one thread at a time.
using ShowProgress = std::function<void(const char* what, double part)>;

}  // namespace malha
