// SPDX-License-Identifier: Apache-2.0
#include "host/base/build_info.h"

namespace malha {

// CMakeLists.txt defines the macros for this file alone; that of glTF for others too.
const char* version() { return MALHA_VERSION; }
const char* compiler() { return MALHA_COMPILER; }
const char* flags() { return MALHA_FLAGS; }

bool has_gltf() { return MALHA_HAS_GLTF; }
bool has_pages() { return MALHA_HAS_PAGES; }
bool has_pictures() { return MALHA_HAS_PICTURES; }

}  // namespace malha
