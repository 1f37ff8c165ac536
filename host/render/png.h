// SPDX-License-Identifier: Apache-2.0
// Writer of PNG files.
#pragma once
#include <filesystem>

#include "host/render/image.h"

namespace malha {

/// Writes the image as an 8-bit RGB PNG, completely or not at all. Throws std::runtime_error that names the path (full
/// disk, no folder), std::invalid_argument for an image without pixels.
void write_png(const std::filesystem::path& path, const Image& image);

}  // namespace malha
