// SPDX-License-Identifier: Apache-2.0
// tinygltf holds the model and writes the JSON. It does not write the file, because it would hold the binary chunk
// twice in memory.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "host/attachments/object_motion.h"
#include "host/base/build_info.h"
#include "host/output/frame_formats.h"
#include "host/output/glb.h"
#include "host/render/picture.h"
#include "malha/text.h"

#ifdef MALHA_HAS_GLTF
#include <tiny_gltf.h>

#include "host/output/glb_materials.h"
#endif

namespace malha {

CentredPoints centred(std::span<const Vec3> points) {
  CentredPoints all{};
  for (int k = 0; k < 3; ++k) {
    const auto [low, high] = std::ranges::minmax(points, {}, [k](const Vec3& x) { return x[k]; });
    all.middle[k] = static_cast<float>((low[k] + high[k]) / 2);
  }
  for (const Vec3& x : points) {
    const auto from = [&](int k) { return static_cast<float>(x[k] - double{all.middle[k]}); };
    all.points.push_back({from(0), from(1), from(2)});
  }
  return all;
}

std::vector<Vec3> GlbVertices::gathered(std::size_t mesh, std::span<const Vec3> points) const {
  std::vector<Vec3> all;
  for (std::size_t v = begin[mesh]; v < begin[mesh + 1]; ++v) all.push_back(points[static_cast<std::size_t>(point[v])]);
  return all;
}

GlbVertices glb_vertices(const FrameTopology& topology) {
  const Polygons& polygons = topology.polygons;
  GlbVertices all;
  for (std::size_t m = 0; m < topology.meshes.size(); ++m) {
    const std::size_t begin = all.point.size();
    const int first = topology.meshes[m].begin;
    all.begin.push_back(begin);
    for (std::size_t i = 0; i < points_of(topology, m, topology.rest).size(); ++i)
      all.point.push_back(first + static_cast<int>(i));
    std::vector<int> uv(all.point.size() - begin, -1);    // index of those of each vertex
    std::map<std::pair<int, int>, std::uint32_t> copies;  // by point and texture coordinates
    const auto [from, to] = polygons_of(topology, m);
    for (int c = polygons.begin[from]; c < polygons.begin[to]; ++c) {
      const int point = polygons.corners[static_cast<std::size_t>(c)], own = polygons.uv_of(c);
      auto vertex = static_cast<std::uint32_t>(point - first);
      if (own >= 0 && uv[vertex] < 0) uv[vertex] = own;
      if (own >= 0 && polygons.uv[static_cast<std::size_t>(uv[vertex])] != polygons.uv[static_cast<std::size_t>(own)]) {
        const auto [known, is_new] = copies.try_emplace({point, own}, static_cast<std::uint32_t>(uv.size()));
        if (is_new) all.point.push_back(point), uv.push_back(own);
        vertex = known->second;
      }
      all.of_corner.push_back(vertex);
    }
    all.has_uv.push_back(std::ranges::any_of(uv, [](int own) { return own >= 0; }));
    for (const int own : uv) {
      const auto [u, v] = own < 0 ? std::array<double, 2>{} : polygons.uv[static_cast<std::size_t>(own)];
      all.uv.push_back({static_cast<float>(u), static_cast<float>(1 - v)});
    }
  }
  all.begin.push_back(all.point.size());
  return all;
}

#ifdef MALHA_HAS_GLTF

namespace {

namespace gltf = tinygltf;

std::vector<double> as_doubles(std::span<const float> floats) { return {floats.begin(), floats.end()}; }

/// Corners of triangles, ends of lines and loose points, numbered within a mesh.
struct Elements {
  std::map<int, std::vector<std::uint32_t>> triangles;  // by material; -1: none
  std::vector<std::uint32_t> lines, loose;
};

/// Adds a polygon in triangles: a quad a b c d as a b c and a c d, others as they are triangulated at rest.
void add_triangles(std::vector<std::uint32_t>& corners, std::span<const std::uint32_t> polygon,
                   const std::vector<Vec3>& points) {
  if (polygon.size() <= 4) {
    for (std::size_t last = 2; last < polygon.size(); ++last)
      corners.insert(corners.end(), {polygon[0], polygon[last - 1], polygon[last]});
    return;
  }
  std::vector<int> places(polygon.size());
  std::iota(places.begin(), places.end(), 0);
  for (const Triangle& triangle : triangulate(points, places))
    for (const int k : triangle) corners.push_back(polygon[static_cast<std::size_t>(k)]);
}

std::vector<Elements> elements_by_mesh(const FrameTopology& topology, const GlbVertices& vertices) {
  std::vector<Elements> all(topology.meshes.size());
  const Polygons& polygons = topology.polygons;
  for (std::size_t m = 0; m < all.size(); ++m) {
    const auto [first, end] = polygons_of(topology, m);
    for (std::size_t f = first; f < end; ++f) {
      std::vector<Vec3> points;
      for (const int point : polygons.corners_of(f)) points.push_back(topology.rest[static_cast<std::size_t>(point)]);
      const auto corners =
          std::span(vertices.of_corner).subspan(static_cast<std::size_t>(polygons.begin[f]), points.size());
      add_triangles(all[m].triangles[polygons.material.empty() ? -1 : polygons.material[f]], corners, points);
    }
  }
  const auto mesh_of = [&](int point) {
    return static_cast<std::size_t>(std::ranges::upper_bound(topology.meshes, point, {}, &FrameMesh::begin) -
                                    topology.meshes.begin() - 1);
  };
  const auto own = [&](int point) { return static_cast<std::uint32_t>(point - topology.meshes[mesh_of(point)].begin); };
  for (const Edge& line : topology.lines)
    for (const int point : line) all[mesh_of(line[0])].lines.push_back(own(point));
  for (const int point : topology.loose) all[mesh_of(point)].loose.push_back(own(point));
  return all;
}

class Writer {
 public:
  Writer(const FrameTopology& topology, const GlbVertices& vertices, std::string_view frames)
      : topology_(topology), vertices_(vertices), frames_(frames), header_(frame_part_header(frames)) {
    model_.asset.version = "2.0";
    model_.asset.generator = std::string("malha ") + version();
    model_.scenes.emplace_back();
    model_.defaultScene = 0;
    model_.animations.emplace_back().name = "run";
    for (int k = 0; k < header_.count; ++k)
      frame_view_.push_back(view(header_.bytes(k) + 4 * (header_.numbers() - 3 * stored()), 12 * stored(), 12));
    add_times();
    add_materials();
    add_meshes();
    add_environment();
  }

