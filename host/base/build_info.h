// SPDX-License-Identifier: Apache-2.0
// What the library was built from and with, for reports and --version.
#pragma once

namespace malha {

/// "0.1.0"
const char* version();
/// The compiler's name and version: "GNU 12.2.0".
const char* compiler();
/// The flags that decide the code, without include paths and warnings: "-O3 -DNDEBUG -march=native ...".
const char* flags();
/// Whether it can write glTF: built with tinygltf.
bool has_gltf();

}  // namespace malha
