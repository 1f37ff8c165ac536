// SPDX-License-Identifier: Apache-2.0
// PNG files read back by a library that has no part in writing them.
#pragma once
#include <string>

#include "host/render/image.h"

namespace malha {

/// Of the bytes of a file with three channels. Throws std::runtime_error for what is no PNG.
Image read_png(const std::string& bytes);

}  // namespace malha
