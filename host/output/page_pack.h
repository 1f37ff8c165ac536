// SPDX-License-Identifier: Apache-2.0
// Compact encoding of numbers as text inside a page.
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

/// Encodes numbers as differences to the number `stride` before (the first ones as they are), in byte planes: the
/// lowest bytes of all numbers, then the next, up to `bytes` of each; deflated (zlib, RFC 1950).
/// host/output/page/data.js decodes it. Throws std::runtime_error if zlib fails (memory).
std::string packed(std::span<const std::uint32_t> numbers, std::size_t stride, int bytes);

/// Positions on a grid of 65536 steps a side over their bounding box.
struct PackedPoints {
  std::array<double, 3> low{}, side{};  // m, of the bounding box
  std::string data;
  /// Returns the largest rounding error of a coordinate, m.
  double rounding() const;
};
PackedPoints packed(const std::vector<Vec3>& points);

/// Values >= 0 in 255 steps up to the largest; infinity counts as the largest float.
struct PackedValues {
  double most = 0;
  std::string data;
};
PackedValues packed(const std::vector<float>& values);

/// Contact points. `ways`: the normal's x, y, z and the distance over `far` of each, in 127 steps a sign. The contact
/// point lies that distance from the particle against the normal.
struct PackedContacts {
  std::size_t count = 0;
  double far = 0;  // m
  std::string particles, ways;
};
PackedContacts packed(const std::vector<ContactPoint>& touches);

/// Forces on pins, N; components are clamped to 1e30.
struct PackedForces {
  std::size_t count = 0;
  std::string particles;
  PackedPoints forces;
};
PackedForces packed(const std::vector<PinForce>& all);

/// Returns the base64 encoding (RFC 4648).
std::string base64(const std::string& bytes);

}  // namespace malha
