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

constexpr int kSides = 3;

struct Library {
  decltype(&cblas_sgemm) sgemm;
  decltype(&cblas_ssymm) ssymm;
  decltype(&cblas_ssymv) ssymv;
  decltype(&openblas_set_num_threads) set_threads;
  decltype(&openblas_get_config) config;
  decltype(&openblas_get_corename) core;
};

/// Opened when it is first asked for, because it starts its threads then: other commands have no use for them. Null: it
/// is no longer where it was when malha was built.
const Library* library() {
  static const std::optional<Library> found = []() -> std::optional<Library> {
    void* handle = dlopen(OPENBLAS_FILE, RTLD_NOW | RTLD_LOCAL);
    if (handle == nullptr) return std::nullopt;
    bool whole = true;
    const auto get = [&](auto& function, const char* name) {
      function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(handle, name));
      whole = whole && function != nullptr;
    };
    Library all{};
    get(all.sgemm, "cblas_sgemm"), get(all.ssymm, "cblas_ssymm"), get(all.ssymv, "cblas_ssymv");
    get(all.set_threads, "openblas_set_num_threads");
    get(all.config, "openblas_get_config"), get(all.core, "openblas_get_corename");
    return whole ? std::optional(all) : std::nullopt;
  }();
  return found ? &*found : nullptr;
}

/// Right-hand sides and results.
struct Sides {
  int n;
  std::vector<float> b, c;
  explicit Sides(int unknowns)
      : n(unknowns), b(std::size_t(kSides) * unknowns, 1.0f), c(std::size_t(kSides) * unknowns, 0.0f) {}
  std::size_t place(CBLAS_ORDER order, int i, int k) const {
    return order == CblasRowMajor ? std::size_t(kSides) * i + k : std::size_t(n) * k + i;
  }
};

/// A product that multiplies sides.b into sides.c, which lie as `order` says.
BlasProduct product(const std::string& routine, const std::string& way, double bytes, CBLAS_ORDER order,
                    const std::shared_ptr<Sides>& sides, const std::function<void()>& multiply) {
  const auto apply = [=](const std::vector<double>& forces) {
    for (int i = 0; i < sides->n; ++i)
      for (int k = 0; k < kSides; ++k)
        sides->b[sides->place(order, i, k)] = static_cast<float>(forces[std::size_t(kSides) * i + k]);
    multiply();
    std::vector<double> result(forces.size());
    for (int i = 0; i < sides->n; ++i)
      for (int k = 0; k < kSides; ++k) result[std::size_t(kSides) * i + k] = sides->c[sides->place(order, i, k)];
    return result;
  };
  return {routine, way, bytes, multiply, apply};
}

std::string name(CBLAS_ORDER order) { return order == CblasRowMajor ? "row-major" : "column-major"; }
std::string name(CBLAS_UPLO triangle) { return triangle == CblasUpper ? ", upper" : ", lower"; }
std::string name(CBLAS_TRANSPOSE transpose) { return transpose == CblasTrans ? ", transposed" : ""; }

/// By time, of some products each.
BlasProduct fastest(const std::vector<BlasProduct>& ways) {
  std::vector<double> best(ways.size(), 1e30);
  for (int turn = 0; turn < 4; ++turn)
    for (std::size_t k = 0; k < ways.size(); ++k) best[k] = std::min(best[k], seconds(ways[k].multiply));
  return ways[std::min_element(best.begin(), best.end()) - best.begin()];
}

}  // namespace

std::vector<BlasProduct> blas_products(int n, const float* s, int threads) {
  const Library& blas = *library();
  blas.set_threads(threads);
  const auto sides = std::make_shared<Sides>(n);
  const double whole = double(n) * n * sizeof(float), half = double(n) * (n + 1) / 2 * sizeof(float);
  std::vector<BlasProduct> gemm, symm, symv;
  for (const CBLAS_ORDER order : {CblasRowMajor, CblasColMajor}) {
    const int stride = order == CblasRowMajor ? kSides : n;
    // S is its own transpose.
    for (const CBLAS_TRANSPOSE transpose : {CblasNoTrans, CblasTrans})
      gemm.push_back(product("sgemm", name(order) + name(transpose), whole, order, sides, [=, &blas] {
        blas.sgemm(order, transpose, CblasNoTrans, n, kSides, n, 1, s, n, sides->b.data(), stride, 0, sides->c.data(),
                   stride);
      }));
    // From the left alone: from the right in one order is from the left in the other.
    for (const CBLAS_UPLO triangle : {CblasUpper, CblasLower})
      symm.push_back(product("ssymm", name(order) + name(triangle), half, order, sides, [=, &blas] {
        blas.ssymm(order, CblasLeft, triangle, n, kSides, 1, s, n, sides->b.data(), stride, 0, sides->c.data(), stride);
      }));
  }
  for (const CBLAS_UPLO triangle : {CblasUpper, CblasLower})
    symv.push_back(
        product("ssymv", name(CblasColMajor) + name(triangle), kSides * half, CblasColMajor, sides, [=, &blas] {
          for (int k = 0; k < kSides; ++k)
            blas.ssymv(CblasColMajor, triangle, n, 1, s, n, sides->b.data() + std::size_t(n) * k, 1, 0,
                       sides->c.data() + std::size_t(n) * k, 1);
        }));
  return {fastest(gemm), fastest(symm), fastest(symv)};
}

std::string openblas_version() {
  if (library() == nullptr) return "";
  const std::string config = library()->config();  // "OpenBLAS 0.3.21 NO_LAPACKE DYNAMIC_ARCH ..."
  return config.substr(0, config.find(' ', config.find(' ') + 1)) + " (" + library()->core() + ")";
}

}  // namespace malha::bench
