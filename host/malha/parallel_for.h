// SPDX-License-Identifier: Apache-2.0
// Function by which a program runs the work of malha on its own threads.
#pragma once
#include <functional>

namespace malha {

/// parallel_for(groups, function) calls function(0) ... function(groups - 1), each once, in any order and on any
/// threads, and returns when all have returned. The groups neither wait for each other nor throw. They may run one
/// after the other, and the calling thread may run some. It is called by the thread that calls Simulation's members, so
/// that simulations that step on several threads may share one function. It must not throw, and `function` is not used
/// after it has returned.
using ParallelFor = std::function<void(int groups, const std::function<void(int group)>& function)>;

}  // namespace malha
