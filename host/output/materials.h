// SPDX-License-Identifier: Apache-2.0
// Materials of frames: those of the bodies' OBJ and glTF files, for other programs. malha itself draws without them.
#pragma once
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/output/frames.h"

namespace malha {

inline constexpr char kMaterialFile[] = "materials.mtl";

/// The look is what most programs know of a material.
struct MaterialLook {
  std::array<double, 3> colour{0.8, 0.8, 0.8};  // linear
  double opacity = 1;
  std::string picture;  // path of the picture of its colour; "": none
};

/// Returns the look of a material; the default where its file does not say or cannot be read.
MaterialLook look_of(const FrameMaterial& material);

/// Writes the materials into the folder as kMaterialFile, if there are any: the lines of the MTL files that the bodies'
/// OBJ files name, with paths of pictures that hold from the folder. Throws std::runtime_error (disk).
void write_mtl(const std::filesystem::path& folder, const FrameTopology& topology);

/// The format of a picture's bytes: "image/png", "image/jpeg", or "" for any other.
std::string picture_format(std::string_view bytes);

/// Returns the look of a material of a glTF file; none if it cannot be read.
std::optional<MaterialLook> look_in_gltf(const FrameMaterial& material);

}  // namespace malha
