// SPDX-License-Identifier: Apache-2.0
// tinygltf holds the model and writes the JSON. It does not write the file, because it would hold the binary chunk
// twice in memory.
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "host/attachments/object_motion.h"
#include "host/base/build_info.h"
#include "host/output/frame_formats.h"
#include "host/output/glb.h"
#include "host/render/picture.h"
#include "malha/text.h"

#ifdef MALHA_HAS_GLTF
#include <tiny_gltf.h>
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

#ifdef MALHA_HAS_GLTF

namespace {

namespace gltf = tinygltf;

std::vector<double> as_doubles(std::span<const float> floats) { return {floats.begin(), floats.end()}; }

/// Corners of triangles, ends of lines and loose points, numbered within a body.
struct Elements {
  std::vector<std::uint32_t> triangles, lines, loose;
};

void add_triangles(std::vector<std::uint32_t>& corners, const Quad& face, int begin) {
  for (const int last : {2, 3}) {  // a quad a b c d becomes a b c, a c d
    if (face[last] < 0) continue;
    for (const int k : {0, last - 1, last}) corners.push_back(static_cast<std::uint32_t>(face[k] - begin));
  }
}

std::vector<Elements> elements_by_body(const FrameTopology& topology) {
  std::vector<Elements> all(topology.bodies.size());
  const auto body_of = [&](int point) {
    return std::ranges::upper_bound(topology.bodies, point, {}, &FrameBody::begin) - topology.bodies.begin() - 1;
  };
  const auto own = [&](int point) {
    return static_cast<std::uint32_t>(point - topology.bodies[static_cast<std::size_t>(body_of(point))].begin);
  };
  const auto of = [&](int point) -> Elements& { return all[static_cast<std::size_t>(body_of(point))]; };
  for (const Quad& face : topology.faces) add_triangles(of(face[0]).triangles, face, face[0] - int(own(face[0])));
  for (const Edge& line : topology.lines)
    of(line[0]).lines.insert(of(line[0]).lines.end(), {own(line[0]), own(line[1])});
  for (const int point : topology.loose) of(point).loose.push_back(own(point));
  return all;
}

class Writer {
 public:
  Writer(const FrameTopology& topology, std::string_view frames)
      : topology_(topology), frames_(frames), header_(glb_header(frames)) {
    model_.asset.version = "2.0";
    model_.asset.generator = std::string("malha ") + version();
    model_.scenes.emplace_back();
    model_.defaultScene = 0;
    model_.animations.emplace_back().name = "run";
    for (int k = 0; k < header_.count; ++k)
      frame_view_.push_back(view(header_.bytes(k) + 4 * (header_.numbers() - 3 * vertices()), 12 * vertices(), 12));
    add_times();
    add_bodies();
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
  std::size_t vertices() const { return static_cast<std::size_t>(header_.vertices); }
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
               const std::vector<int>& targets, const Float3& colour) {
    gltf::Primitive like;
    const std::size_t count = at_start.points.size();
    like.attributes["POSITION"] = points(put(at_start.points, 12), 0, at_start.points[0].data(), count);
    like.material = material(name, colour);
    for (const int target : targets) like.targets.push_back({{"POSITION", target}});
    gltf::Mesh mesh;
    mesh.name = name;
    add_primitive(mesh, like, TINYGLTF_MODE_TRIANGLES, elements.triangles);
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
                          std::size_t begin, const Float3& colour) {
    std::vector<int> targets;
    for (int k = 0; k < header_.count; ++k)
      targets.push_back(points(frame_view_[static_cast<std::size_t>(k)], 12 * begin,
                               frame(k) + header_.numbers() - 3 * vertices() + 3 * begin, at_start.points.size()));
    animate(add_node(name, at_start, elements, targets, colour), "weights", weights_);
  }

  void add_bodies() {
    const std::vector<Elements> elements = elements_by_body(topology_);
    for (std::size_t b = 0; b < topology_.bodies.size(); ++b)
      add_deforming_node(printable(topology_.bodies[b].name), centred(points_of(topology_, b, topology_.rest)),
                         elements[b], static_cast<std::size_t>(topology_.bodies[b].begin),
                         body_colour(static_cast<int>(b)));
  }

  void add_environment() {
    std::size_t moving = 0, begin = topology_.rest.size();
    for (const EnvironmentMesh& object : topology_.environment) {
      Elements elements;
      for (const Quad& face : object.mesh.faces) add_triangles(elements.triangles, face, 0);
      const std::string name = printable(object.spec.name);
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
  std::string_view frames_;
  GlbHeader header_;
  gltf::Model model_;
  std::string rest_;
  std::vector<int> frame_view_;
  int times_ = -1, weights_ = -1;  // accessor, sampler
};

}  // namespace

GlbText glb_text(const FrameTopology& topology, std::string_view frames) { return Writer(topology, frames).text(); }

#else

GlbText glb_text(const FrameTopology&, std::string_view) { throw std::logic_error("built without tinygltf"); }

#endif

}  // namespace malha
