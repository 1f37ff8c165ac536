// SPDX-License-Identifier: Apache-2.0
// Reader of Wavefront OBJ files, polygonal geometry only. It is used instead of tinyobjloader, which silently turns
// malformed and non-finite numbers into 0, drops faces of two corners, and reports no line numbers.
#include <algorithm>
#include <array>
#include <string>

#include "host/mesh/io/mesh_io.h"
#include "host/mesh/io/mesh_scan.h"
#include "host/mesh/polygons.h"
#include "malha/error.h"

namespace malha {
namespace {

// Keywords of lines without points, faces and lines.
constexpr std::array ignored{"vt",        "vn",     "vp",     "p",      "g",        "o",
                             "s",         "mg",     "usemtl", "mtllib", "lod",      "shadow_obj",
                             "trace_obj", "usemap", "maplib", "bevel",  "c_interp", "d_interp"};

class ObjReader {
 public:
  /// `texture`, if it is given, gets the texture coordinates: (u, v, 0), and the faces by their numbers.
  ObjReader(const std::string& file, std::string_view data, Mesh* texture = nullptr)
      : file_(file), scan_(file, data, '#', true), texture_(texture) {}

  Mesh read() {
    while (scan_.next_line()) {
      const std::string_view keyword = scan_.word("");
      if (keyword == "v") {
        mesh_.points.push_back({scan_.real("x"), scan_.real("y"), scan_.real("z")});
      } else if (texture_ && keyword == "vt") {
        const double u = scan_.real("u");
        texture_->points.push_back({u, scan_.has_word() ? scan_.real("v") : 0, 0});
      } else if (keyword == "f") {
        const std::size_t line = scan_.line();
        read_corners("a face of three or more corners", 3, texture_ != nullptr);
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
    std::vector<Quad> in_corners;
    faces_.append_to(mesh_, file_, texture_ ? &in_corners : nullptr);
    if (texture_) add_texture(in_corners);
    return std::move(mesh_);
  }

 private:
  long long count() const { return static_cast<long long>(mesh_.points.size()); }

  std::string allowed_indices() const {
    const std::string n = std::to_string(mesh_.points.size());
    return n == "0" ? "no index, because the file has no vertices" : "1 to " + n + " or -" + n + " to -1";
  }

  void read_corners(const char* wanted, std::size_t fewest, bool with_texture = false) {
    corners_.clear();
    while (scan_.has_word() || corners_.size() < fewest) {
      const std::string_view text = scan_.word(wanted);
      corners_.push_back(corner(text));
      if (with_texture) of_corners_.push_back(texture_of(text));
    }
  }

  // The number of a corner's texture coordinates, from 0; -1: it has none.
  long long texture_of(std::string_view text) const {
    const std::size_t first = text.find('/');
    if (first == std::string_view::npos) return -1;
    const std::string_view number = text.substr(first + 1, text.find('/', first + 1) - first - 1);
    if (number.empty()) return -1;
    long long index = 0;
    const auto count = static_cast<long long>(texture_->points.size());
    if (!to_integer(number, index) || index == 0 || index < -count)
      scan_.refuse_word(text, "a corner with texture coordinates, such as 7/1, of numbers from 1 on, or from -" +
                                  std::to_string(count) + " to -1");
    return index < 0 ? count + index : index - 1;
  }

  void add_texture(const std::vector<Quad>& in_corners) {
    const auto count = static_cast<long long>(texture_->points.size());
    if (count == 0)
      refuse(file_, "", "no texture coordinates", "a file with \"vt\" lines, and a number of one at each corner");
    for (std::size_t f = 0; f < in_corners.size(); ++f) {
      Quad face{-1, -1, -1, -1};
      for (int k = 0; k < 4; ++k) {
        if (in_corners[f][k] < 0) continue;
        const long long number = of_corners_[static_cast<std::size_t>(in_corners[f][k])];
        if (number < 0 || number >= count)
          refuse(
              file_, "face " + std::to_string(f) + " (0-based)",
              number < 0 ? "a corner without texture coordinates" : "texture coordinates " + std::to_string(number + 1),
              "1 to " + std::to_string(count) + " at each corner, such as 7/1");
        face[k] = static_cast<int>(number);
      }
      texture_->faces.push_back(face);
    }
  }

  // A corner is "7", "7/1", "7//3" or "7/1/3"; the first number is that of the point.
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
  Mesh* texture_;
  std::vector<long long> of_corners_;  // texture coordinates of all corners of all faces
  long long largest_ = 0;
};

}  // namespace

Mesh read_obj(const std::string& file, std::string_view data) { return ObjReader(file, data).read(); }

Mesh read_obj_texture(const std::string& file, std::string_view data) {
  Mesh texture;
  ObjReader(file, data, &texture).read();
  return texture;
}

}  // namespace malha
