// SPDX-License-Identifier: Apache-2.0
// A reader of PNG files by a library that has no part in writing them.
#pragma once
#include <string>

#include "host/render/image.h"

namespace malha {

/// The image in the bytes of a file with three channels. Throws std::runtime_error if they are no PNG.
Image read_png(const std::string& bytes);

}  // namespace malha
