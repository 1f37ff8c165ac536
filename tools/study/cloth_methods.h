// SPDX-License-Identifier: Apache-2.0
// Methods that solve the hanging cloth of the benchmarks (N x N particles) in the studies of cost.
#pragma once
#include <string>
#include <vector>

#include "malha/scene.h"

namespace malha::study {

struct ClothMethod {
  std::string name;  // in charts and tables: "PBD, 10 substeps"
  bool desbrun = false;
  FilterKind filter = FilterKind::Auto;
  int substeps = 10;

  Scene scene(int side) const;  // float; tools/bench/cloth.h
  const char* style() const;    // gnuplot's style of its lines and marks

  /// Estimated memory of so many particles after set-up, and its peak during set-up: rounded up from measurements of
  /// the study "size" (size.json), to know beforehand what fits.
  double memory_bytes(double particles) const;
  double setup_peak_bytes(double particles) const;
};

/// PBD, Desbrun's method with a sparse filter and with a dense one.
const std::vector<ClothMethod>& cloth_methods();

/// A number with commas between thousands: "289", "10,000".
std::string with_commas(long long number);

}  // namespace malha::study