  GlbText text() && {
    std::ostringstream out;
    gltf::TinyGLTF().WriteGltfSceneToStream(&model_, out, false, false);
    std::string json = out.str();
    json.pop_back();  // the newline
    // tinygltf would write the length of its own buffer, which is empty.
    json.insert(1, "\"buffers\":[{\"byteLength\":" + std::to_string(frames_.size() + rest_.size()) + "}],");
    return {std::move(json), std::move(rest_)};
  }

 private:
  std::size_t stored() const { return static_cast<std::size_t>(header_.vertices); }
  const float* frame(int k) const { return reinterpret_cast<const float*>(frames_.data() + header_.bytes(k)); }

  template <class T>
  static int add(std::vector<T>& all, T one) {
    all.push_back(std::move(one));
    return static_cast<int>(all.size()) - 1;
  }

  /// Adds a buffer view. `stride`: bytes between vertices; 0 for other data.
  int view(std::size_t offset, std::size_t length, std::size_t stride = 0) {
    gltf::BufferView one;
    one.buffer = 0, one.byteOffset = offset, one.byteLength = length, one.byteStride = stride;
    if (stride > 0) one.target = TINYGLTF_TARGET_ARRAY_BUFFER;
    return add(model_.bufferViews, one);
  }

  template <class T>
  int put(const std::vector<T>& values, std::size_t stride = 0) {
    const std::size_t offset = frames_.size() + rest_.size();
    append_all(rest_, std::span<const T>(values));
    return view(offset, values.size() * sizeof(T), stride);
  }

  int accessor(int of_view, int type, std::size_t count, int component = TINYGLTF_COMPONENT_TYPE_FLOAT) {
    gltf::Accessor one;
    one.bufferView = of_view, one.type = type, one.count = count, one.componentType = component;
    return add(model_.accessors, one);
  }

  /// Adds an accessor of points with their bounds, which viewers need before they read the points.
  int points(int of_view, std::size_t offset, const float* x, std::size_t count) {
    constexpr float kMost = std::numeric_limits<float>::max();
    Float3 low{kMost, kMost, kMost}, high{-kMost, -kMost, -kMost};
    for (std::size_t i = 0; i < 3 * count; ++i)
      low[i % 3] = std::min(low[i % 3], x[i]), high[i % 3] = std::max(high[i % 3], x[i]);
    const int made = accessor(of_view, TINYGLTF_TYPE_VEC3, count);
    gltf::Accessor& one = model_.accessors.back();
    one.byteOffset = offset, one.minValues = as_doubles(low), one.maxValues = as_doubles(high);
    return made;
  }

