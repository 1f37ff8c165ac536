// SPDX-License-Identifier: Apache-2.0
// OpenBLAS as a peer of dense filters, if the build found it: S times three right-hand sides.
#pragma once
#include <functional>
#include <string>
#include <vector>

namespace malha::bench {

/// A BLAS routine that computes the product.
struct BlasProduct {
  std::string routine;  // "sgemm", "ssymm" or "ssymv" (three times)
  std::string layout;   // row-major or column-major, and the triangle or transpose
  double bytes = 0;     // of S that it must read
  std::function<void()> multiply;
  /// S F; three values per unknown.
  std::function<std::vector<double>(const std::vector<double>& forces)> apply;
};

/// Every routine in the layout that is the fastest on this machine. `s`: n x n, symmetric, both triangles stored; it
/// must outlive the products. Products of different numbers of threads exclude each other, since OpenBLAS has one
/// number for the whole process. Requires a non-empty openblas_version().
std::vector<BlasProduct> blas_products(int n, const float* s, int threads);

/// "OpenBLAS 0.3.21 (Zen)"; empty if it was not installed when malha was built, or is no longer.
std::string openblas_version();

}  // namespace malha::bench
