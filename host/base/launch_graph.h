// SPDX-License-Identifier: Apache-2.0
// Launch graphs: a sequence of launches that is the same in every step is recorded once and replayed, by executors that
// can (CUDA graphs).
#pragma once
#include <string>

#include "kernels/parallel/compute.h"

namespace malha {

/// Recorded launches of an executor; those of the host record nothing.
template <class Executor>
struct Recording {};

/// Key from the bytes of numbers and addresses.
template <class... Values>
std::string key_from(const Values&... values) {
  std::string bytes;
  (bytes.append(reinterpret_cast<const char*>(&values), sizeof values), ...);
  return bytes;
}

/// Runs or replays work(), which must only launch kernels, and the same ones whenever key() is the same: the key has
/// all that the launches depend on. Nested repeated() calls become part of the recording.
template <class Executor, class Key, class Work>
void repeated(const Executor& /*executor*/, Recording<Executor>& /*recording*/, const Key& /*key*/, const Work& work) {
  work();
}

/// The same for a parallel_region().
template <class Executor, class Key, class Work>
void repeated_region(const Executor& executor, int width, Recording<Executor>& /*recording*/, const Key& /*key*/,
                     const Work& work) {
  parallel_region(executor, width, work);
}

}  // namespace malha
