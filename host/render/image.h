// SPDX-License-Identifier: Apache-2.0
// Pictures as pixels.
#pragma once
#include <span>
#include <vector>

namespace malha {

/// sRGB, 8 bits a channel, three channels; rows from the top, pixels from the left.
struct Image {
  int width = 0, height = 0;          // pixels
  std::vector<unsigned char> pixels;  // 3 width height
};

/// The images in reading order, `columns` (>= 1) to a row, with a thin white margin around each. Cells are as large as
/// the largest image; smaller ones are centred. No images give an empty one.
Image contact_sheet(std::span<const Image> images, int columns);

}  // namespace malha
