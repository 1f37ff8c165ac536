// SPDX-License-Identifier: Apache-2.0
// Readers of mesh formats, used by read_mesh(). `file` names the input in messages, `data` is its whole content.
#pragma once
#include <string>
#include <string_view>

#include "malha/mesh.h"

namespace malha {

Mesh read_obj(const std::string& file, std::string_view data);
Mesh read_off(const std::string& file, std::string_view data);
Mesh read_ply(const std::string& file, std::string_view data);
Mesh read_stl(const std::string& file, std::string_view data);
Mesh read_medit(const std::string& file, std::string_view data);
Mesh read_gmsh(const std::string& file, std::string_view data);
Mesh read_tetgen(const std::string& node_file, std::string_view node_data, const std::string& ele_file,
                 std::string_view ele_data);

}  // namespace malha