  /// Adds the times of the frames, strictly increasing in float, as glTF requires.
  void add_times() {
    std::vector<float> times;
    for (int k = 0; k < header_.count; ++k) {
      const float least = k == 0 ? *frame(0) : std::nextafter(times.back(), std::numeric_limits<float>::max());
      times.push_back(std::max(*frame(k), least));
    }
    times_ = accessor(put(times), TINYGLTF_TYPE_SCALAR, times.size());
    model_.accessors.back().minValues = {times.front()}, model_.accessors.back().maxValues = {times.back()};
    // At the time of each frame the weight of its own target is 1 and all others are 0: an identity matrix, stored
    // sparsely.
    std::vector<std::uint32_t> places;
    const auto count = static_cast<std::uint32_t>(header_.count);
    for (std::uint32_t k = 0; k < count; ++k) places.push_back(k * count + k);
    const int at = put(places), ones = put(std::vector<float>(count, 1));
    const int weights = accessor(-1, TINYGLTF_TYPE_SCALAR, std::size_t{count} * count);
    auto& sparse = model_.accessors.back().sparse;
    sparse.isSparse = true, sparse.count = header_.count;
    sparse.indices = {.byteOffset = 0, .bufferView = at, .componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT};
    sparse.values = {.bufferView = ones, .byteOffset = 0};
    weights_ = sampler(weights);
  }

  int sampler(int output) {
    gltf::AnimationSampler one;
    one.input = times_, one.output = output;
    return add(model_.animations[0].samplers, one);
  }
  void animate(int node, const char* path, int of_sampler) {
    gltf::AnimationChannel one;
    one.target_node = node, one.target_path = path, one.sampler = of_sampler;
    model_.animations[0].channels.push_back(one);
  }

  /// Adds a material. Colours of pictures are sRGB, those of glTF are linear.
  int material(const std::string& name, const Float3& colour) {
    gltf::Material one;
    one.name = name, one.doubleSided = true;
    one.pbrMetallicRoughness.metallicFactor = 0, one.pbrMetallicRoughness.roughnessFactor = 0.8;
    for (int k = 0; k < 3; ++k)
      one.pbrMetallicRoughness.baseColorFactor[k] =
          colour[k] <= 0.04045 ? colour[k] / 12.92 : std::pow((colour[k] + 0.055) / 1.055, 2.4);
    return add(model_.materials, one);
  }

  void add_primitive(gltf::Mesh& mesh, const gltf::Primitive& like, int mode, const std::vector<std::uint32_t>& all) {
    if (all.empty()) return;
    gltf::Primitive one = like;
    one.mode = mode;
    one.indices = accessor(put(all), TINYGLTF_TYPE_SCALAR, all.size(), TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT);
    model_.bufferViews.back().target = TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER;
    mesh.primitives.push_back(one);
  }

  int add_node(const std::string& name, const CentredPoints& at_start, const Elements& elements,
               const std::vector<int>& targets, const Float3& colour, std::span<const std::array<float, 2>> uv = {}) {
    gltf::Primitive like;
    const std::size_t count = at_start.points.size();
    like.attributes["POSITION"] = points(put(at_start.points, 12), 0, at_start.points[0].data(), count);
    if (!uv.empty())
      like.attributes["TEXCOORD_0"] = accessor(put(std::vector(uv.begin(), uv.end()), 8), TINYGLTF_TYPE_VEC2, count);
    for (const int target : targets) like.targets.push_back({{"POSITION", target}});
    gltf::Mesh mesh;
    mesh.name = name;
    // A mesh without materials of its own has the colour of the pictures.
    int coloured = -1;
    const auto colour_of_pictures = [&] { return coloured < 0 ? coloured = material(name, colour) : coloured; };
    for (const auto& [of, triangles] : elements.triangles) {
      like.material = of < 0 ? colour_of_pictures() : materials_[static_cast<std::size_t>(of)];
      add_primitive(mesh, like, TINYGLTF_MODE_TRIANGLES, triangles);
    }
    if (!elements.lines.empty() || !elements.loose.empty()) like.material = colour_of_pictures();
    add_primitive(mesh, like, TINYGLTF_MODE_LINE, elements.lines);
    add_primitive(mesh, like, TINYGLTF_MODE_POINTS, elements.loose);
    if (!targets.empty()) {
      gltf::Value::Array names;
      for (int k = 0; k < header_.count; ++k) names.emplace_back(frame_name(header_.first + k, ""));
      mesh.extras = gltf::Value(gltf::Value::Object{{"targetNames", gltf::Value(names)}});
    }
    gltf::Node node;
    node.name = name, node.mesh = add(model_.meshes, mesh), node.translation = as_doubles(at_start.middle);
    model_.scenes[0].nodes.push_back(add(model_.nodes, node));
    return model_.scenes[0].nodes.back();
  }

