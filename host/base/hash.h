// SPDX-License-Identifier: Apache-2.0
// Hash of bytes.
#pragma once
#include <cstddef>
#include <cstdint>

namespace malha {

/// FNV-1a, 64 bits; `hash` continues an earlier one.
inline std::uint64_t hash_bytes(const void* data, std::size_t size, std::uint64_t hash = 0xcbf29ce484222325) {
  const auto* byte = static_cast<const unsigned char*>(data);
  for (std::size_t i = 0; i < size; ++i) hash = (hash ^ byte[i]) * 0x100000001b3;
  return hash;
}

}  // namespace malha
