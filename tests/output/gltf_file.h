// SPDX-License-Identifier: Apache-2.0
// A .glb file as tinygltf's loader reads it, and a small one to write.
#pragma once
#include <gtest/gtest.h>
#include <tiny_gltf.h>

#include <cstring>
#include <filesystem>
#include <stdexcept>

#include "host/output/frames.h"

namespace malha {

class GltfFile {
 public:
  explicit GltfFile(const std::filesystem::path& path) {
    tinygltf::TinyGLTF loader;
    std::string error, warning;
    EXPECT_TRUE(loader.LoadBinaryFromFile(&model, &error, &warning, path.string())) << error;
    EXPECT_EQ(error + warning, "");
  }

  /// The values of an accessor with component type T, `size` components a value.
  template <class T = float, std::size_t N = 3>
  std::vector<std::array<T, N>> values(int accessor) const {
    const tinygltf::Accessor& one = model.accessors.at(accessor);
    EXPECT_EQ(tinygltf::GetComponentSizeInBytes(one.componentType), int(sizeof(T)));
    EXPECT_EQ(tinygltf::GetNumComponentsInType(one.type), int(N));
    std::vector<std::array<T, N>> all(one.count);
    if (one.bufferView >= 0) std::memcpy(all.data(), at(one.bufferView, one.byteOffset), one.count * sizeof all[0]);
    for (int i = 0; one.sparse.isSparse && i < one.sparse.count; ++i) {
      std::uint32_t place = 0;
      EXPECT_EQ(one.sparse.indices.componentType, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT);
      std::memcpy(&place, at(one.sparse.indices.bufferView, 4 * i), 4);
      std::memcpy(&all.at(place), at(one.sparse.values.bufferView, sizeof(all[0]) * i), sizeof all[0]);
    }
    return all;
  }

  const tinygltf::Node& node(const std::string& name) const {
    for (const tinygltf::Node& one : model.nodes)
      if (one.name == name) return one;
    throw std::runtime_error("no node " + name);
  }
  const tinygltf::Mesh& mesh(const std::string& name) const { return model.meshes.at(node(name).mesh); }
  /// The sampler of the animation's channel of a node.
  const tinygltf::AnimationSampler& sampler(const std::string& name, const std::string& path) const {
    const tinygltf::Animation& animation = model.animations.at(0);
    for (const auto& channel : animation.channels)
      if (model.nodes[channel.target_node].name == name && channel.target_path == path)
        return animation.samplers.at(channel.sampler);
    throw std::runtime_error("no channel " + path + " of " + name);
  }
  std::vector<std::uint32_t> indices(const tinygltf::Primitive& primitive) const {
    std::vector<std::uint32_t> all;
    for (const auto& one : values<std::uint32_t, 1>(primitive.indices)) all.push_back(one[0]);
    return all;
  }

  tinygltf::Model model;

 private:
  const unsigned char* at(int view, std::size_t offset) const {
    return model.buffers.at(0).data.data() + model.bufferViews.at(view).byteOffset + offset;
  }
};

/// One body of a quad, a triangle, a line, a loose point and an unused vertex.
inline FrameTopology of_all_kinds() {
  FrameTopology all{
      polygons_of({{0, 1, 2, 3}, {1, 4, 2, -1}}),
      {{5, 6}},
      {7},
      {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 0.5, 0}, {0, 2, 0}, {1, 2, 0}, {3, 3, 3}, {9, 0, 0}}};
  all.unused = {8}, all.meshes = {{"all", 0, 0, 0}};
  return all;
}

}  // namespace malha
