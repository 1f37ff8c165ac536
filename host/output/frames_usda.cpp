// SPDX-License-Identifier: Apache-2.0
// USD text writer: one file of the bodies, the environment and all frames, for Houdini, Blender, Omniverse and others
// (OpenUSD: "USD File Formats", "UsdGeom", "UsdShade"). It is written without the library, which Debian does not have.
// A mesh of frames is a Mesh with the places of its points at the time of each frame. Lines are a BasisCurves, loose
// points a Points, beside it.
#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <set>

#include "host/attachments/object_motion.h"
#include "host/base/build_info.h"
#include "host/base/file.h"
#include "host/base/mapped_file.h"
#include "host/output/frame_formats.h"
#include "host/output/frame_part.h"
#include "host/output/materials.h"
#include "host/render/picture.h"
#include "malha/text.h"

namespace malha {

namespace fs = std::filesystem;

namespace {

/// The name as an identifier that is not among `names`, to which it is added.
std::string identifier(const std::string& name, std::set<std::string>& names) {
  std::string made;
  for (const char letter : name) {
    const bool fits = (letter >= 'a' && letter <= 'z') || (letter >= 'A' && letter <= 'Z') ||
                      (letter >= '0' && letter <= '9') || letter == '_';
    made += fits ? letter : '_';
  }
  if (made.empty() || (made[0] >= '0' && made[0] <= '9')) made = "_" + made;
  std::string unique = made;
  for (int k = 1; !names.insert(unique).second; ++k) unique = made + "_" + std::to_string(k);
  return unique;
}

std::string quoted_text(const std::string& text) {
  std::string all = "\"";
  for (const char letter : text) {
    if (letter == '"' || letter == '\\') all += '\\';
    all += letter;
  }
  return all + "\"";
}

template <class List>
std::string list_of(const List& list) {
  std::string text = "[";
  for (const auto& item : list) {
    if (text.size() > 1) text += ", ";
    append_number(text, item);
  }
  return text + "]";
}

template <std::size_t N, class T>
void append_tuple(std::string& text, const std::array<T, N>& x) {
  for (std::size_t k = 0; k < N; ++k) text += k == 0 ? "(" : ", ", append_number(text, x[k]);
  text += ")";
}

class UsdaWriter {
 public:
  using Put = std::function<void(std::string_view)>;

  UsdaWriter(const FrameTopology& topology, std::string_view part, const fs::path& folder, const Put& put)
      : topology_(topology), part_(part), header_(frame_part_header(part)), folder_(folder), put_(put) {}

  void write() {
    add_head();
    line("def Xform \"run\" {");
    std::set<std::string> names{"Materials"};
    if (!topology_.materials.empty()) add_materials();
    for (std::size_t m = 0; m < topology_.meshes.size(); ++m) add_mesh(m, identifier(topology_.meshes[m].name, names));
    std::size_t moving = 0, begin = topology_.rest.size();
    for (std::size_t e = 0; e < topology_.environment.size(); ++e) {
      const EnvironmentMesh& object = topology_.environment[e];
      const std::string& name = topology_.environment_names[e];
      add_object(object, name, identifier(name, names), moving, begin);
      if (moves_rigidly(object)) ++moving;
      if (deforms(object)) begin += object.mesh.points.size();
    }
    line("}");
  }

 private:
  const float* frame(int k) const { return reinterpret_cast<const float*>(part_.data() + header_.bytes(k)); }
  const float* place(int k, std::size_t vertex) const {
    return frame(k) + header_.numbers() - 3 * static_cast<std::size_t>(header_.vertices) + 3 * vertex;
  }
  void line(const std::string& text) const { put_(text + "\n"); }

  void add_head() const {
    // Time codes are the numbers of the frames.
    double rate = 24;
    const int last = header_.count - 1;
    if (last > 0) rate = last / (double{*frame(last)} - double{*frame(0)});
    const std::string shown_rate = shown(rate);
    line("#usda 1.0\n(\n  defaultPrim = \"run\"\n  doc = " + quoted_text(std::string("malha ") + version()) +
         "\n  metersPerUnit = 1\n  upAxis = \"Y\"\n  framesPerSecond = " + shown_rate +
         "\n  timeCodesPerSecond = " + shown_rate + "\n  startTimeCode = " + std::to_string(header_.first) +
         "\n  endTimeCode = " + std::to_string(header_.first + last) + "\n)\n");
  }

