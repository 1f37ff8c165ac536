// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/peers/openblas.h"

#include <cblas.h>
#include <dlfcn.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <type_traits>

#include "host/base/stopwatch.h"

namespace malha::bench {

namespace {

constexpr int kRightHandSides = 3;

struct Library {
  decltype(&cblas_sgemm) sgemm;
  decltype(&cblas_ssymm) ssymm;
  decltype(&cblas_ssymv) ssymv;
  decltype(&openblas_set_num_threads) set_threads;
  decltype(&openblas_get_config) config;
  decltype(&openblas_get_corename) core;
};

/// Loads OpenBLAS at the first call, because loading starts its threads, which other commands do not need. Null if the
/// library is no longer where it was when malha was built.
const Library* library() {
  static const std::optional<Library> found = []() -> std::optional<Library> {
    void* handle = dlopen(OPENBLAS_FILE, RTLD_NOW | RTLD_LOCAL);
    if (handle == nullptr) return std::nullopt;
    bool full = true;
    const auto get = [&](auto& function, const char* name) {
      function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(handle, name));
      full = full && function != nullptr;
    };
    Library all{};
    get(all.sgemm, "cblas_sgemm"), get(all.ssymm, "cblas_ssymm"), get(all.ssymv, "cblas_ssymv");
    get(all.set_threads, "openblas_set_num_threads");
    get(all.config, "openblas_get_config"), get(all.core, "openblas_get_corename");
    return full ? std::optional(all) : std::nullopt;
  }();
  return found ? &*found : nullptr;
}

/// Right-hand sides b and results c.
struct RightHandSides {
  int n;
  std::vector<float> b, c;
  explicit RightHandSides(int unknowns)
      : n(unknowns),
        b(std::size_t(kRightHandSides) * unknowns, 1.0f),
        c(std::size_t(kRightHandSides) * unknowns, 0.0f) {}
  std::size_t index(CBLAS_ORDER order, int i, int k) const {
    return order == CblasRowMajor ? std::size_t(kRightHandSides) * i + k : std::size_t(n) * k + i;
  }
};

/// A product that computes vectors.c from vectors.b, both stored in `order`.
BlasProduct product(const std::string& routine, const std::string& layout, double bytes, CBLAS_ORDER order,
                    const std::shared_ptr<RightHandSides>& vectors, const std::function<void()>& multiply) {
  const auto apply = [=](const std::vector<double>& forces) {
    for (int i = 0; i < vectors->n; ++i)
      for (int k = 0; k < kRightHandSides; ++k)
        vectors->b[vectors->index(order, i, k)] = static_cast<float>(forces[std::size_t(kRightHandSides) * i + k]);
    multiply();
    std::vector<double> result(forces.size());
    for (int i = 0; i < vectors->n; ++i)
      for (int k = 0; k < kRightHandSides; ++k)
        result[std::size_t(kRightHandSides) * i + k] = vectors->c[vectors->index(order, i, k)];
    return result;
  };
  return {routine, layout, bytes, multiply, apply};
}

std::string name(CBLAS_ORDER order) { return order == CblasRowMajor ? "row-major" : "column-major"; }
std::string name(CBLAS_UPLO triangle) { return triangle == CblasUpper ? ", upper" : ", lower"; }
std::string name(CBLAS_TRANSPOSE transpose) { return transpose == CblasTrans ? ", transposed" : ""; }

/// The fastest of the variants, by the best of some products each.
BlasProduct fastest(const std::vector<BlasProduct>& variants) {
  std::vector<double> best(variants.size(), 1e30);
  for (int turn = 0; turn < 4; ++turn)
    for (std::size_t k = 0; k < variants.size(); ++k) best[k] = std::min(best[k], seconds(variants[k].multiply));
  return variants[std::min_element(best.begin(), best.end()) - best.begin()];
}

}  // namespace

std::vector<BlasProduct> blas_products(int n, const float* s, int threads) {
  const Library& blas = *library();
  blas.set_threads(threads);
  const auto vectors = std::make_shared<RightHandSides>(n);
  const double full = double(n) * n * sizeof(float), half = double(n) * (n + 1) / 2 * sizeof(float);
  std::vector<BlasProduct> gemm, symm, symv;
  for (const CBLAS_ORDER order : {CblasRowMajor, CblasColMajor}) {
    const int stride = order == CblasRowMajor ? kRightHandSides : n;
    // S is its own transpose.
    for (const CBLAS_TRANSPOSE transpose : {CblasNoTrans, CblasTrans})
      gemm.push_back(product("sgemm", name(order) + name(transpose), full, order, vectors, [=, &blas] {
        blas.sgemm(order, transpose, CblasNoTrans, n, kRightHandSides, n, 1, s, n, vectors->b.data(), stride, 0,
                   vectors->c.data(), stride);
      }));
    // Only from the left: a product from the right in one order is a product from the left in the other.
    for (const CBLAS_UPLO triangle : {CblasUpper, CblasLower})
      symm.push_back(product("ssymm", name(order) + name(triangle), half, order, vectors, [=, &blas] {
        blas.ssymm(order, CblasLeft, triangle, n, kRightHandSides, 1, s, n, vectors->b.data(), stride, 0,
                   vectors->c.data(), stride);
      }));
  }
  for (const CBLAS_UPLO triangle : {CblasUpper, CblasLower})
    symv.push_back(product("ssymv", name(CblasColMajor) + name(triangle), kRightHandSides * half, CblasColMajor,
                           vectors, [=, &blas] {
                             for (int k = 0; k < kRightHandSides; ++k)
                               blas.ssymv(CblasColMajor, triangle, n, 1, s, n, vectors->b.data() + std::size_t(n) * k,
                                          1, 0, vectors->c.data() + std::size_t(n) * k, 1);
                           }));
  return {fastest(gemm), fastest(symm), fastest(symv)};
}

std::string openblas_version() {
  if (library() == nullptr) return "";
  const std::string config = library()->config();  // "OpenBLAS 0.3.21 NO_LAPACKE DYNAMIC_ARCH ..."
  return config.substr(0, config.find(' ', config.find(' ') + 1)) + " (" + library()->core() + ")";
}

}  // namespace malha::bench
