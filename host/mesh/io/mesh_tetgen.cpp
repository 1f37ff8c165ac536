// SPDX-License-Identifier: Apache-2.0
// Reader of TetGen files: STEM.node (points) and STEM.ele (tetrahedra). Items are numbered from 0 or from 1, like the
// first point; attributes and boundary markers are skipped.
#include <string>

#include "host/mesh/io/mesh_io.h"
#include "host/mesh/io/mesh_scan.h"

namespace malha {
namespace {

/// Advances to the next line, which must begin with the number of item i of n: base + i.
void next_item(TextScanner& scan, const char* item, long long base, long long i, long long n) {
  if (!scan.next_line())
    scan.refuse_end(item + (" " + std::to_string(base + i)) + ", as there are " + std::to_string(n));
  const long long number = scan.integer("its number");
  if (number != base + i)
    scan.refuse_here(std::to_string(number) + " as the number of a " + item,
                     std::to_string(base + i) + ": numbers in order, from " + std::to_string(base));
}

/// Skips this many numbers.
void skip(TextScanner& scan, long long numbers, const char* what) {
  for (long long i = 0; i < numbers; ++i) scan.real(what);
}

/// Reads an integer in [0, most], or returns `missing` at the end of the line.
long long small_integer(TextScanner& scan, const char* wanted, long long most, long long missing) {
  if (!scan.has_word()) return missing;
  const long long value = scan.integer(wanted);
  if (value < 0 || value > most)
    scan.refuse_here(std::to_string(value) + " as " + wanted, "0 to " + std::to_string(most));
  return value;
}

}  // namespace

Mesh read_tetgen(const std::string& node_file, std::string_view node_data, const std::string& ele_file,
                 std::string_view ele_data) {
  constexpr long long most_attributes = 1000;
  Mesh mesh;
  TextScanner node(node_file, node_data, '#');
  if (!node.next_line()) node.refuse_end("the number of points");
  const long long points = node.count("the number of points", 8);  // "0 0 0 0\n"
  const long long dimension = small_integer(node, "the dimension", 3, 3);
  if (dimension != 3) node.refuse_here(std::to_string(dimension) + " as the dimension", "3");
  const long long attributes = small_integer(node, "the number of attributes", most_attributes, 0);
  const long long markers = small_integer(node, "the number of boundary markers", 1, 0);
  node.require_end_of_line("the numbers of points, dimensions, attributes and markers");
  long long base = 0;
  mesh.points.reserve(static_cast<std::size_t>(points));
  for (long long i = 0; i < points; ++i) {
    if (i == 0) {
      if (!node.next_line()) node.refuse_end("point 0 or 1, as there are " + std::to_string(points));
      base = node.integer("the number of a point");
      if (base != 0 && base != 1)
        node.refuse_here(std::to_string(base) + " as the number of the first point", "0 or 1");
    } else {
      next_item(node, "point", base, i, points);
    }
    mesh.points.push_back({node.real("x"), node.real("y"), node.real("z")});
    skip(node, attributes, "an attribute");
    skip(node, markers, "a boundary marker");
    node.require_end_of_line("a point's number, x, y, z, attributes and marker");
  }
  if (node.next_line()) node.refuse_word(node.word(""), "as many points as the first line says");

  TextScanner ele(ele_file, ele_data, '#');
  if (!ele.next_line()) ele.refuse_end("the number of tetrahedra");
  const long long count = ele.count("the number of tetrahedra", 10);  // "0 0 1 2 3\n"
  const long long corners = small_integer(ele, "the number of corners", 10, 4);
  if (corners != 4)
    ele.refuse_here("tetrahedra of " + std::to_string(corners) + " points", "4 (of first order: tetgen without -o2)");
  const long long regions = small_integer(ele, "the number of attributes", most_attributes, 0);
  ele.require_end_of_line("the numbers of tetrahedra, corners and attributes");
  mesh.tetrahedra.reserve(static_cast<std::size_t>(count));
  for (long long i = 0; i < count; ++i) {
    next_item(ele, "tetrahedron", base, i, count);
    Tetrahedron& t = mesh.tetrahedra.emplace_back();
    for (int& corner : t) {
      const long long index = ele.integer("a corner");
      if (index < base || index >= base + points)
        ele.refuse_here("point " + std::to_string(index),
                        std::to_string(base) + " to " + std::to_string(base + points - 1));
      corner = static_cast<int>(index - base);
    }
    skip(ele, regions, "an attribute");
    ele.require_end_of_line("a tetrahedron's number, corners and attributes");
  }
  if (ele.next_line()) ele.refuse_word(ele.word(""), "as many tetrahedra as the first line says");
  if (mesh.tetrahedra.empty()) ele.refuse_here("a mesh without tetrahedra", "one or more");
  return mesh;
}

}  // namespace malha