  /// Writes an attribute with a value at each frame.
  template <class Value>
  void add_samples(const std::string& attribute, const Value& value, const std::string& metadata = "") const {
    line("    " + attribute + ".timeSamples = {");
    for (int k = 0; k < header_.count; ++k) {
      std::string text = "      " + std::to_string(header_.first + k) + ": ";
      value(text, k);
      line(text + ",");
    }
    line("    }");
    if (!metadata.empty()) line("    " + attribute + " (" + metadata + ")");
  }

  /// Writes the places of vertices of the part.
  void add_points(const std::vector<int>& vertices) const {
    add_samples("point3f[] points", [&](std::string& text, int k) {
      text += "[";
      for (std::size_t i = 0; i < vertices.size(); ++i) {
        const float* x = place(k, static_cast<std::size_t>(vertices[i]));
        if (i > 0) text += ", ";
        append_tuple(text, std::array{x[0], x[1], x[2]});
      }
      text += "]";
    });
    add_samples("float3[] extent", [&](std::string& text, int k) {
      constexpr float kMost = std::numeric_limits<float>::max();
      std::array<float, 3> low{kMost, kMost, kMost}, high{-kMost, -kMost, -kMost};
      for (const int vertex : vertices)
        for (std::size_t c = 0; c < 3; ++c) {
          const float x = place(k, static_cast<std::size_t>(vertex))[c];
          low[c] = std::min(low[c], x), high[c] = std::max(high[c], x);
        }
      text += "[", append_tuple(text, low), text += ", ", append_tuple(text, high), text += "]";
    });
  }

  void begin_prim(const std::string& type, const std::string& name, const std::string& shown_name,
                  bool has_material = false) const {
    const std::string api = has_material ? "    prepend apiSchemas = [\"MaterialBindingAPI\"]\n" : "";
    line("  def " + type + " \"" + name + "\" (\n" + api +
         "    customData = {\n      string name = " + quoted_text(shown_name) + "\n    }\n  )\n  {");
  }

  void add_colour(const std::array<float, 3>& colour) const {
    std::string text = "    color3f[] primvars:displayColor = [";
    append_tuple(text, linear_colour(colour));  // those of pictures are sRGB
    line(text + "]");
  }

  void add_mesh(std::size_t m, const std::string& name) {
    const FrameMesh& mesh = topology_.meshes[m];
    const Polygons& polygons = topology_.polygons;
    const auto count = static_cast<int>(points_of(topology_, m, topology_.rest).size());
    const auto [first, end] = polygons_of(topology_, m);
    const bool has_material = !topology_.materials.empty();
    if (end > first) {
      std::vector<int> counts, corners, all(static_cast<std::size_t>(count));
      for (std::size_t f = first; f < end; ++f) {
        counts.push_back(static_cast<int>(polygons.corners_of(f).size()));
        for (const int point : polygons.corners_of(f)) corners.push_back(point - mesh.begin);
      }
      std::iota(all.begin(), all.end(), mesh.begin);
      begin_prim("Mesh", name, mesh.name, has_material);
      line("    uniform token subdivisionScheme = \"none\"\n    uniform bool doubleSided = 1");
      line("    int[] faceVertexCounts = " + list_of(counts));
      line("    int[] faceVertexIndices = " + list_of(corners));
      add_texture(first, end);
      add_colour(body_colour(mesh.body));
      add_points(all);
      if (has_material) add_subsets(first, end);
      line("  }");
    }
    std::vector<int> ends, loose;
    for (const Edge& one : topology_.lines)
      if (mesh.begin <= one[0] && one[0] < mesh.begin + count) ends.insert(ends.end(), one.begin(), one.end());
    for (const int point : topology_.loose)
      if (mesh.begin <= point && point < mesh.begin + count) loose.push_back(point);
    // A mesh without polygons has its name for what it has.
    if (!ends.empty()) {
      begin_prim("BasisCurves", end > first ? name + "_lines" : name, mesh.name);
      line("    uniform token type = \"linear\"");
      line("    int[] curveVertexCounts = " + list_of(std::vector<int>(ends.size() / 2, 2)));
      add_colour(body_colour(mesh.body));
      add_points(ends);
      line("  }");
    }
    if (!loose.empty()) {
      begin_prim("Points", end > first || !ends.empty() ? name + "_points" : name, mesh.name);
      add_colour(body_colour(mesh.body));
      add_points(loose);
      line("  }");
    }
  }

