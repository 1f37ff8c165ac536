// SPDX-License-Identifier: Apache-2.0
// Reader of Medit's .mesh files (INRIA). They consist of keywords, each with a count and that number of items; words
// and numbers are separated by blanks or line ends. Indices start at 1, and every item ends with a reference, which is
// ignored.
#include <algorithm>
#include <string>

#include "host/mesh/io/mesh_io.h"
#include "host/mesh/io/mesh_scan.h"

namespace malha {
namespace {

struct Skipped {
  std::string_view keyword;
  int words;  // number of words of an item
};
constexpr Skipped skipped[] = {{"Edges", 3},
                               {"Corners", 1},
                               {"Ridges", 1},
                               {"RequiredVertices", 1},
                               {"RequiredEdges", 1},
                               {"RequiredTriangles", 1},
                               {"Normals", 3},
                               {"NormalAtVertices", 2},
                               {"NormalAtTriangleVertices", 3},
                               {"Tangents", 3},
                               {"TangentAtVertices", 2}};

class MeditReader {
 public:
  MeditReader(const std::string& file, std::string_view data) : scan_(file, data, '#') {}

  Mesh read() {
    const std::string header = "a header: MeshVersionFormatted 1 or 2";
    if (!scan_.find_word()) scan_.refuse_end(header);
    if (const auto word = scan_.word(""); word != "MeshVersionFormatted") scan_.refuse_word(word, header);
    const long long version = integer("the version of the format");
    if (version < 1 || version > 4) scan_.refuse_here(std::to_string(version) + " as the version", "1 to 4");
    bool dimension = false, ended = false;
    while (scan_.find_word()) {
      const std::string_view keyword = scan_.word("");
      if (ended) scan_.refuse_word(keyword, "nothing after End");
      if (keyword == "Dimension") {
        if (const long long d = integer("the dimension"); d != 3)
          scan_.refuse_here(std::to_string(d) + " as the dimension", "3");
        dimension = true;
        continue;
      }
      if (!dimension) scan_.refuse_word(keyword, "Dimension 3 before it");
      if (keyword == "End") {
        ended = true;
      } else {
        read_section(keyword);
      }
    }
    return std::move(mesh_);
  }

 private:
  void read_section(std::string_view keyword) {
    if (keyword == "Vertices") return read_points();
    if (keyword == "Tetrahedra") return read_items<4>("tetrahedron", mesh_.tetrahedra);
    if (keyword == "Triangles") {
      std::vector<Triangle> triangles;
      read_items<3>("triangle", triangles);
      for (const auto& [a, b, c] : triangles) mesh_.faces.push_back({a, b, c, -1});
      return;
    }
    if (keyword == "Quadrilaterals") return read_items<4>("quadrilateral", mesh_.faces);
    if (keyword == "Hexahedra" || keyword == "Prisms" || keyword == "Pyramids") {
      if (integer("their number") > 0) scan_.refuse_here(std::string(keyword), "Tetrahedra only");
      return;
    }
    const auto known = std::ranges::find(skipped, keyword, &Skipped::keyword);
    if (known == std::end(skipped))
      scan_.refuse_word(keyword,
                        "Vertices, Tetrahedra, Triangles, Quadrilaterals, End, or an ignored keyword (Edges, Corners, "
                        "Ridges, Required..., Normals ...)");
    const long long items = count("their number", 2 * known->words);
    for (long long i = 0; i < items * known->words; ++i) {
      if (!scan_.find_word()) scan_.refuse_end("the rest of " + std::string(known->keyword));
      scan_.real("a number");
    }
  }

  void read_points() {
    if (!mesh_.points.empty()) scan_.refuse_here("a second list Vertices", "one");
    const long long points = count("the number of vertices", 8);
    mesh_.points.reserve(static_cast<std::size_t>(points));
    for (long long i = 0; i < points; ++i) {
      Vec3& point = mesh_.points.emplace_back();
      for (int axis = 0; axis < 3; ++axis) {
        find("vertex", i, points);
        point[axis] = scan_.real(axis == 0 ? "x" : axis == 1 ? "y" : "z");
      }
      find("vertex", i, points);
      scan_.integer("a reference");
    }
  }

  template <int corners, class Item>
  void read_items(const char* what, std::vector<Item>& list) {
    const long long items = count("their number", 2 * corners + 2);
    const auto points = static_cast<long long>(mesh_.points.size());
    for (long long i = 0; i < items; ++i) {
      Item& item = list.emplace_back();
      for (int k = 0; k < corners; ++k) {
        find(what, i, items);
        const long long index = scan_.integer("a corner");
        if (index < 1 || index > points)
          scan_.refuse_here("vertex " + std::to_string(index), points > 0
                                                                   ? "1 to " + std::to_string(points)
                                                                   : "Vertices before the elements that use them");
        item[k] = static_cast<int>(index - 1);
      }
      find(what, i, items);
      scan_.integer("a reference");
    }
  }

  void find(const char* what, long long i, long long n) {
    if (!scan_.find_word()) scan_.refuse_end(what + (" " + std::to_string(i + 1)) + " of " + std::to_string(n));
  }
  long long integer(const char* wanted) {
    if (!scan_.find_word()) scan_.refuse_end(wanted);
    return scan_.integer(wanted);
  }
  long long count(const char* wanted, long long bytes_each) {
    if (!scan_.find_word()) scan_.refuse_end(wanted);
    return scan_.count(wanted, bytes_each);
  }

  TextScanner scan_;
  Mesh mesh_;
};

}  // namespace

Mesh read_medit(const std::string& file, std::string_view data) { return MeditReader(file, data).read(); }

}  // namespace malha
