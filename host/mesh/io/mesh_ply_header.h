// SPDX-License-Identifier: Apache-2.0
// The header of a PLY file: which elements of which properties follow, in which format.
#pragma once
#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "host/mesh/io/mesh_scan.h"

namespace malha::ply {

enum class Type { Int8, Uint8, Int16, Uint16, Int32, Uint32, Float32, Float64 };

std::size_t size_of(Type type);  ///< bytes

/// What a property is to us: x, y, z (0, 1, 2), the corners of a face, or nothing.
enum Role { skipped = -1, corners = 3 };

struct Property {
  std::string name;
  Type type = Type::Int8;
  std::optional<Type> count;  // of a list
  int role = skipped;
};

/// A kind of items, all alike: vertices, faces ...
struct Element {
  std::string name;
  long long count = 0;
  std::vector<Property> properties;
  std::string place;  // of its count, in the header

  bool has(int role) const { return std::ranges::find(properties, role, &Property::role) != properties.end(); }
};

struct Header {
  std::string format;  // ascii, binary_little_endian or binary_big_endian
  std::vector<Element> elements;
  long long vertices = 0;  // the count of the one element "vertex"
};

/// Reads up to and including the line end_header; there is one element "vertex" with x, y, z then, and at most one
/// "face", with a list of corners. Throws InputError.
Header read_header(const std::string& file, TextScanner& scan);

}  // namespace malha::ply
