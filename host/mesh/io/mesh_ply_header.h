// SPDX-License-Identifier: Apache-2.0
// Header of PLY files: the format of the body, its elements and their properties.
#pragma once
#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "host/mesh/io/mesh_scan.h"

namespace malha::ply {

enum class Type { Int8, Uint8, Int16, Uint16, Int32, Uint32, Float32, Float64 };

std::size_t size_of(Type type);  ///< bytes

/// Use of a property: x, y, z (0, 1, 2), the corners of a face, or skipped.
enum Role { skipped = -1, corners = 3 };

struct Property {
  std::string name;
  Type type = Type::Int8;
  std::optional<Type> count;  // type of the count of a list; none: a scalar
  int role = skipped;
};

/// A sequence of items with the same properties, such as vertices or faces.
struct Element {
  std::string name;
  long long count = 0;
  std::vector<Property> properties;
  std::string place;  // of its count in the header, for messages

  bool has(int role) const { return std::ranges::find(properties, role, &Property::role) != properties.end(); }
};

struct Header {
  std::string format;  // ascii, binary_little_endian or binary_big_endian
  std::vector<Element> elements;
  long long vertices = 0;  // count of the element "vertex"
};

/// Reads the header up to and including the line end_header. The result has one element "vertex" with x, y, z, and at
/// most one element "face", with a list of corners. Throws InputError.
Header read_header(const std::string& file, TextScanner& scan);

}  // namespace malha::ply
