// SPDX-License-Identifier: Apache-2.0
#include "host/base/build_info.h"

namespace malha {

// CMakeLists.txt defines the macros, all but the last one for this file alone.
const char* version() { return MALHA_VERSION; }
const char* compiler() { return MALHA_COMPILER; }
const char* flags() { return MALHA_FLAGS; }

bool has_gltf() {
#ifdef MALHA_HAS_GLTF
  return true;
#else
  return false;
#endif
}

}  // namespace malha
