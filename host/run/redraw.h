// SPDX-License-Identifier: Apache-2.0
// Pictures of a finished run: of the state in its checkpoint, and a storyboard of its frames.
#pragma once
#include <string>

namespace malha {

/// Draws picture.png as the scene's outputs.pictures say, and storyboard.png if the folder has frames for ParaView
/// (vtp) of the mesh as it was at the start. The scene is that of report.json, whose meshes must still exist. Returns a
/// sentence for the user about what was left out; "" if nothing was. Throws InputError for a folder that no run wrote,
/// or that a run is writing to; std::runtime_error if a picture cannot be written.
std::string redraw(const std::string& folder, int threads);

}  // namespace malha