  /// Writes the texture coordinates of the polygons' corners, if one of them has any.
  void add_texture(std::size_t first, std::size_t end) const {
    const Polygons& polygons = topology_.polygons;
    if (polygons.uv.empty()) return;
    std::vector<int> index;
    std::map<int, int> known;
    std::string text = "    texCoord2f[] primvars:st = [";
    bool has_any = false;
    for (int c = polygons.begin[first]; c < polygons.begin[end]; ++c) {
      const int uv = polygons.uv_of(c);
      has_any = has_any || uv >= 0;
      const auto [at, is_new] = known.try_emplace(uv, static_cast<int>(known.size()));
      index.push_back(at->second);
      if (!is_new) continue;
      if (known.size() > 1) text += ", ";
      const auto [u, v] = uv < 0 ? std::array<double, 2>{} : polygons.uv[static_cast<std::size_t>(uv)];
      append_tuple(text, std::array{static_cast<float>(u), static_cast<float>(v)});
    }
    if (!has_any) return;
    line(text + "] (\n      interpolation = \"faceVarying\"\n    )");
    line("    int[] primvars:st:indices = " + list_of(index));
  }

  /// Binds the polygons of each material to it.
  void add_subsets(std::size_t first, std::size_t end) const {
    std::map<int, std::vector<int>> polygons;
    for (std::size_t f = first; f < end; ++f)
      if (const int material = topology_.polygons.material[f]; material >= 0)
        polygons[material].push_back(static_cast<int>(f - first));
    if (polygons.empty()) return;
    line("    uniform token subsetFamily:materialBind:familyType = \"nonOverlapping\"");
    for (const auto& [material, list] : polygons) {
      const std::string& name = materials_[static_cast<std::size_t>(material)];
      line("    def GeomSubset \"" + name + "\" (\n      prepend apiSchemas = [\"MaterialBindingAPI\"]\n    )\n    {");
      line("      uniform token elementType = \"face\"\n      uniform token familyName = \"materialBind\"");
      line("      int[] indices = " + list_of(list));
      line("      rel material:binding = </run/Materials/" + name + ">\n    }");
    }
  }

  void add_materials() {
    std::set<std::string> names;
    line("  def Scope \"Materials\" {");
    for (const FrameMaterial& material : topology_.materials) {
      const MaterialLook look = look_of(material);
      const std::string name = materials_.emplace_back(identifier(material.name, names)), at = "/run/Materials/" + name;
      line("    def Material \"" + name + "\" (\n      customData = {\n        string name = " +
           quoted_text(material.name) + "\n      }\n    )\n    {");
      line("      token outputs:surface.connect = <" + at + "/surface.outputs:surface>");
      line("      def Shader \"surface\" {\n        uniform token info:id = \"UsdPreviewSurface\"");
      if (look.picture.empty()) {
        std::string colour = "        color3f inputs:diffuseColor = ";
        append_tuple(colour, look.colour);
        line(colour);
      } else {
        line("        color3f inputs:diffuseColor.connect = <" + at + "/picture.outputs:rgb>");
      }
      line("        float inputs:opacity = " + shown(look.opacity));
      line("        float inputs:roughness = 0.8\n        token outputs:surface\n      }");
      if (!look.picture.empty()) {
        const fs::path whole = fs::absolute(look.picture).lexically_normal();
        const std::string relative =
            whole.lexically_relative(fs::absolute(folder_).lexically_normal()).generic_string();
        line("      def Shader \"picture\" {\n        uniform token info:id = \"UsdUVTexture\"");
        line("        asset inputs:file = @" + (relative.starts_with(".") ? relative : "./" + relative) + "@");
        line("        float2 inputs:st.connect = <" + at + "/st.outputs:result>\n        float3 outputs:rgb\n      }");
        line("      def Shader \"st\" {\n        uniform token info:id = \"UsdPrimvarReader_float2\"");
        line("        string inputs:varname = \"st\"\n        float2 outputs:result\n      }");
      }
      line("    }");
    }
    line("  }");
  }

