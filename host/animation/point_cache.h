// SPDX-License-Identifier: Apache-2.0
// PointCache2, a file of one mesh's points over time: a header, then samples x points x 3 floats, all little-endian.
// Sample i is frame (first_frame + i frames_per_sample).
#pragma once
#include <cstdint>

namespace malha {

struct PointCacheHeader {
  char signature[12];  // kPointCache
  std::int32_t version, points;
  float first_frame, frames_per_sample;
  std::int32_t samples;
};
static_assert(sizeof(PointCacheHeader) == 32);
inline constexpr char kPointCache[12] = "POINTCACHE2";

}  // namespace malha