  /// Adds a node whose vertices are displaced in every frame; `begin` is the number of its first vertex.
  void add_deforming_node(const std::string& name, const CentredPoints& at_start, const Elements& elements,
                          std::size_t begin, const Float3& colour, std::span<const std::array<float, 2>> uv = {}) {
    std::vector<int> targets;
    for (int k = 0; k < header_.count; ++k)
      targets.push_back(points(frame_view_[static_cast<std::size_t>(k)], 12 * begin,
                               frame(k) + header_.numbers() - 3 * stored() + 3 * begin, at_start.points.size()));
    animate(add_node(name, at_start, elements, targets, colour, uv), "weights", weights_);
  }

  void add_materials() {
    GlbMaterials materials(model_, [this](std::string_view bytes) {
      const int view = put(std::vector<char>(bytes.begin(), bytes.end()));
      rest_.resize((rest_.size() + 3) / 4 * 4);  // what follows begins at a multiple of its numbers' size
      return view;
    });
    for (const FrameMaterial& one : topology_.materials) materials_.push_back(materials.add(one));
  }

  void add_meshes() {
    const std::vector<Elements> elements = elements_by_mesh(topology_, vertices_);
    for (std::size_t m = 0; m < topology_.meshes.size(); ++m) {
      const std::size_t begin = vertices_.begin[m], count = vertices_.begin[m + 1] - begin;
      const auto uv = std::span(vertices_.uv).subspan(begin, vertices_.has_uv[m] ? count : 0);
      add_deforming_node(topology_.meshes[m].name, centred(vertices_.gathered(m, topology_.rest)), elements[m], begin,
                         body_colour(topology_.meshes[m].body), uv);
    }
  }

  void add_environment() {
    std::size_t moving = 0, begin = vertices_.point.size();
    for (std::size_t e = 0; e < topology_.environment.size(); ++e) {
      const EnvironmentMesh& object = topology_.environment[e];
      Elements elements;
      for (const Quad& face : object.mesh.faces) {
        std::vector<std::uint32_t> corners;
        for (int k = 0; k < (is_triangle(face) ? 3 : 4); ++k) corners.push_back(static_cast<std::uint32_t>(face[k]));
        add_triangles(elements.triangles[-1], corners, object.mesh.points);
      }
      const std::string& name = topology_.environment_names[e];
      const CentredPoints at_start = centred(object.mesh.points);
      if (deforms(object)) {
        add_deforming_node(name, at_start, elements, begin, stone_colour());
        begin += at_start.points.size();
        continue;
      }
      const int node = add_node(name, at_start, elements, {}, stone_colour());
      if (moves_rigidly(object)) add_motion(node, 1 + kPoseNumbers * moving++);
    }
  }

  /// Adds the animation of an object. `at`: offset of its pose among the numbers of a frame. A quaternion and its
  /// negative are the same rotation; the one nearer to the previous frame's is written, so that viewers that
  /// interpolate components rotate the short way.
  void add_motion(int node, std::size_t at) {
    std::vector<Float3> places;
    std::vector<std::array<float, 4>> turns;
    for (int k = 0; k < header_.count; ++k) {
      const float* x = frame(k) + at;
      places.push_back({x[0], x[1], x[2]});
      std::array<float, 4> turn{x[3], x[4], x[5], x[6]};
      float along = 0;
      for (std::size_t i = 0; k > 0 && i < 4; ++i) along += turn[i] * turns.back()[i];
      if (along < 0)
        for (float& number : turn) number = -number;
      turns.push_back(turn);
    }
    gltf::Node& one = model_.nodes[static_cast<std::size_t>(node)];
    one.translation = as_doubles(places[0]), one.rotation = as_doubles(turns[0]);
    animate(node, "translation", sampler(accessor(put(places), TINYGLTF_TYPE_VEC3, places.size())));
    animate(node, "rotation", sampler(accessor(put(turns), TINYGLTF_TYPE_VEC4, turns.size())));
  }

  const FrameTopology& topology_;
  const GlbVertices& vertices_;
  std::string_view frames_;
  FramePartHeader header_;
  gltf::Model model_;
  std::string rest_;
  std::vector<int> frame_view_;
  std::vector<int> materials_;     // of the topology
  int times_ = -1, weights_ = -1;  // accessor, sampler
};

}  // namespace

GlbText glb_text(const FrameTopology& topology, const GlbVertices& vertices, std::string_view frames) {
  return Writer(topology, vertices, frames).text();
}

#else

GlbText glb_text(const FrameTopology&, const GlbVertices&, std::string_view) {
  throw std::logic_error("built without tinygltf");
}

#endif

}  // namespace malha
