// SPDX-License-Identifier: Apache-2.0
// What this machine can do, measured: how fast it moves numbers and how fast it makes roots and quotients.
#pragma once
#include <cstddef>

namespace malha::bench {

/// The STREAM triad a = b + s c (McCalpin 1995) in float: GB/s of the bytes that it names (two read, one written),
/// best of several rounds. `bytes` is the size of the three arrays together; each thread has its own part of them.
double triad_gb_per_s(std::size_t bytes, int threads);

/// GB/s of reading alone, several arrays at once (stream.h), best of several rounds.
double read_gb_per_s(std::size_t bytes, int threads);

/// ns for one square root and one division in float on one thread, at the throughput of independent packs and with no
/// traffic beyond L1; best of several rounds.
double root_and_quotient_ns();

/// Of the largest cache of a core, which it may share with others; 0: unknown.
double cache_bytes();

/// More than any cache holds, for the triad from memory.
inline constexpr std::size_t kMemoryBytes = std::size_t(384) << 20;

}  // namespace malha::bench
