// SPDX-License-Identifier: Apache-2.0
// Version, compiler and flags of the build, for reports and --version.
#pragma once

namespace malha {

/// Version of the library, such as "0.1.0".
const char* version();
/// The compiler's name and version: "GNU 12.2.0".
const char* compiler();
/// The flags that affect the code, without include paths and warnings: "-O3 -DNDEBUG -march=native ...".
const char* flags();
/// Tells whether the library can read and write glTF, which needs tinygltf.
bool has_gltf();
/// Tells whether it can write pages (MALHA_PAGES), and pictures (MALHA_PICTURES).
bool has_pages();
bool has_pictures();

}  // namespace malha
