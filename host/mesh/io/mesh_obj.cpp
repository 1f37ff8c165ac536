// SPDX-License-Identifier: Apache-2.0
// Reader of Wavefront OBJ files, polygonal geometry only. It is used instead of tinyobjloader, which silently turns
// malformed and non-finite numbers into 0, drops faces of two corners, and reports no line numbers.
#include <algorithm>
#include <array>
#include <string>

#include "host/mesh/io/mesh_io.h"
#include "host/mesh/io/mesh_scan.h"
#include "host/mesh/polygons.h"

namespace malha {
namespace {

// Keywords of lines without points, faces and lines.
constexpr std::array ignored{"vt",        "vn",     "vp",     "p",      "g",        "o",
                             "s",         "mg",     "usemtl", "mtllib", "lod",      "shadow_obj",
                             "trace_obj", "usemap", "maplib", "bevel",  "c_interp", "d_interp"};

class ObjReader {
 public:
  ObjReader(const std::string& file, std::string_view data) : file_(file), scan_(file, data, '#', true) {}

  Mesh read() {
    while (scan_.next_line()) {
      const std::string_view keyword = scan_.word("");
      if (keyword == "v") {
        mesh_.points.push_back({scan_.real("x"), scan_.real("y"), scan_.real("z")});
      } else if (keyword == "f") {
        const std::size_t line = scan_.line();
        read_corners("a face of three or more corners", 3);
        faces_.add(corners_, line);
      } else if (keyword == "l") {
        read_corners("a line of two or more corners", 2);
        for (std::size_t i = 1; i < corners_.size(); ++i) mesh_.lines.push_back({corners_[i - 1], corners_[i]});
      } else if (std::ranges::find(ignored, keyword) == ignored.end()) {
        scan_.refuse_word(keyword, "v, f, l, or an ignored keyword (vt, vn, g, o, s, usemtl ...)");
      }
    }
    // A positive index may refer to a later vertex, so that it can be checked only at the end.
    if (largest_ > count()) furthest_.refuse_here("vertex " + std::to_string(largest_), allowed_indices());
    faces_.append_to(mesh_, file_);
    return std::move(mesh_);
  }

 private:
  long long count() const { return static_cast<long long>(mesh_.points.size()); }

  std::string allowed_indices() const {
    const std::string n = std::to_string(mesh_.points.size());
    return n == "0" ? "no index, because the file has no vertices" : "1 to " + n + " or -" + n + " to -1";
  }

  void read_corners(const char* wanted, std::size_t fewest) {
    corners_.clear();
    while (scan_.has_word() || corners_.size() < fewest) corners_.push_back(corner(scan_.word(wanted)));
  }

  // A corner is "7", "7/1", "7//3" or "7/1/3"; only the first number, that of the point, is used.
  int corner(std::string_view text) {
    long long index = 0;
    if (!to_integer(text.substr(0, text.find('/')), index)) {
      scan_.refuse_word(text, "a corner such as 7, 7/1, 7//3 or -1");
    }
    if (index == 0 || index < -count()) scan_.refuse_here("vertex " + std::to_string(index), allowed_indices());
    if (index < 0) return static_cast<int>(count() + index);
    if (index > largest_) {
      largest_ = index;
      if (index > count()) furthest_ = scan_;
    }
    return static_cast<int>(index - 1);
  }

  std::string file_;
  TextScanner scan_;
  TextScanner furthest_{"", ""};  // position in the text of the largest index so far, if it refers to a later vertex
  Mesh mesh_;
  PolygonList faces_;
  std::vector<int> corners_;
  long long largest_ = 0;
};

}  // namespace

Mesh read_obj(const std::string& file, std::string_view data) { return ObjReader(file, data).read(); }

}  // namespace malha
