// SPDX-License-Identifier: Apache-2.0
// tinygltf parses the JSON and loads buffers. It does not check that accessors lie in their buffers, that nodes are
// trees, and that indices exist; this file does.
#include "host/mesh/io/gltf.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <unordered_map>

#include "host/base/spelling_suggestion.h"
#include "host/mesh/io/mesh_io.h"
#include "host/mesh/vectors.h"
#include "malha/error.h"

#ifdef MALHA_HAS_GLTF
#include <tiny_gltf.h>
#endif

namespace malha {

namespace {

/// The map of a place. The rotation need not be of unit length.
Affine map_of(const GltfPlace& place) {
  const auto& q = place.rotation;
  const double squared = (q[0] * q[0] + q[1] * q[1]) + (q[2] * q[2] + q[3] * q[3]);
  const double s = squared > 0 ? 2 / squared : 0;
  const auto [x, y, z, w] = q;
  const Vec3 columns[3]{{1 - s * (y * y + z * z), s * (x * y + z * w), s * (x * z - y * w)},
                        {s * (x * y - z * w), 1 - s * (x * x + z * z), s * (y * z + x * w)},
                        {s * (x * z + y * w), s * (y * z - x * w), 1 - s * (x * x + y * y)}};
  Affine map;
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t j = 0; j < 3; ++j) map.m[3 * j + k] = columns[j][k] * place.scale[j];
    map.m[9 + k] = place.translation[k];
  }
  return map;
}

/// Sets the maps from nodes to the world, followed by `map`.
void map_nodes(const GltfScene& file, const GltfPose& pose, const Affine& map, std::vector<Affine>& maps) {
  maps.resize(file.nodes.size());
  for (std::size_t i = 0; i < maps.size(); ++i) {
    const GltfNode& node = file.nodes[i];
    const Affine& parent = node.parent < 0 ? map : maps[static_cast<std::size_t>(node.parent)];
    maps[i] = parent * (node.matrix ? *node.matrix : map_of(pose.places[i]));
  }
}

}  // namespace

void deform(const GltfScene& file, const GltfPose& pose, const Affine& map, std::span<Vec3> points) {
  GltfMaps memory;
  deform(file, pose, map, points, memory);
}
void deform(const GltfScene& file, const GltfPose& pose, const Affine& map, std::span<Vec3> points, GltfMaps& memory) {
  map_nodes(file, pose, map, memory.nodes);
  std::vector<Affine>& maps = memory.joints;
  maps.resize(file.joints.size());
  for (std::size_t j = 0; j < maps.size(); ++j)
    maps[j] = memory.nodes[static_cast<std::size_t>(file.joints[j].node)] * file.joints[j].inverse_bind;

  std::ranges::copy(file.points, points.begin());
  for (const GltfTarget& target : file.targets) {
    const double weight = pose.weights[static_cast<std::size_t>(target.weight)];
    if (weight == 0) continue;
    for (std::size_t i = 0; i < target.vertices.size(); ++i) {
      Vec3& x = points[static_cast<std::size_t>(target.vertices[i])];
      for (std::size_t k = 0; k < 3; ++k) x[k] += weight * static_cast<double>(target.differences[i][k]);
    }
  }
  const int* begin = file.influence_begin.data();
  for (std::size_t v = 0; v < points.size(); ++v) {
    Affine blend{{}};
    for (int i = begin[v]; i < begin[v + 1]; ++i) {
      const GltfInfluence& of = file.influences[static_cast<std::size_t>(i)];
      const Affine& joint = maps[static_cast<std::size_t>(of.joint)];
      for (std::size_t k = 0; k < 12; ++k) blend.m[k] += of.weight * joint.m[k];
    }
    points[v] = blend * points[v];
  }
}

void select_vertices(GltfScene& file, std::span<const int> vertices) {
  GltfScene left = file;
  left.points.clear(), left.triangles = {}, left.influences.clear(), left.targets.clear();
  left.influence_begin.assign(1, 0);
  std::vector<std::vector<int>> places(file.points.size());  // of each vertex, in `vertices`
  for (const int v : vertices) {
    const auto of = static_cast<std::size_t>(v);
    places[of].push_back(static_cast<int>(left.points.size()));
    left.points.push_back(file.points[of]);
    const auto first = file.influences.begin();
    left.influences.insert(left.influences.end(), first + file.influence_begin[of],
                           first + file.influence_begin[of + 1]);
    left.influence_begin.push_back(static_cast<int>(left.influences.size()));
  }
  for (const GltfTarget& target : file.targets) {
    GltfTarget of{target.weight, {}, {}};
    for (std::size_t i = 0; i < target.vertices.size(); ++i)
      for (const int place : places[static_cast<std::size_t>(target.vertices[i])])
        of.vertices.push_back(place), of.differences.push_back(target.differences[i]);
    left.targets.push_back(std::move(of));
  }
  file = std::move(left);
}

