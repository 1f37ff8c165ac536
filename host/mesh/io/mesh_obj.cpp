// SPDX-License-Identifier: Apache-2.0
// Reader of Wavefront OBJ files: polygons and lines, their texture coordinates and names. It is used instead of
// tinyobjloader, which silently turns malformed and non-finite numbers into 0, drops faces of two corners, and reports
// no line numbers.
#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <unordered_map>
#include <utility>

#include "host/mesh/io/mesh_io.h"
#include "host/mesh/io/mesh_scan.h"
#include "malha/error.h"

namespace malha {
namespace {

// Keywords of lines without points, faces and lines. Those of attributes are read where these are asked for.
constexpr std::array ignored{"vt",        "vn",     "vp",     "p",      "g",        "o",
                             "s",         "mg",     "usemtl", "mtllib", "lod",      "shadow_obj",
                             "trace_obj", "usemap", "maplib", "bevel",  "c_interp", "d_interp"};

/// Names in the order of their first use, and the one that holds for what follows.
class CurrentName {
 public:
  explicit CurrentName(std::vector<std::string>& names) : names_(names) {}

  int index() const { return index_; }
  void set(std::string_view name) {
    index_ = -1;
    if (name.empty()) return;
    const auto [known, is_new] = index_of_.try_emplace(std::string(name), static_cast<int>(names_.size()));
    if (is_new) names_.emplace_back(name);
    index_ = known->second;
  }

 private:
  std::vector<std::string>& names_;
  std::unordered_map<std::string, int> index_of_;
  int index_ = -1;
};

class ObjReader {
 public:
  ObjReader(const std::string& file, std::string_view data, Attributes attributes)
      : file_(file), scan_(file, data, '#', true), attributes_(attributes) {}

  FileMesh read() {
    while (scan_.next_line()) {
      const std::string_view keyword = scan_.word("");
      if (keyword == "v") {
        mesh_.points.push_back({scan_.real("x"), scan_.real("y"), scan_.real("z")});
        if (reads_names()) polygons_.vertex_object.push_back(object_.index()), read_colour();
      } else if (attributes_ != Attributes::None && keyword == "vt") {
        const double u = scan_.real("u");
        polygons_.uv.push_back({u, scan_.has_word() ? scan_.real("v") : 0});
      } else if (keyword == "f") {
        read_corners("a face of three or more corners", 3, attributes_ != Attributes::None);
        polygons_.line.push_back(scan_.line());
        polygons_.add(corners_);
        if (reads_names()) {
          polygons_.object.push_back(object_.index()), polygons_.group.push_back(group_.index());
          polygons_.material.push_back(material_.index());
        }
      } else if (keyword == "l") {
        read_corners("a line of two or more corners", 2, false);
        for (std::size_t i = 1; i < corners_.size(); ++i) {
          mesh_.lines.push_back({corners_[i - 1], corners_[i]});
          if (!reads_names()) continue;
          polygons_.line_object.push_back(object_.index()), polygons_.line_group.push_back(group_.index());
        }
      } else if (reads_names() && keyword == "o") {
        object_.set(scan_.rest_of_line());
      } else if (reads_names() && keyword == "g") {
        group_.set(scan_.rest_of_line());
      } else if (reads_names() && keyword == "usemtl") {
        material_.set(scan_.rest_of_line());
      } else if (reads_names() && keyword == "mtllib") {
        polygons_.material_files.emplace_back(scan_.rest_of_line());
      } else if (std::ranges::find(ignored, keyword) == ignored.end()) {
        scan_.refuse_word(keyword, "v, f, l, or an ignored keyword (vt, vn, g, o, s, usemtl ...)");
      }
    }
    // A positive index may refer to a later vertex, so that it can be checked only at the end.
    if (largest_ > count()) furthest_.refuse_here("vertex " + std::to_string(largest_), allowed_indices());
    if (const auto uv = static_cast<long long>(polygons_.uv.size()); largest_texture_ > uv)
      furthest_texture_.refuse_here("texture coordinates " + std::to_string(largest_texture_),
                                    uv == 0 ? "no index, because the file has no texture coordinates"
                                            : "1 to " + std::to_string(uv) + " or -" + std::to_string(uv) + " to -1");
    if (!colours_.empty()) colours_.resize(mesh_.points.size(), {1, 1, 1, 1});
    return {std::move(mesh_), std::move(polygons_), std::move(colours_)};
  }

 private:
  bool reads_names() const { return attributes_ == Attributes::All; }
  long long count() const { return static_cast<long long>(mesh_.points.size()); }

  std::string allowed_indices() const {
    const std::string n = std::to_string(mesh_.points.size());
    return n == "0" ? "no index, because the file has no vertices" : "1 to " + n + " or -" + n + " to -1";
  }

  /// Three numbers after x, y and z are a colour, as Blender and MeshLab write it; one is the weight of a rational
  /// curve.
  void read_colour() {
    std::array<float, 4> colour{1, 1, 1, 1};
    TextScanner ahead = scan_;
    int numbers = 0;
    for (; numbers < 3 && ahead.has_word(); ++numbers)
      colour[static_cast<std::size_t>(numbers)] = static_cast<float>(ahead.real("a channel of a colour"));
    if (numbers < 3) return;
    colours_.resize(mesh_.points.size() - 1, {1, 1, 1, 1});
    colours_.push_back(colour);
  }

  void read_corners(const char* wanted, std::size_t fewest, bool with_texture) {
    corners_.clear();
    while (scan_.has_word() || corners_.size() < fewest) {
      const std::string_view text = scan_.word(wanted);
      corners_.push_back(corner(text));
      if (with_texture) polygons_.corner_uv.push_back(texture_of(text));
    }
  }

  // The number of a corner's texture coordinates, from 0; -1: it has none.
  int texture_of(std::string_view text) {
    const std::size_t first = text.find('/');
    if (first == std::string_view::npos) return -1;
    const std::string_view number = text.substr(first + 1, text.find('/', first + 1) - first - 1);
    if (number.empty()) return -1;
    long long index = 0;
    const auto count = static_cast<long long>(polygons_.uv.size());
    if (!to_integer(number, index) || index == 0 || index < -count || index > most_indices)
      scan_.refuse_word(text, "a corner with texture coordinates, such as 7/1, of numbers from 1 on, or from -" +
                                  std::to_string(count) + " to -1");
    if (index > largest_texture_) {
      largest_texture_ = index;
      if (index > count) furthest_texture_ = scan_;
    }
    return static_cast<int>(index < 0 ? count + index : index - 1);
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

  static constexpr long long most_indices = std::numeric_limits<int>::max();

  std::string file_;
  TextScanner scan_;
  Attributes attributes_;
  // Positions in the text of the largest indices so far, where they refer to later items.
  TextScanner furthest_{"", ""}, furthest_texture_{"", ""};
  Mesh mesh_;
  Polygons polygons_;
  CurrentName object_{polygons_.objects}, group_{polygons_.groups}, material_{polygons_.materials};
  std::vector<std::array<float, 4>> colours_;
  std::vector<int> corners_;
  long long largest_ = 0, largest_texture_ = 0;
};

}  // namespace

FileMesh read_obj(const std::string& file, std::string_view data, Attributes attributes) {
  return ObjReader(file, data, attributes).read();
}

}  // namespace malha
