// SPDX-License-Identifier: Apache-2.0
// Takes the place of png.cpp in a build without MALHA_PICTURES.
#include "host/render/image.h"
#include "malha/error.h"

namespace malha {

void write_png(const std::filesystem::path& path, const Image&) {
  refuse(path.string(), "", "a picture, and this malha was built with MALHA_PICTURES=OFF", "no pictures");
}

}  // namespace malha