FileMesh read_gltf(const std::string& file, std::string_view data, Attributes attributes) {
  GltfScene gltf = read_gltf_scene(file, data, attributes);
  FileMesh read{{}, std::move(gltf.triangles)};
  read.colours = std::move(gltf.colours);
  read.mesh.points.resize(gltf.points.size());
  deform(gltf, gltf.rest, {}, read.mesh.points);
  return read;
}

#ifndef MALHA_HAS_GLTF

GltfScene read_gltf_scene(const std::string& file, std::string_view, Attributes) {
  refuse(file, "", "glTF, and this malha was built without tinygltf (Debian: libtinygltf-dev)", "other formats");
}

#else

namespace {

namespace gltf = tinygltf;

constexpr std::size_t most_numbers = std::size_t{1} << 30;  // of an accessor

/// A JSON pointer to the item of a list.
std::string item(const std::string& list, std::size_t index) { return list + "/" + std::to_string(index); }
std::string item(const std::string& list, int index) { return list + "/" + std::to_string(index); }

/// The first line of an error of tinygltf, without its full stop.
std::string first_line(const std::string& text) {
  std::string line = text.substr(0, text.find('\n'));
  while (!line.empty() && (line.back() == '.' || line.back() == ' ')) line.pop_back();
  return line.empty() ? "no glTF" : line;
}

/// Pictures stay as they are.
bool skip_image(gltf::Image*, const int, std::string*, std::string*, int, int, const unsigned char*, int, void*) {
  return true;
}

gltf::Model parse(const std::string& file, std::string_view data) {
  const char* const allowed = "a glTF 2.0 file";
  gltf::TinyGLTF loader;
  loader.SetImageLoader(skip_image, nullptr);
  gltf::Model model;
  std::string error, warning;
  const std::string folder = std::filesystem::absolute(file).parent_path().string();
  if (data.size() > 0xffffffffu) refuse(file, "", std::to_string(data.size()) + " bytes", "less than 4 GiB");
  const auto size = static_cast<unsigned int>(data.size());
  bool is_read = false;
  try {
    is_read = data.starts_with("glTF")
                  ? loader.LoadBinaryFromMemory(&model, &error, &warning,
                                                reinterpret_cast<const unsigned char*>(data.data()), size, folder)
                  : loader.LoadASCIIFromString(&model, &error, &warning, data.data(), size, folder);
  } catch (const std::exception& thrown) {
    error = thrown.what();
  }
  if (!is_read || !error.empty()) refuse(file, "", first_line(error), allowed);
  if (!model.asset.version.starts_with("2."))
    refuse(file, "/asset/version", "\"" + model.asset.version + "\"", allowed);
  return model;
}

/// Refuses extensions that change what positions mean or how they are stored.
void check_extensions(const std::string& file, const gltf::Model& model) {
  for (std::size_t i = 0; i < model.extensionsRequired.size(); ++i) {
    const std::string& name = model.extensionsRequired[i];
    const bool harmless = name.starts_with("KHR_materials_") || name.starts_with("KHR_texture_") ||
                          name.starts_with("EXT_texture_") || name == "KHR_lights_punctual" ||
                          name == "KHR_mesh_quantization";
    if (!harmless)
      refuse(file, item("/extensionsRequired", i), "\"" + name + "\"",
             "extensions of materials, textures and lights, and KHR_mesh_quantization");
  }
}

const char* const types_of_size[]{"", "SCALAR", "VEC2", "VEC3", "VEC4"};

class Reader {
 public:
  Reader(const std::string& file, const gltf::Model& model, Attributes attributes)
      : file_(file), model_(model), attributes_(attributes) {}

  GltfScene read() && {
    add_nodes();
    for (std::size_t i = 0; i < of_scene_; ++i)
      if (const gltf::Node& node = model_.nodes[original_[i]]; node.mesh >= 0) add_mesh(static_cast<int>(i), node);
    if (out_.triangles.count() == 0) refuse("/meshes", "no triangles in the scene", "one or more");
    for (std::size_t c = 0; c < model_.animations.size(); ++c) add_clip(item("/animations", c), model_.animations[c]);
    flip_mirrored();
    return std::move(out_);
  }

 private:
  [[noreturn]] void refuse(const std::string& place, const std::string& found, const std::string& allowed) const {
    malha::refuse(file_, place, found, allowed);
  }
  void require_index(const std::string& place, int index, std::size_t count) const {
    if (index < 0 || static_cast<std::size_t>(index) >= count)
      refuse(place, std::to_string(index), "an index below " + std::to_string(count));
  }

  // Accessors.

