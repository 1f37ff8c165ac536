// SPDX-License-Identifier: Apache-2.0
// The panels of the window: what can be set while it runs, numbers and graphs, the keys.
#pragma once
#include <string>
#include <vector>

#include "tools/view/colours.h"
#include "tools/view/session.h"

namespace malha::view {

/// What the person has chosen; nothing of it changes what is simulated.
struct Choices {
  Look look = Look::Bodies;
  Surface surface = Surface::Shaded;
  bool panels = true, help = false, axes = true, pins = true;
  std::size_t side = 0;             // whose settings are shown
  std::vector<std::string> scenes;  // that can be opened
};

/// A scene's settings as they are typed; what is not yet applied stays while frames come in.
struct Edited {
  std::shared_ptr<const Scene> of;
  Scene scene;
  int refused = 0;  // how many changes were when it was taken over
};

void run_panel(const Snapshot& now, Session& session, Choices& choices);
void settings_panel(const Snapshot& now, Session& session, Choices& choices, std::vector<Edited>& edited);
void numbers_panel(const Snapshot& now, const Choices& choices);
void timeline(const Snapshot& now, Session& session);
void help_panel(Choices& choices);
/// The scene of the first side twice; where there are two sides, one again.
void toggle_second(const Snapshot& now, Session& session);

}  // namespace malha::view
