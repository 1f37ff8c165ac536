// SPDX-License-Identifier: Apache-2.0
// Pictures of a run that has ended: of the state in its checkpoint, and a storyboard of its frames.
#pragma once
#include <string>

namespace malha {

/// Draws picture.png, and, where the folder has frames for ParaView (vtp) of the mesh as it was at the start, also
/// storyboard.png, as the scene's outputs.pictures say. The scene is that of report.json, whose meshes must still be
/// there. Gives back what was left out, a sentence for the user; "" if nothing was. Throws InputError for a folder
/// that no run left, or that a run is writing to; std::runtime_error where a picture cannot be written.
std::string redraw(const std::string& folder, int threads);

}  // namespace malha