  /// The bytes of a view from `offset`, at least so many.
  const unsigned char* bytes_of(const std::string& place, int view, std::size_t offset, std::size_t bytes) const {
    require_index(place + "/bufferView", view, model_.bufferViews.size());
    const gltf::BufferView& of = model_.bufferViews[static_cast<std::size_t>(view)];
    require_index(item("/bufferViews", view) + "/buffer", of.buffer, model_.buffers.size());
    const std::vector<unsigned char>& data = model_.buffers[static_cast<std::size_t>(of.buffer)].data;
    if (of.byteOffset > data.size() || of.byteLength > data.size() - of.byteOffset)
      refuse(item("/bufferViews", view), "bytes up to " + std::to_string(of.byteOffset + of.byteLength),
             "those of the buffer, " + std::to_string(data.size()));
    if (offset > of.byteLength || bytes > of.byteLength - offset)
      refuse(place, "bytes up to " + std::to_string(offset + bytes),
             "those of the buffer view, " + std::to_string(of.byteLength));
    return data.data() + of.byteOffset + offset;
  }

  /// A number of this type at `from`; a normalised integer as the ratio that it stands for.
  template <class T>
  static double number_as(const unsigned char* from, bool normalised) {
    T value;
    std::memcpy(&value, from, sizeof value);
    if constexpr (std::is_integral_v<T>)
      if (normalised)
        return std::max(static_cast<double>(value) / static_cast<double>(std::numeric_limits<T>::max()), -1.0);
    return static_cast<double>(value);
  }
  static double number_at(const unsigned char* from, int type, bool normalised) {
    switch (type) {
      case TINYGLTF_COMPONENT_TYPE_BYTE:
        return number_as<std::int8_t>(from, normalised);
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return number_as<std::uint8_t>(from, normalised);
      case TINYGLTF_COMPONENT_TYPE_SHORT:
        return number_as<std::int16_t>(from, normalised);
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return number_as<std::uint16_t>(from, normalised);
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        return number_as<std::uint32_t>(from, normalised);
      default:
        return number_as<float>(from, false);
    }
  }
  std::size_t size_of_component(const std::string& place, int type) const {
    if (type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT && type != TINYGLTF_COMPONENT_TYPE_FLOAT &&
        !(TINYGLTF_COMPONENT_TYPE_BYTE <= type && type <= TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT))
      refuse(place + "/componentType", std::to_string(type), "5120 to 5123, 5125 or 5126");
    return static_cast<std::size_t>(gltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(type)));
  }

  /// The numbers of an accessor whose items have this size (16: matrices). `name` is where it is used.
  std::vector<double> numbers(const std::string& name, int accessor, int size) const {
    require_index(name, accessor, model_.accessors.size());
    const std::string place = item("/accessors", accessor);
    const gltf::Accessor& of = model_.accessors[static_cast<std::size_t>(accessor)];
    const int wanted = size == 16 ? TINYGLTF_TYPE_MAT4 : size == 1 ? TINYGLTF_TYPE_SCALAR : size;
    if (of.type != wanted)
      refuse(place + "/type", "another type", std::string(size == 16 ? "MAT4" : types_of_size[size]) + " for " + name);
    const std::size_t bytes = size_of_component(place, of.componentType), item_bytes = bytes * std::size_t(size);
    if (of.count > most_numbers / std::size_t(size))
      refuse(place + "/count", std::to_string(of.count), "a count that fits into memory");
    std::vector<double> all;
    if (of.bufferView >= 0) {
      require_index(place + "/bufferView", of.bufferView, model_.bufferViews.size());
      const std::size_t named = model_.bufferViews[std::size_t(of.bufferView)].byteStride;
      const std::size_t stride = named > 0 ? named : item_bytes;
      if (stride < item_bytes || stride > 252 + item_bytes)
        refuse(item("/bufferViews", of.bufferView) + "/byteStride", std::to_string(stride),
               "at least an item's bytes, " + std::to_string(item_bytes) + ", and at most 252");
      const unsigned char* from =
          bytes_of(place, of.bufferView, of.byteOffset, of.count == 0 ? 0 : stride * (of.count - 1) + item_bytes);
      all.resize(of.count * std::size_t(size));
      for (std::size_t i = 0; i < of.count; ++i)
        for (std::size_t k = 0; k < std::size_t(size); ++k)
          all[i * std::size_t(size) + k] = number_at(from + i * stride + k * bytes, of.componentType, of.normalized);
    } else {
      all.resize(of.count * std::size_t(size));
    }
    if (of.sparse.isSparse) replace_sparse(place + "/sparse", of, std::size_t(size), bytes, all);
    for (const double number : all)
      if (!std::isfinite(number)) refuse(place, "a number that is not finite", "finite numbers");
    return all;
  }

