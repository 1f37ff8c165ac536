// SPDX-License-Identifier: Apache-2.0
// The hanging cloth of the benchmarks, N x N particles, by the methods whose cost is studied.
#pragma once
#include <string>
#include <vector>

#include "malha/scene.h"

namespace malha::study {

struct ClothMethod {
  std::string name;  // "PBD, 10 substeps", as charts and tables say it
  bool desbrun = false;
  FilterKind filter = FilterKind::Auto;
  int substeps = 10;

  Scene scene(int side) const;  // float; tools/bench/cloth.h
  const char* style() const;    // of its lines and marks in charts, of gnuplot

  /// What so many particles take once they are set up, and at most while they are: rounded up from what this study's
  /// own runs held (size.json), to know beforehand what fits.
  double memory_bytes(double particles) const;
  double setup_peak_bytes(double particles) const;
};

/// PBD, Desbrun's method with a sparse filter and with a dense one.
const std::vector<ClothMethod>& cloth_methods();

/// "289", "10,000".
std::string with_commas(long long number);

}  // namespace malha::study
