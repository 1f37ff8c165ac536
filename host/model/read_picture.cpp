// SPDX-License-Identifier: Apache-2.0
// Reader of pictures for maps, by stb.
#include <memory>

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image.h>
#pragma GCC diagnostic pop

#include "host/base/file.h"
#include "host/model/vertex_map.h"
#include "malha/error.h"

namespace malha {

ChannelPicture read_picture(const std::string& path) {
  const std::string bytes = read_input(path, "a PNG or JPEG file");
  ChannelPicture picture;
  const std::unique_ptr<stbi_us, void (*)(void*)> pixels(
      stbi_load_16_from_memory(reinterpret_cast<const stbi_uc*>(bytes.data()), static_cast<int>(bytes.size()),
                               &picture.width, &picture.height, &picture.channels, 0),
      stbi_image_free);
  if (!pixels) refuse(path, "", std::string("no picture: ") + stbi_failure_reason(), "a PNG or JPEG file");
  const std::size_t count = static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height) *
                            static_cast<std::size_t>(picture.channels);
  for (std::size_t i = 0; i < count; ++i) picture.values.push_back(static_cast<float>(pixels.get()[i]) / 65535.0f);
  return picture;
}

}  // namespace malha