  void replace_sparse(const std::string& place, const gltf::Accessor& of, std::size_t size, std::size_t bytes,
                      std::vector<double>& all) const {
    if (of.sparse.count < 0 || std::size_t(of.sparse.count) > of.count)
      refuse(place + "/count", std::to_string(of.sparse.count), "at most " + std::to_string(of.count));
    const auto count = static_cast<std::size_t>(of.sparse.count);
    const std::size_t index_bytes = size_of_component(place + "/indices", of.sparse.indices.componentType);
    const unsigned char* indices = bytes_of(place + "/indices", of.sparse.indices.bufferView,
                                            std::size_t(of.sparse.indices.byteOffset), count * index_bytes);
    const unsigned char* values = bytes_of(place + "/values", of.sparse.values.bufferView,
                                           std::size_t(of.sparse.values.byteOffset), count * size * bytes);
    for (std::size_t i = 0; i < count; ++i) {
      const double index = number_at(indices + i * index_bytes, of.sparse.indices.componentType, false);
      if (!(index >= 0) || index >= static_cast<double>(of.count))
        refuse(place + "/indices", "index " + std::to_string(static_cast<long long>(index)),
               "indices below " + std::to_string(of.count));
      for (std::size_t k = 0; k < size; ++k)
        all[static_cast<std::size_t>(index) * size + k] =
            number_at(values + (i * size + k) * bytes, of.componentType, of.normalized);
    }
  }

  // Nodes.

  /// Sorts the nodes depth first, those of the scene before the others.
  void add_nodes() {
    const std::size_t count = model_.nodes.size();
    std::vector<int> parent(count, -1);
    for (std::size_t i = 0; i < count; ++i)
      for (const int child : model_.nodes[i].children) {
        require_index(item("/nodes", i) + "/children", child, count);
        if (parent[std::size_t(child)] >= 0)
          refuse(item("/nodes", i) + "/children", "node " + std::to_string(child) + ", which has another parent",
                 "trees");
        parent[std::size_t(child)] = static_cast<int>(i);
      }
    place_of_.assign(count, -1);
    add_trees(roots_of_scene(parent));
    of_scene_ = original_.size();
    std::vector<int> others;
    for (std::size_t i = 0; i < count; ++i)
      if (parent[i] < 0 && place_of_[i] < 0) others.push_back(static_cast<int>(i));
    add_trees(others);
    if (original_.size() < count) refuse("/nodes", "nodes that are their own ancestors", "trees");
    for (std::size_t i = 0; i < count; ++i) {
      GltfNode& node = out_.nodes[i];
      const int above = parent[original_[i]];
      node.parent = above < 0 ? -1 : place_of_[std::size_t(above)];
      if (above >= 0 && node.parent >= static_cast<int>(i))
        refuse("/scenes", "node " + std::to_string(original_[i]) + ", which has a parent", "roots");
    }
  }

  std::vector<int> roots_of_scene(const std::vector<int>& parent) const {
    if (!model_.scenes.empty()) {
      const int scene = std::max(model_.defaultScene, 0);
      require_index("/scene", scene, model_.scenes.size());
      const std::vector<int>& roots = model_.scenes[std::size_t(scene)].nodes;
      for (const int root : roots) require_index(item("/scenes", scene) + "/nodes", root, parent.size());
      return roots;
    }
    std::vector<int> roots;
    for (std::size_t i = 0; i < parent.size(); ++i)
      if (parent[i] < 0) roots.push_back(static_cast<int>(i));
    return roots;
  }

  void add_trees(const std::vector<int>& roots) {
    std::vector<int> waiting(roots.rbegin(), roots.rend());
    while (!waiting.empty()) {
      const auto i = static_cast<std::size_t>(waiting.back());
      waiting.pop_back();
      if (place_of_[i] >= 0) refuse("/scenes", "node " + std::to_string(i) + " twice", "roots, each once");
      place_of_[i] = static_cast<int>(original_.size());
      original_.push_back(i);
      add_node(item("/nodes", i), model_.nodes[i]);
      waiting.insert(waiting.end(), model_.nodes[i].children.rbegin(), model_.nodes[i].children.rend());
    }
  }

  void add_node(const std::string& place, const gltf::Node& from) {
    GltfNode node;
    node.name = from.name;
    const auto copy = [&](const char* key, const std::vector<double>& list, auto& to) {
      if (list.empty()) return;
      if (list.size() != to.size())
        refuse(place + "/" + key, "a list of " + std::to_string(list.size()), "one of " + std::to_string(to.size()));
      for (const double number : list)
        if (!std::isfinite(number)) refuse(place + "/" + key, "a number that is not finite", "finite numbers");
      std::ranges::copy(list, to.begin());
    };
    copy("translation", from.translation, node.place.translation);
    copy("rotation", from.rotation, node.place.rotation);
    copy("scale", from.scale, node.place.scale);
    if (!from.matrix.empty()) {
      std::array<double, 16> matrix{};
      copy("matrix", from.matrix, matrix);
      node.matrix = affine(matrix.data());
    }
    out_.nodes.push_back(node);
    out_.rest.places.push_back(node.place);
    weight_of_node_.push_back(-1);
  }

