// SPDX-License-Identifier: Apache-2.0
// Panels of the window: settings, numbers and graphs, keys.
#pragma once
#include <string>
#include <vector>

#include "tools/view/colours.h"
#include "tools/view/session.h"

namespace malha::view {

/// The user's choices of display, which do not affect the simulation.
struct Choices {
  VisualField field = VisualField::Bodies;
  Surface surface = Surface::Shaded;
  bool panels = true, help = false, axes = true, pins = true;
  std::size_t side = 0;             // the side whose settings are shown
  std::vector<std::string> scenes;  // scene files that can be opened
};

/// A scene's settings while they are edited; edits that are not yet applied stay while frames come in.
struct Edited {
  std::shared_ptr<const Scene> of;
  Scene scene;
  int refused = 0;  // Snapshot::refused when the settings were copied
};

void run_panel(const Snapshot& now, Session& session, Choices& choices);
void settings_panel(const Snapshot& now, Session& session, Choices& choices, std::vector<Edited>& edited);
void numbers_panel(const Snapshot& now, const Choices& choices);
void timeline(const Snapshot& now, Session& session);
void help_panel(Choices& choices);
/// Adds a copy of the first side as a second one, restarted; removes the second side if there is one.
void toggle_second(const Snapshot& now, Session& session);

}  // namespace malha::view
