// SPDX-License-Identifier: Apache-2.0
// Materials of a glTF file that is written: those of glTF files with their pictures, and those of MTL files by what
// glTF has of them.
#pragma once
#ifdef MALHA_HAS_GLTF
#include <tiny_gltf.h>

#include <functional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "host/output/frames.h"

namespace malha {

class GlbMaterials {
 public:
  /// Adds to `model`. `add_bytes` stores bytes in the file's buffer and returns the index of their buffer view.
  GlbMaterials(tinygltf::Model& model, std::function<int(std::string_view)> add_bytes)
      : model_(model), add_bytes_(std::move(add_bytes)) {}

  /// Adds a material, and returns its index.
  int add(const FrameMaterial& material);

 private:
  tinygltf::Material from_gltf(const FrameMaterial& material);
  tinygltf::Material from_mtl(const FrameMaterial& material);
  /// Adds a texture of another file with its picture; returns -1 for one without a picture that can be read.
  int add_texture(const std::string& file, const tinygltf::Model& from, int texture);
  int add_picture(const std::string& name, std::string_view bytes);

  tinygltf::Model& model_;
  std::function<int(std::string_view)> add_bytes_;
  std::unordered_map<std::string, tinygltf::Model> files_;
  std::unordered_map<std::string, int> textures_, pictures_;  // by file and index, or by path
};

}  // namespace malha
#endif
