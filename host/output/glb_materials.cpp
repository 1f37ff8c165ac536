// SPDX-License-Identifier: Apache-2.0
#include "host/output/glb_materials.h"

#include <filesystem>

#include "host/base/file.h"
#include "host/mesh/io/mesh_io.h"
#include "host/output/materials.h"

namespace malha {

#ifndef MALHA_HAS_GLTF

std::optional<MaterialLook> look_in_gltf(const FrameMaterial&) { return {}; }

#else

namespace gltf = tinygltf;

namespace {

/// Keeps the bytes of a picture as they are.
bool keep_bytes(gltf::Image* image, const int, std::string*, std::string*, int, int, const unsigned char* bytes,
                int size, void*) {
  image->image.assign(bytes, bytes + size);
  return true;
}

gltf::Model load(const std::string& file) {
  gltf::TinyGLTF loader;
  loader.SetImageLoader(keep_bytes, nullptr);
  gltf::Model model;
  std::string error, warning;
  const std::string data = read_whole(file), folder = std::filesystem::absolute(file).parent_path().string();
  const auto size = static_cast<unsigned int>(data.size());
  const bool is_read =
      data.starts_with("glTF")
          ? loader.LoadBinaryFromMemory(&model, &error, &warning, reinterpret_cast<const unsigned char*>(data.data()),
                                        size, folder)
          : loader.LoadASCIIFromString(&model, &error, &warning, data.data(), size, folder);
  return is_read ? model : gltf::Model{};
}

const gltf::Material* material_of(const gltf::Model& model, const FrameMaterial& material) {
  const auto index = static_cast<std::size_t>(material.index);
  return index < model.materials.size() ? &model.materials[index] : nullptr;
}

}  // namespace

std::optional<MaterialLook> look_in_gltf(const FrameMaterial& material) {
  const gltf::Model model = load(material.file);
  const gltf::Material* found = material_of(model, material);
  if (!found) return {};
  const std::vector<double>& colour = found->pbrMetallicRoughness.baseColorFactor;
  MaterialLook look{{1, 1, 1}, 1, ""};
  if (colour.size() == 4) look = {{colour[0], colour[1], colour[2]}, colour[3], ""};
  if (const int texture = found->pbrMetallicRoughness.baseColorTexture.index;
      texture >= 0 && static_cast<std::size_t>(texture) < model.textures.size()) {
    const int source = model.textures[static_cast<std::size_t>(texture)].source;
    if (source >= 0 && static_cast<std::size_t>(source) < model.images.size())
      if (const std::string& uri = model.images[static_cast<std::size_t>(source)].uri; !uri.empty())
        look.picture = (std::filesystem::path(material.file).parent_path() / uri).lexically_normal().string();
  }
  return look;
}

int GlbMaterials::add(const FrameMaterial& material) {
  gltf::Material one = is_gltf_file(material.file) ? from_gltf(material) : from_mtl(material);
  one.name = material.name;
  model_.materials.push_back(std::move(one));
  return static_cast<int>(model_.materials.size()) - 1;
}

gltf::Material GlbMaterials::from_gltf(const FrameMaterial& material) {
  const auto file = files_.find(material.file);
  const gltf::Model& from =
      file != files_.end() ? file->second : files_.emplace(material.file, load(material.file)).first->second;
  const gltf::Material* found = material_of(from, material);
  if (!found) return {};
  gltf::Material one = *found;
  one.extensions.clear();  // they may name textures
  const auto move = [&](auto& texture) {
    // The frames have the first set of texture coordinates.
    if (texture.index >= 0)
      texture.index = texture.texCoord == 0 ? add_texture(material.file, from, texture.index) : -1;
    texture.extensions.clear();
  };
  move(one.pbrMetallicRoughness.baseColorTexture), move(one.pbrMetallicRoughness.metallicRoughnessTexture);
  move(one.normalTexture), move(one.occlusionTexture), move(one.emissiveTexture);
  return one;
}

gltf::Material GlbMaterials::from_mtl(const FrameMaterial& material) {
  const MaterialLook look = look_of(material);
  gltf::Material one;
  one.doubleSided = true;
  one.pbrMetallicRoughness.metallicFactor = 0, one.pbrMetallicRoughness.roughnessFactor = 0.8;
  one.pbrMetallicRoughness.baseColorFactor = {look.colour[0], look.colour[1], look.colour[2], look.opacity};
  if (look.opacity < 1) one.alphaMode = "BLEND";
  if (look.picture.empty()) return one;
  const auto [known, is_new] = textures_.try_emplace(look.picture, -1);
  if (is_new && std::filesystem::is_regular_file(look.picture)) {
    if (const int picture = add_picture(look.picture, read_whole(look.picture)); picture >= 0) {
      gltf::Texture texture;
      texture.source = picture;
      model_.textures.push_back(texture);
      known->second = static_cast<int>(model_.textures.size()) - 1;
    }
  }
  one.pbrMetallicRoughness.baseColorTexture.index = known->second;
  if (known->second >= 0) one.pbrMetallicRoughness.baseColorFactor = {1, 1, 1, look.opacity};  // MTL does not multiply
  return one;
}

int GlbMaterials::add_texture(const std::string& file, const gltf::Model& from, int texture) {
  const auto [known, is_new] = textures_.try_emplace(file + "#" + std::to_string(texture), -1);
  if (!is_new || static_cast<std::size_t>(texture) >= from.textures.size()) return known->second;
  gltf::Texture one = from.textures[static_cast<std::size_t>(texture)];
  if (one.source < 0 || static_cast<std::size_t>(one.source) >= from.images.size()) return -1;
  const gltf::Image& image = from.images[static_cast<std::size_t>(one.source)];
  one.source = add_picture(file + "#" + std::to_string(one.source),
                           {reinterpret_cast<const char*>(image.image.data()), image.image.size()});
  if (one.source < 0) return -1;
  model_.images[static_cast<std::size_t>(one.source)].name = image.name;
  if (one.sampler >= 0 && static_cast<std::size_t>(one.sampler) < from.samplers.size()) {
    model_.samplers.push_back(from.samplers[static_cast<std::size_t>(one.sampler)]);
    one.sampler = static_cast<int>(model_.samplers.size()) - 1;
  } else {
    one.sampler = -1;
  }
  one.extensions.clear();
  model_.textures.push_back(one);
  return known->second = static_cast<int>(model_.textures.size()) - 1;
}

int GlbMaterials::add_picture(const std::string& name, std::string_view bytes) {
  const std::string format = picture_format(bytes);
  if (format.empty()) return -1;
  const auto [known, is_new] = pictures_.try_emplace(name, -1);
  if (!is_new) return known->second;
  gltf::Image image;
  image.bufferView = add_bytes_(bytes), image.mimeType = format;
  model_.images.push_back(std::move(image));
  return known->second = static_cast<int>(model_.images.size()) - 1;
}

#endif

}  // namespace malha
