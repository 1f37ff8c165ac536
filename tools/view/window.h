// SPDX-License-Identifier: Apache-2.0
// The window: what is seen, and what mouse and keys do.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "malha/simulation.h"

namespace malha::view {

struct WindowOptions {
  std::vector<std::string> scenes;  // none, one, or two to compare
  std::filesystem::path out;        // folder of what is saved
  int width = 1280, height = 800;   // pixels
  SimulationOptions simulation;
};

/// Opens the window and returns when it is closed. Throws InputError for a scene that cannot be opened,
/// std::runtime_error where there is no display or no OpenGL 3.3.
void show_window(const WindowOptions& options);

}  // namespace malha::view
