// SPDX-License-Identifier: Apache-2.0
// Reader of STL files, ascii and binary. Their triangles have three corners of their own each; corners with exactly the
// same position become one point.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "host/base/spelling_suggestion.h"
#include "host/mesh/first_equal.h"
#include "host/mesh/io/mesh_io.h"
#include "host/mesh/io/mesh_scan.h"
#include "malha/error.h"

namespace malha {
namespace {

constexpr std::size_t header_bytes = 84, triangle_bytes = 50;  // the header ends in the number of triangles

/// Reads a keyword in lower case. Some programs write it in upper case, or "end loop" as two words.
std::string read_keyword(TextScanner& scan, const char* wanted) {
  std::string keyword = lower(std::string(scan.word(wanted)));
  if (keyword == "end" && scan.has_word()) keyword += lower(std::string(scan.word(wanted)));
  return keyword;
}

void expect_line(TextScanner& scan, std::initializer_list<const char*> words) {
  if (!scan.next_line()) scan.refuse_end(*words.begin());
  for (const char* expected : words) {
    const std::string found = read_keyword(scan, expected);
    if (found != expected) scan.refuse_word(found, expected);
  }
}

std::vector<Vec3> ascii_corners(const std::string& file, std::string_view data) {
  TextScanner scan(file, data);
  std::vector<Vec3> corners;
  bool inside = false;
  while (scan.next_line()) {
    const std::string keyword = read_keyword(scan, "");
    if (keyword == (inside ? "endsolid" : "solid")) {
      inside = !inside;
    } else if (inside && keyword == "facet") {  // the normal that follows is redundant
      expect_line(scan, {"outer", "loop"});
      for (int k = 0; k < 3; ++k) {
        expect_line(scan, {"vertex"});
        corners.push_back({scan.real("x"), scan.real("y"), scan.real("z")});
        scan.require_end_of_line("vertex x y z");
      }
      expect_line(scan, {"endloop"});
      expect_line(scan, {"endfacet"});
    } else {
      scan.refuse_word(keyword, inside ? "facet or endsolid" : "solid");
    }
  }
  if (inside) scan.refuse_end("facet or endsolid");
  return corners;
}

std::vector<Vec3> binary_corners(const std::string& file, std::string_view data) {
  ByteScanner scan(file, data, 0, std::endian::little);
  if (data.size() < header_bytes) scan.refuse_end("a binary header of 84 bytes, or \"solid\" (ascii)");
  scan.skip(header_bytes - 4);
  const std::size_t count = scan.get<std::uint32_t>();
  if (data.size() != header_bytes + count * triangle_bytes) {
    refuse(file, "byte 80", std::to_string(count) + " triangles in a file of " + std::to_string(data.size()) + " bytes",
           std::to_string(header_bytes + count * triangle_bytes) + " bytes for this number");
  }
  std::vector<Vec3> corners;
  corners.reserve(3 * count);
  for (std::size_t i = 0; i < count; ++i) {
    scan.skip(12);  // the normal
    for (int k = 0; k < 3; ++k) {
      const std::size_t byte = scan.offset();
      Vec3 corner;
      for (double& value : corner) value = scan.get<float>();
      if (!std::ranges::all_of(corner, [](double value) { return std::isfinite(value); })) {
        refuse(file, "byte " + std::to_string(byte) + " (triangle " + std::to_string(i) + ", 0-based)",
               "a NaN or infinite coordinate", "finite numbers");
      }
      corners.push_back(corner);
    }
    scan.skip(2);  // "attributes"
  }
  return corners;
}

// Binary files may start with "solid" too; then their size, or a zero byte, shows that they are binary.
bool is_ascii(std::string_view data) {
  TextScanner start("", data.substr(0, header_bytes));
  if (!start.next_line() || lower(std::string(start.word(""))) != "solid") return false;
  if (data.find('\0') != std::string_view::npos) return false;
  if (data.size() < header_bytes) return true;
  ByteScanner scan("", data, header_bytes - 4, std::endian::little);
  return data.size() != header_bytes + scan.get<std::uint32_t>() * triangle_bytes;
}

}  // namespace

Mesh read_stl(const std::string& file, std::string_view data) {
  const std::vector<Vec3> corners = is_ascii(data) ? ascii_corners(file, data) : binary_corners(file, data);
  const std::vector<int> first = first_at_same_position(corners);
  Mesh mesh;
  std::vector<int> point(corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (first[i] == static_cast<int>(i)) {
      point[i] = static_cast<int>(mesh.points.size());
      mesh.points.push_back(corners[i]);
    } else {
      point[i] = point[first[i]];
    }
  }
  for (std::size_t i = 0; i < corners.size(); i += 3) mesh.faces.push_back({point[i], point[i + 1], point[i + 2], -1});
  return mesh;
}

}  // namespace malha