  /// Writes an object of the environment: at rest, moving rigidly as object `moving` of the part, or with vertices from
  /// `begin` on there.
  void add_object(const EnvironmentMesh& object, const std::string& shown_name, const std::string& name,
                  std::size_t moving, std::size_t begin) const {
    std::vector<int> counts, corners;
    for (const Quad& face : object.mesh.faces) {
      counts.push_back(is_triangle(face) ? 3 : 4);
      corners.insert(corners.end(), face.begin(), face.begin() + counts.back());
    }
    begin_prim("Mesh", name, shown_name);
    line("    uniform token subdivisionScheme = \"none\"\n    uniform bool doubleSided = 1");
    line("    int[] faceVertexCounts = " + list_of(counts));
    line("    int[] faceVertexIndices = " + list_of(corners));
    add_colour(stone_colour());
    if (deforms(object)) {
      std::vector<int> all(object.mesh.points.size());
      std::iota(all.begin(), all.end(), static_cast<int>(begin));
      add_points(all);
    } else {
      std::string text = "    point3f[] points = [";
      for (std::size_t i = 0; i < object.mesh.points.size(); ++i) {
        if (i > 0) text += ", ";
        const Vec3& x = object.mesh.points[i];
        append_tuple(text, std::array{static_cast<float>(x[0]), static_cast<float>(x[1]), static_cast<float>(x[2])});
      }
      line(text + "]");
    }
    if (moves_rigidly(object)) {
      const std::size_t at = 1 + kPoseNumbers * moving;
      add_samples("double3 xformOp:translate", [&](std::string& text, int k) {
        append_tuple(text, std::array{frame(k)[at], frame(k)[at + 1], frame(k)[at + 2]});
      });
      add_samples("quatf xformOp:orient", [&](std::string& text, int k) {  // w first
        const float* q = frame(k) + at + 3;
        append_tuple(text, std::array{q[3], q[0], q[1], q[2]});
      });
      line("    uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:orient\"]");
    }
    line("  }");
  }

  const FrameTopology& topology_;
  std::string_view part_;
  FramePartHeader header_;
  fs::path folder_;
  const Put& put_;
  std::vector<std::string> materials_;  // names of their prims
};

class Usda : public FrameFormat {
 public:
  Usda(const fs::path& folder, const FrameTopology& topology, int next)
      : path_(folder / "run.usda"),
        topology_(topology),
        part_(path_, topology.rest.size() + deforming_vertices(topology.environment),
              moving_objects(topology.environment), next) {}

  void write(const Frame& frame) override {
    numbers_.assign(1, static_cast<float>(frame.time));
    for (const EnvironmentMesh& object : topology_.environment)
      if (moves_rigidly(object)) append_pose(numbers_, object, {0, 0, 0}, frame.time);
    add_places(frame.points);
    for (const EnvironmentMesh& object : topology_.environment)
      if (deforms(object)) add_places(points_at(object, frame.time));
    part_.write(numbers_);
  }

  /// The part stays, because a run that resumes cannot read its frames from the text.
  void finish() override {
    if (part_.empty()) return;
    const MappedFile part(part_.path());
    write_whole(path_, [&](const UsdaWriter::Put& put) {
      UsdaWriter(topology_, part.bytes(), path_.parent_path(), put).write();
    });
  }

 private:
  void add_places(std::span<const Vec3> points) {
    for (const Vec3& x : points)
      for (const double c : x) numbers_.push_back(static_cast<float>(c));
  }

  fs::path path_;
  FrameTopology topology_;
  FramePart part_;
  std::vector<float> numbers_;  // of the last frame
};

}  // namespace

std::unique_ptr<FrameFormat> make_usda(const fs::path& folder, const FrameTopology& topology, int next) {
  return std::make_unique<Usda>(folder, topology, next);
}

}  // namespace malha
