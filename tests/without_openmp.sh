#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# usage: without_openmp.sh ROOT COMPILER
# OpenMP is used in one file alone (kernels/parallel/compute.h), and that file works without it: one thread computes, or
# threads of the program do.
set -euo pipefail
root=${1:?} compiler=${2:?}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

if grep -rnE 'omp\.h|omp_[a-z]+\(|#pragma omp (parallel|for|critical|barrier)' "$root/host" "$root/kernels" \
  --include=*.h --include=*.cpp | grep -v '^[^:]*kernels/parallel/compute.h:'; then
  echo "these use OpenMP; allowed: kernels/parallel/compute.h alone"
  exit 1
fi
cat >"$scratch/main.cpp" <<'PROGRAM'
#include <cstdio>
#include <thread>
#include <vector>

#include "kernels/parallel/compute.h"

struct Square {
  int* to;
  void operator()(int i) const { to[i] = i * i; }
};

int main() {
  using namespace malha;
  static_assert(!kHasOpenMP);
  const auto on_threads = [](void*, int groups, void (*function)(const void*, int), const void* data) {
    std::vector<std::thread> all;
    for (int g = 0; g < groups; ++g) all.emplace_back(function, data, g);
    for (std::thread& one : all) one.join();
  };
  const CallerThreads caller{nullptr, on_threads};
  for (const OpenMP& executor : {OpenMP(4), OpenMP(4, widest_instructions(), &caller)}) {
    std::vector<int> to(1000, -1), also(1000, -1);
    parallel_for(executor, 1000, Square{to.data()}, 0);
    parallel_region(executor, 100, [&](const auto& team) { parallel_pieces(team, 1000, 7, Square{also.data()}); });
    for (int i = 0; i < 1000; ++i)
      if (to[i] != i * i || also[i] != i * i) return std::puts("a wrong number"), 1;
  }
}
PROGRAM
"$compiler" -std=c++20 -O1 -Wall -Wextra -Werror -Wno-psabi -fopenmp-simd -I "$root" "$scratch/main.cpp" -pthread -o "$scratch/main"
"$scratch/main"
