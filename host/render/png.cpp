// SPDX-License-Identifier: Apache-2.0
#include <stdexcept>
#include <string>

#include "host/base/file.h"
#include "host/render/image.h"

#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STBI_WRITE_NO_STDIO
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop

namespace malha {

void write_png(const std::filesystem::path& path, const Image& image) {
  if (image.width < 1 || image.height < 1 || image.pixels.size() != std::size_t{3} * image.width * image.height) {
    throw std::invalid_argument(path.string() + ": an image without pixels");
  }
  std::string bytes;
  const auto collect = [](void* to, void* data, int size) {
    static_cast<std::string*>(to)->append(static_cast<const char*>(data), static_cast<std::size_t>(size));
  };
  stbi_write_png_to_func(collect, &bytes, image.width, image.height, 3, image.pixels.data(), 3 * image.width);
  write_whole(path, bytes);
}

}  // namespace malha
