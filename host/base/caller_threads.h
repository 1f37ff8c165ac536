// SPDX-License-Identifier: Apache-2.0
// Threads of the program that uses malha, from the function that it gives.
#pragma once
#include <functional>

#include "kernels/parallel/compute.h"
#include "malha/parallel_for.h"

namespace malha {

/// Launches call `parallel_for`, which must stay where it is as long as they do. No call allocates.
inline CallerThreads caller_threads(ParallelFor& parallel_for) {
  const auto call = [](void* context, int groups, void (*function)(const void*, int), const void* data) {
    const auto run = [function, data](int group) { function(data, group); };
    (*static_cast<ParallelFor*>(context))(groups, std::cref(run));
  };
  return {&parallel_for, call};
}

}  // namespace malha
