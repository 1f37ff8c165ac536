// SPDX-License-Identifier: Apache-2.0
#include "host/render/image.h"

#include <algorithm>
#include <stdexcept>

namespace malha {

Image contact_sheet(std::span<const Image> images, int columns) {
  if (columns < 1) throw std::invalid_argument("a contact sheet needs at least one column");
  if (images.empty()) return {};
  int cell_width = 0, cell_height = 0;
  for (const auto& image : images) {
    cell_width = std::max(cell_width, image.width);
    cell_height = std::max(cell_height, image.height);
  }
  const int margin = std::max(2, cell_width / 160);
  const int count = static_cast<int>(images.size());
  columns = std::min(columns, count);
  const int rows = (count + columns - 1) / columns;
  Image sheet;
  sheet.width = margin + columns * (cell_width + margin);
  sheet.height = margin + rows * (cell_height + margin);
  sheet.pixels.assign(std::size_t{3} * sheet.width * sheet.height, 255);
  for (int i = 0; i < count; ++i) {
    const Image& image = images[i];
    const int left = margin + (i % columns) * (cell_width + margin) + (cell_width - image.width) / 2;
    const int top = margin + (i / columns) * (cell_height + margin) + (cell_height - image.height) / 2;
    for (int y = 0; y < image.height; ++y) {
      const auto row = image.pixels.begin() + std::ptrdiff_t{3} * y * image.width;
      std::copy(row, row + std::ptrdiff_t{3} * image.width,
                sheet.pixels.begin() + std::ptrdiff_t{3} * ((top + y) * std::ptrdiff_t{sheet.width} + left));
    }
  }
  return sheet;
}

}  // namespace malha