  /// The map of a matrix of 4 x 4 by columns, whose last row is 0 0 0 1.
  static Affine affine(const double* matrix) {
    Affine map;
    for (std::size_t j = 0; j < 4; ++j)
      for (std::size_t k = 0; k < 3; ++k) map.m[3 * j + k] = matrix[4 * j + k];
    return map;
  }

  // Meshes.

  void add_mesh(int node, const gltf::Node& from) {
    require_index(item("/nodes", original_[std::size_t(node)]) + "/mesh", from.mesh, model_.meshes.size());
    const gltf::Mesh& mesh = model_.meshes[std::size_t(from.mesh)];
    const std::string place = item("/meshes", from.mesh);
    const int skin = from.skin >= 0 ? first_joint(from.skin) : -1;
    const int own = skin < 0 ? static_cast<int>(out_.joints.size()) : -1;
    if (own >= 0) out_.joints.push_back({node});
    weight_of_node_[std::size_t(node)] = static_cast<int>(out_.rest.weights.size());
    std::size_t targets = 0;
    std::vector<Vertices> shared;
    for (std::size_t p = 0; p < mesh.primitives.size(); ++p) {
      const std::string at = item(place + "/primitives", p);
      const gltf::Primitive& primitive = mesh.primitives[p];
      if (p > 0 && primitive.targets.size() != targets)
        refuse(at + "/targets", std::to_string(primitive.targets.size()),
               "as many as of the first primitive, " + std::to_string(targets));
      targets = primitive.targets.size();
      add_primitive(at, primitive, node, own, skin, from.skin, shared);
    }
    const std::vector<double>& weights = !from.weights.empty() ? from.weights : mesh.weights;
    if (!weights.empty() && weights.size() != targets)
      refuse(place + "/weights", std::to_string(weights.size()), "one for each target, " + std::to_string(targets));
    for (std::size_t t = 0; t < targets; ++t) out_.rest.weights.push_back(weights.empty() ? 0 : weights[t]);
  }

  /// The first joint of a skin; the others follow it.
  int first_joint(int skin) {
    require_index("/skins", skin, model_.skins.size());
    if (const auto known = joints_of_skin_.find(skin); known != joints_of_skin_.end()) return known->second;
    const gltf::Skin& of = model_.skins[std::size_t(skin)];
    const std::string place = item("/skins", skin);
    const auto first = static_cast<int>(out_.joints.size());
    std::vector<double> matrices;
    if (of.inverseBindMatrices >= 0) {
      matrices = numbers(place + "/inverseBindMatrices", of.inverseBindMatrices, 16);
      if (matrices.size() < 16 * of.joints.size())
        refuse(place + "/inverseBindMatrices", std::to_string(matrices.size() / 16),
               "one for each joint, " + std::to_string(of.joints.size()));
    }
    for (std::size_t j = 0; j < of.joints.size(); ++j) {
      require_index(place + "/joints", of.joints[j], model_.nodes.size());
      const int node = place_of_[std::size_t(of.joints[j])];
      out_.joints.push_back({node, matrices.empty() ? Affine{} : affine(&matrices[16 * j])});
    }
    return joints_of_skin_[skin] = first;
  }

  /// Vertices of a primitive, which others of its mesh may share.
  struct Vertices {
    const gltf::Primitive* of;
    int begin;
    std::size_t count;
    int first_uv;  // -1: without texture coordinates
  };

  /// Adds a primitive. Those without a skin follow the joint `own`. `shared`: the vertices of its mesh so far.
  void add_primitive(const std::string& place, const gltf::Primitive& from, int node, int own, int first_joint,
                     int skin, std::vector<Vertices>& shared) {
    auto vertices = std::ranges::find_if(shared, [&](const Vertices& other) {
      return other.of->attributes == from.attributes && other.of->targets == from.targets;
    });
    const bool is_new = vertices == shared.end();
    if (is_new) shared.push_back(add_points(place, from)), vertices = shared.end() - 1;
    add_triangles(place, from, vertices->begin, vertices->count);
    if (is_new) add_attributes(place, from, own, first_joint, skin, *vertices);
    Polygons& all = out_.triangles;
    if (attributes_ != Attributes::None)
      for (std::size_t c = all.corner_uv.size(); c < all.corners.size(); ++c)
        all.corner_uv.push_back(vertices->first_uv < 0 ? -1 : vertices->first_uv + all.corners[c] - vertices->begin);
    if (attributes_ == Attributes::All) add_names(node, from);
  }

  Vertices add_points(const std::string& place, const gltf::Primitive& from) {
    const auto begin = static_cast<int>(out_.points.size());
    const auto position = from.attributes.find("POSITION");
    if (position == from.attributes.end()) refuse(place + "/attributes", "no POSITION", "one");
    const std::vector<double> points = numbers(place + "/attributes/POSITION", position->second, 3);
    const std::size_t count = points.size() / 3;
    if (out_.points.size() + count > (std::size_t{1} << 28))
      refuse(place, "more than " + std::to_string(std::size_t{1} << 28) + " vertices", "fewer");
    for (std::size_t v = 0; v < count; ++v)
      out_.points.push_back({points[3 * v], points[3 * v + 1], points[3 * v + 2]});
    return {&from, begin, count, -1};
  }

