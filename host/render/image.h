// SPDX-License-Identifier: Apache-2.0
// Images in memory, contact sheets of them, and their PNG files.
#pragma once
#include <filesystem>
#include <span>
#include <vector>

namespace malha {

/// sRGB, 8 bits a channel, three channels; rows from the top, pixels from the left.
struct Image {
  int width = 0, height = 0;          // pixels
  std::vector<unsigned char> pixels;  // 3 width height
};

/// Arranges the images in reading order, `columns` (>= 1) to a row, with a thin white margin around each. Cells are as
/// large as the largest image; smaller ones are centred. Returns an empty image for no images.
Image contact_sheet(std::span<const Image> images, int columns);

/// Writes the image as an 8-bit RGB PNG, completely or not at all. Throws std::runtime_error that names the path (full
/// disk, no folder), std::invalid_argument for an image without pixels.
void write_png(const std::filesystem::path& path, const Image& image);

}  // namespace malha
