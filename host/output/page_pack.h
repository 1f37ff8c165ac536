// SPDX-License-Identifier: Apache-2.0
// Numbers as text inside a page: small, and quick to read for a browser.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "host/fields/contacts.h"
#include "host/fields/forces.h"
#include "malha/mesh.h"

namespace malha {

/// Differences of each number to the one `stride` before it (the first ones as they are), byte by byte: first the
/// lowest bytes of all, then the next, `bytes` of each number; deflated (zlib, RFC 1950). host/output/page/data.js
/// reads it. Throws std::runtime_error where zlib fails (memory).
std::string packed(std::span<const std::uint32_t> numbers, std::size_t stride, int bytes);

/// Places on a grid of 65536 steps a side over their box, packed.
struct PackedPoints {
  std::array<double, 3> low{}, side{};  // m, of the box
  std::string data;
  /// How far rounding may move a coordinate, m.
  double rounding() const;
};
PackedPoints packed(const std::vector<Vec3>& points);

/// Values from 0 on, in 255 steps to the largest, packed; what is infinite counts as the largest float.
struct PackedValues {
  double most = 0;
  std::string data;
};
PackedValues packed(const std::vector<float>& values);

/// Who touches, packed. `ways`: of each the normal's x, y, z and the distance over `far`, each in 127 steps a sign. The
/// point that is touched lies that distance behind the particle.
struct PackedTouches {
  std::size_t count = 0;
  double far = 0;  // m
  std::string particles, ways;
};
PackedTouches packed(const std::vector<Touch>& touches);

/// Of pins, N, packed; no part of a force counts as more than 1e30.
struct PackedForces {
  std::size_t count = 0;
  std::string particles;
  PackedPoints forces;
};
PackedForces packed(const std::vector<PinForce>& all);

/// RFC 4648.
std::string base64(const std::string& bytes);

}  // namespace malha