  /// Adds all that the vertices have besides their places.
  void add_attributes(const std::string& place, const gltf::Primitive& from, int own, int first_joint, int skin,
                      Vertices& vertices) {
    const std::size_t count = vertices.count;
    if (attributes_ == Attributes::All) add_colours(place + "/attributes", from, count);
    if (attributes_ != Attributes::None) vertices.first_uv = add_texture(place + "/attributes", from, count);
    if (out_.influence_begin.empty()) out_.influence_begin.push_back(0);
    if (own >= 0)
      for (std::size_t v = 0; v < count; ++v) {
        out_.influences.push_back({own, 1});
        out_.influence_begin.push_back(static_cast<int>(out_.influences.size()));
      }
    else
      add_influences(place + "/attributes", from, count, first_joint, model_.skins[std::size_t(skin)].joints.size());
    for (std::size_t t = 0; t < from.targets.size(); ++t)
      add_target(item(place + "/targets", t), from.targets[t], vertices.begin, count, static_cast<int>(t));
  }

  /// Adds the colours of a primitive's vertices; white where it has none and others do.
  void add_colours(const std::string& place, const gltf::Primitive& from, std::size_t count) {
    constexpr std::array<float, 4> white{1, 1, 1, 1};
    const auto of = from.attributes.find("COLOR_0");
    if (of == from.attributes.end()) {
      if (!out_.colours.empty()) out_.colours.resize(out_.points.size(), white);
      return;
    }
    out_.colours.resize(out_.points.size() - count, white);
    require_index(place + "/COLOR_0", of->second, model_.accessors.size());
    const int size = model_.accessors[std::size_t(of->second)].type == TINYGLTF_TYPE_VEC4 ? 4 : 3;
    const std::vector<double> all = numbers(place + "/COLOR_0", of->second, size);
    if (all.size() != count * std::size_t(size))
      refuse(place + "/COLOR_0", std::to_string(all.size() / std::size_t(size)),
             std::to_string(count) + " as of POSITION");
    for (std::size_t v = 0; v < count; ++v) {
      std::array<float, 4>& colour = out_.colours.emplace_back(white);
      for (std::size_t k = 0; k < std::size_t(size); ++k)
        colour[k] = static_cast<float>(all[v * std::size_t(size) + k]);
    }
  }

  /// Adds the texture coordinates of a primitive's vertices. Returns the index of the first; -1: it has none.
  int add_texture(const std::string& place, const gltf::Primitive& from, std::size_t count) {
    Polygons& all = out_.triangles;
    const auto of = from.attributes.find("TEXCOORD_0");
    if (of == from.attributes.end()) return -1;
    const std::vector<double> uv = numbers(place + "/TEXCOORD_0", of->second, 2);
    if (uv.size() != 2 * count)
      refuse(place + "/TEXCOORD_0", std::to_string(uv.size() / 2), std::to_string(count) + " as of POSITION");
    const auto first = static_cast<int>(all.uv.size());
    for (std::size_t v = 0; v < count; ++v) all.uv.push_back({uv[2 * v], uv[2 * v + 1]});
    return first;
  }

  /// Names the triangles and vertices of the last primitive: an object is a node with a mesh.
  void add_names(int node, const gltf::Primitive& from) {
    Polygons& all = out_.triangles;
    if (node != last_object_) all.objects.push_back(out_.nodes[std::size_t(node)].name);
    last_object_ = node;
    all.object.resize(all.count(), static_cast<int>(all.objects.size()) - 1);
    all.vertex_object.resize(out_.points.size(), static_cast<int>(all.objects.size()) - 1);
    int material = -1;
    if (from.material >= 0 && static_cast<std::size_t>(from.material) < model_.materials.size()) {
      if (all.materials.empty())
        for (const gltf::Material& one : model_.materials) all.materials.push_back(one.name);
      material = from.material;
    }
    all.material.resize(all.count(), material);
  }

