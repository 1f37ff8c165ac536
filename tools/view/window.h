// SPDX-License-Identifier: Apache-2.0
// The window: its options and its main loop.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "malha/simulation.h"

namespace malha::view {

struct WindowOptions {
  std::vector<std::string> scenes;  // none, one, or two to compare
  std::filesystem::path out;        // folder of saved files
  int width = 1280, height = 800;   // pixels
  SimulationOptions simulation;
};

/// Opens the window and returns when it is closed. Throws InputError for a scene that cannot be opened,
/// std::runtime_error without a display or OpenGL 3.3.
void show_window(const WindowOptions& options);

}  // namespace malha::view
