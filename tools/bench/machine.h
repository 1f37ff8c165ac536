// SPDX-License-Identifier: Apache-2.0
// Speed of this machine, measured: memory bandwidth, and throughput of square roots and divisions.
#pragma once
#include <cstddef>

namespace malha::bench {

/// Bandwidth of the STREAM triad a = b + s c (McCalpin 1995) in float, in GB/s: two arrays read and one written, best
/// of several rounds. `bytes` is the size of the three arrays together; each thread works on its own part of them.
double triad_gb_per_s(std::size_t bytes, int threads);

/// Bandwidth of reading several arrays at once (stream.h), in GB/s, best of several rounds.
double read_gb_per_s(std::size_t bytes, int threads);

/// Time of one square root and one division in float on one thread, in ns: throughput of independent packs in
/// registers, best of several rounds.
double root_and_quotient_ns();

/// Size of the largest cache of a core, which it may share with others; 0: unknown.
double cache_bytes();

/// A working set larger than any cache, for the triad from memory.
inline constexpr std::size_t kMemoryBytes = std::size_t(384) << 20;

}  // namespace malha::bench
