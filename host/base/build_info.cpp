#include "host/base/build_info.h"

namespace malha {

// The three macros come from CMakeLists.txt, for this file alone.
const char* version() { return MALHA_VERSION; }
const char* compiler() { return MALHA_COMPILER; }
const char* flags() { return MALHA_FLAGS; }

}  // namespace malha
