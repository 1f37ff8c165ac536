// SPDX-License-Identifier: Apache-2.0
// Small .glb files, written byte by byte.
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/base/build_info.h"
#include "host/mesh/io/gltf.h"

namespace malha {

inline constexpr int kGltfByte = 5121, kGltfShort = 5123, kGltfFloat = 5126;

/// A file under construction. What the functions do not write, a test writes into `json`.
class GlbBuilder {
 public:
  nlohmann::json json = {{"asset", {{"version", "2.0"}}}, {"scene", 0}, {"scenes", {{{"nodes", {0}}}}}};

  /// Adds an accessor; `type` is "SCALAR", "VEC3" ... and `size` its numbers.
  template <class T>
  int add(const std::vector<T>& numbers, const std::string& type, int size, int component, bool normalised = false) {
    while (bytes_.size() % 4 != 0) bytes_.push_back(0);
    const auto length = numbers.size() * sizeof(T);
    json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", length}});
    bytes_.append(reinterpret_cast<const char*>(numbers.data()), length);
    json["accessors"].push_back({{"bufferView", json["bufferViews"].size() - 1},
                                 {"componentType", component},
                                 {"count", numbers.size() / static_cast<std::size_t>(size)},
                                 {"normalized", normalised},
                                 {"type", type}});
    return static_cast<int>(json["accessors"].size()) - 1;
  }
  int floats(const std::vector<float>& numbers, const std::string& type, int size) {
    return add(numbers, type, size, kGltfFloat);
  }

  /// Adds a channel to the last clip.
  void channel(int node, const std::string& path, const std::string& interpolation, const std::vector<float>& times,
               const std::vector<float>& values) {
    const bool scalar = path == "weights", rotation = path == "rotation";
    nlohmann::json& clip = json["animations"].back();
    clip["samplers"].push_back({{"input", floats(times, "SCALAR", 1)},
                                {"output", floats(values,
                                                  scalar     ? "SCALAR"
                                                  : rotation ? "VEC4"
                                                             : "VEC3",
                                                  scalar     ? 1
                                                  : rotation ? 4
                                                             : 3)},
                                {"interpolation", interpolation}});
    clip["channels"].push_back(
        {{"sampler", clip["samplers"].size() - 1}, {"target", {{"node", node}, {"path", path}}}});
  }

  std::string bytes() const {
    nlohmann::json whole = json;
    std::string data = bytes_;
    while (data.size() % 4 != 0) data.push_back(0);
    whole["buffers"] = {{{"byteLength", data.size()}}};
    std::string text = whole.dump();
    while (text.size() % 4 != 0) text.push_back(' ');
    const auto number = [](std::size_t value) {
      const auto bits = static_cast<std::uint32_t>(value);
      return std::string(reinterpret_cast<const char*>(&bits), 4);
    };
    return "glTF" + number(2) + number(28 + text.size() + data.size()) + number(text.size()) + "JSON" + text +
           number(data.size()) + std::string("BIN\0", 4) + data;
  }

 private:
  std::string bytes_;
};

/// A strip in the plane z = 0, one wide and two high, of three pairs of vertices at the heights 0, 1 and 2. Its upper
/// half follows a second joint at the height 1: the pair at the top wholly, the middle one by half.
inline GlbBuilder two_bone_strip(int weight_type = kGltfFloat) {
  GlbBuilder file;
  const int points = file.floats({-.5f, 0, 0, .5f, 0, 0, -.5f, 1, 0, .5f, 1, 0, -.5f, 2, 0, .5f, 2, 0}, "VEC3", 3);
  const int corners = file.add<std::uint16_t>({0, 1, 2, 1, 3, 2, 2, 3, 4, 3, 5, 4}, "SCALAR", 1, kGltfShort);
  std::vector<float> weights;
  std::vector<std::uint8_t> joints, bytes;
  std::vector<std::uint16_t> shorts;
  for (const float upper : {0.f, 0.f, .5f, .5f, 1.f, 1.f}) {
    joints.insert(joints.end(), {0, 1, 0, 0}), weights.insert(weights.end(), {1 - upper, upper, 0, 0});
    const auto of = [upper](int most) { return static_cast<int>(upper * static_cast<float>(most)); };
    for (const int weight : {255 - of(255), of(255), 0, 0}) bytes.push_back(static_cast<std::uint8_t>(weight));
    for (const int weight : {65535 - of(65535), of(65535), 0, 0}) shorts.push_back(static_cast<std::uint16_t>(weight));
  }
  const int joint = file.add(joints, "VEC4", 4, kGltfByte);
  const int weight = weight_type == kGltfFloat  ? file.floats(weights, "VEC4", 4)
                     : weight_type == kGltfByte ? file.add(bytes, "VEC4", 4, kGltfByte, true)
                                                : file.add(shorts, "VEC4", 4, kGltfShort, true);
  const int bind = file.floats({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0,  0, 1,   //
                                1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1},  // the joint is at the height 1
                               "MAT4", 16);
  file.json["meshes"] = {
      {{"primitives",
        {{{"attributes", {{"POSITION", points}, {"JOINTS_0", joint}, {"WEIGHTS_0", weight}}}, {"indices", corners}}}}}};
  file.json["skins"] = {{{"joints", {1, 2}}, {"inverseBindMatrices", bind}}};
  // The node of the mesh is elsewhere, which a skin ignores.
  file.json["nodes"] = {{{"mesh", 0}, {"skin", 0}, {"translation", {7, 7, 7}}},
                        {{"name", "lower"}, {"children", {2}}},
                        {{"name", "upper"}, {"translation", {0, 1, 0}}}};
  file.json["scenes"] = {{{"nodes", {0, 1}}}};
  return file;
}

/// A clip of the strip that turns the upper joint by `degrees` about z in a second.
inline GlbBuilder bending_strip(float degrees, int weight_type = kGltfFloat) {
  GlbBuilder file = two_bone_strip(weight_type);
  const float half = degrees / 2 * 3.14159265f / 180;
  file.json["animations"] = {{{"name", "bend"}}};
  file.channel(2, "rotation", "LINEAR", {0, 1}, {0, 0, 0, 1, 0, 0, std::sin(half), std::cos(half)});
  return file;
}

}  // namespace malha