  void add_triangles(const std::string& place, const gltf::Primitive& from, int begin, std::size_t count) {
    const int mode = from.mode < 0 ? TINYGLTF_MODE_TRIANGLES : from.mode;
    if (mode != TINYGLTF_MODE_TRIANGLES && mode != TINYGLTF_MODE_TRIANGLE_STRIP && mode != TINYGLTF_MODE_TRIANGLE_FAN)
      refuse(place + "/mode", std::to_string(mode), "triangles, their strips and fans: 4, 5 or 6");
    std::vector<int> corners;
    if (from.indices < 0) {
      for (std::size_t v = 0; v < count; ++v) corners.push_back(static_cast<int>(v));
    } else {
      for (const double index : numbers(place + "/indices", from.indices, 1)) {
        if (!(index >= 0) || index >= static_cast<double>(count) || index != std::floor(index))
          refuse(place + "/indices", "vertex " + std::to_string(static_cast<long long>(index)),
                 "vertices below " + std::to_string(count));
        corners.push_back(static_cast<int>(index));
      }
    }
    const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
      const std::array face{begin + corners[a], begin + corners[b], begin + corners[c]};
      // Strips repeat corners to join their parts.
      if (face[0] != face[1] && face[1] != face[2] && face[2] != face[0]) out_.triangles.add(face);
    };
    if (mode == TINYGLTF_MODE_TRIANGLES && corners.size() % 3 != 0)
      refuse(place + "/indices", std::to_string(corners.size()) + " corners", "a multiple of 3");
    for (std::size_t i = 2; i < corners.size(); i += mode == TINYGLTF_MODE_TRIANGLES ? 3 : 1)
      if (mode == TINYGLTF_MODE_TRIANGLE_FAN)
        add(i - 1, i, 0);
      else if (mode == TINYGLTF_MODE_TRIANGLE_STRIP && i % 2 == 1)
        add(i - 1, i - 2, i);
      else
        add(i - 2, i - 1, i);
  }

  void add_influences(const std::string& place, const gltf::Primitive& from, std::size_t count, int first_joint,
                      std::size_t joints) {
    std::vector<std::vector<double>> indices, weights;
    for (int set = 0; from.attributes.contains("JOINTS_" + std::to_string(set)); ++set) {
      const std::string end = std::to_string(set);
      const auto of = from.attributes.find("WEIGHTS_" + end);
      if (of == from.attributes.end()) refuse(place, "JOINTS_" + end + " without WEIGHTS_" + end, "both");
      indices.push_back(numbers(place + "/JOINTS_" + end, from.attributes.at("JOINTS_" + end), 4));
      weights.push_back(numbers(place + "/WEIGHTS_" + end, of->second, 4));
      if (indices.back().size() != 4 * count || weights.back().size() != 4 * count)
        refuse(place, "JOINTS_" + end + " or WEIGHTS_" + end + " of another number of vertices",
               std::to_string(count) + " as of POSITION");
    }
    if (indices.empty()) refuse(place, "no JOINTS_0 in a mesh with a skin", "JOINTS_0 and WEIGHTS_0");
    for (std::size_t v = 0; v < count; ++v) {
      const std::size_t first = out_.influences.size();
      double sum = 0;
      for (std::size_t s = 0; s < weights.size(); ++s)
        for (std::size_t k = 4 * v; k < 4 * v + 4; ++k) {
          const double weight = weights[s][k], joint = indices[s][k];
          if (weight == 0) continue;
          if (weight < 0)
            refuse(place + "/WEIGHTS_" + std::to_string(s), "a weight below 0, of vertex " + std::to_string(v), ">= 0");
          if (!(joint >= 0 && joint < static_cast<double>(joints)))
            refuse(place + "/JOINTS_" + std::to_string(s), "joint " + std::to_string(static_cast<long long>(joint)),
                   "joints of the skin, below " + std::to_string(joints));
          out_.influences.push_back({first_joint + static_cast<int>(joint), weight}), sum += weight;
        }
      if (sum == 0) refuse(place, "no weight of vertex " + std::to_string(v), "weights whose sum is 1");
      for (std::size_t i = first; i < out_.influences.size(); ++i) out_.influences[i].weight /= sum;
      out_.influence_begin.push_back(static_cast<int>(out_.influences.size()));
    }
  }

  void add_target(const std::string& place, const std::map<std::string, int>& from, int begin, std::size_t count,
                  int index) {
    GltfTarget target{static_cast<int>(out_.rest.weights.size()) + index, {}, {}};
    if (const auto position = from.find("POSITION"); position != from.end()) {
      const std::vector<double> all = numbers(place + "/POSITION", position->second, 3);
      if (all.size() != 3 * count)
        refuse(place + "/POSITION", std::to_string(all.size() / 3) + " vertices", std::to_string(count));
      for (std::size_t v = 0; v < count; ++v) {
        const double* d = &all[3 * v];
        if (d[0] == 0 && d[1] == 0 && d[2] == 0) continue;
        target.vertices.push_back(begin + static_cast<int>(v));
        target.differences.push_back({static_cast<float>(d[0]), static_cast<float>(d[1]), static_cast<float>(d[2])});
      }
    }
    out_.targets.push_back(std::move(target));
  }

  /// Turns the triangles of what a node without skin mirrors, so that normals still point outwards.
  void flip_mirrored() {
    std::vector<Affine> maps;
    map_nodes(out_, out_.rest, {}, maps);
    Polygons& all = out_.triangles;
    for (std::size_t c = 0; c < all.corners.size(); c += 3) {
      const int first = out_.influence_begin[std::size_t(all.corners[c])];
      const GltfJoint& joint = out_.joints[std::size_t(out_.influences[std::size_t(first)].joint)];
      if (determinant(maps[std::size_t(joint.node)] * joint.inverse_bind) >= 0) continue;
      std::swap(all.corners[c + 1], all.corners[c + 2]);
      if (!all.corner_uv.empty()) std::swap(all.corner_uv[c + 1], all.corner_uv[c + 2]);
    }
  }

  // Clips.

  void add_clip(const std::string& place, const gltf::Animation& from) {
    GltfClip clip{from.name, {}};
    for (std::size_t c = 0; c < from.channels.size(); ++c) {
      const gltf::AnimationChannel& channel = from.channels[c];
      if (channel.target_node < 0) continue;  // of an extension
      const std::string at = item(place + "/channels", c);
      require_index(at + "/target/node", channel.target_node, model_.nodes.size());
      require_index(at + "/sampler", channel.sampler, from.samplers.size());
      const std::size_t node = std::size_t(place_of_[std::size_t(channel.target_node)]);
      const std::string& path = channel.target_path;
      if (path == "weights") {
        if (weight_of_node_[node] < 0) continue;  // outside of the scene
        const int size = targets_of(model_.nodes[original_[node]]);
        if (size == 0) refuse(at + "/target/path", "\"weights\" of a mesh without targets", "a mesh with targets");
        add_channel(clip, item(place + "/samplers", channel.sampler), from.samplers[std::size_t(channel.sampler)],
                    {GltfPath::Weights, {}, weight_of_node_[node], size, {}, {}});
        continue;
      }
      if (path != "translation" && path != "rotation" && path != "scale") continue;  // of an extension
      if (out_.nodes[node].matrix) refuse(at + "/target/node", "a node with a matrix", "one without");
      add_channel(clip, item(place + "/samplers", channel.sampler), from.samplers[std::size_t(channel.sampler)],
                  {path == "translation" ? GltfPath::Translation
                   : path == "rotation"  ? GltfPath::Rotation
                                         : GltfPath::Scale,
                   {},
                   static_cast<int>(node),
                   path == "rotation" ? 4 : 3,
                   {},
                   {}});
    }
    out_.clips.push_back(std::move(clip));
  }

  int targets_of(const gltf::Node& node) const {
    const gltf::Mesh& mesh = model_.meshes[std::size_t(node.mesh)];
    return mesh.primitives.empty() ? 0 : static_cast<int>(mesh.primitives[0].targets.size());
  }

  void add_channel(GltfClip& clip, const std::string& place, const gltf::AnimationSampler& from, GltfChannel channel) {
    const std::string& kind = from.interpolation;
    if (!kind.empty() && kind != "LINEAR" && kind != "STEP" && kind != "CUBICSPLINE")
      refuse(place + "/interpolation", "\"" + kind + "\"", "LINEAR, STEP or CUBICSPLINE");
    channel.interpolation = kind == "STEP"          ? GltfInterpolation::Step
                            : kind == "CUBICSPLINE" ? GltfInterpolation::CubicSpline
                                                    : GltfInterpolation::Linear;
    channel.times = numbers(place + "/input", from.input, 1);
    if (channel.times.empty()) refuse(place + "/input", "no times", "one or more");
    for (std::size_t i = 1; i < channel.times.size(); ++i)
      if (channel.times[i] <= channel.times[i - 1])
        refuse(place + "/input", "time " + std::to_string(i) + " not after the one before", "ascending times");
    // Weights are scalars, as many for each time as there are targets.
    channel.values = numbers(place + "/output", from.output, channel.path == GltfPath::Weights ? 1 : channel.size);
    const std::size_t wanted = channel.times.size() * std::size_t(channel.size) *
                               (channel.interpolation == GltfInterpolation::CubicSpline ? 3 : 1);
    if (channel.values.size() != wanted)
      refuse(place + "/output", std::to_string(channel.values.size()) + " numbers",
             std::to_string(wanted) + ", for the times of the input");
    clip.channels.push_back(std::move(channel));
  }

  const std::string& file_;
  const gltf::Model& model_;
  Attributes attributes_;
  GltfScene out_;
  std::vector<std::size_t> original_;  // number in the file of each node
  std::vector<int> place_of_;          // in out_.nodes, of each node of the file
  std::vector<int> weight_of_node_;    // first weight of the targets of each node's mesh; -1: no mesh
  std::unordered_map<int, int> joints_of_skin_;
  std::size_t of_scene_ = 0;  // number of nodes of the scene
  int last_object_ = -1;      // node of the last primitive
};

}  // namespace

GltfScene read_gltf_scene(const std::string& file, std::string_view data, Attributes attributes) {
  const gltf::Model model = parse(file, data);
  check_extensions(file, model);
  return Reader(file, model, attributes).read();
}

#endif

}  // namespace malha
