// SPDX-License-Identifier: Apache-2.0
// The peer of dense filters, where the build found it: S times three right-hand sides, by OpenBLAS.
#pragma once
#include <functional>
#include <string>
#include <vector>

namespace malha::bench {

/// One way to have the product.
struct BlasProduct {
  std::string routine;  // "sgemm", "ssymm" or "ssymv" (three times)
  std::string way;      // which layout, triangle or transpose
  double bytes = 0;     // of S, that it must read
  std::function<void()> multiply;
  /// S F; three numbers an unknown.
  std::function<std::vector<double>(const std::vector<double>& forces)> apply;
};

/// Every routine in the way that proves to be the fastest here. `s`: n x n, symmetric, whole; it must outlive them.
/// One number of threads at a time: OpenBLAS has it for the whole process. Only where there is a version.
std::vector<BlasProduct> blas_products(int n, const float* s, int threads);

/// "OpenBLAS 0.3.21 (Zen)"; empty: it was not there when malha was built, or is no longer.
std::string openblas_version();

}  // namespace malha::bench
