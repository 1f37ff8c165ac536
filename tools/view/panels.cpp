// SPDX-License-Identifier: Apache-2.0
#include "tools/view/panels.h"

#include <imgui.h>

#include <algorithm>

#include "tools/view/graphs.h"

namespace malha::view {

namespace {

struct Key {
  const char* keys;
  const char* what;
};
constexpr std::array kKeys{
    Key{"Space", "run, pause"},
    Key{". or Right", "one step"},
    Key{",", "one substep: show those of the next step, one after the other"},
    Key{"R", "reset: to the start of the scene"},
    Key{"Left, timeline", "show an earlier moment; the next step continues from there"},
    Key{"[ and ]", "slower, faster; \\ unlimited"},
    Key{"Left drag on a body", "pull a particle by a spring"},
    Key{"Ctrl + click on a particle", "pin it where it is, or release it"},
    Key{"Left drag beside bodies, right drag", "orbit"},
    Key{"Middle drag, Shift + left drag", "pan"},
    Key{"Wheel", "zoom"},
    Key{"F", "show all"},
    Key{"B", "throw a ball from here to the cursor"},
    Key{"C + left drag", "cut, where a body may tear"},
    Key{"1 to 9",
        "colours: bodies, strain, speed, residual, contacts, patches, colours of patches, batches, forces on pins"},
    Key{"W, Q, A", "wireframe, particles, axes"},
    Key{"D", "a copy of the scene beside it, restarted; again: remove it"},
    Key{"P", "save a picture"},
    Key{"Ctrl + S", "save scene and state, for malha run"},
    Key{"Tab", "panels on, off"},
    Key{"F1", "these keys"},
    Key{"Ctrl + Q", "quit"},
};

/// Adds a table row with a value of each side.
template <class Value>
void line_of_each(const Snapshot& now, const char* name, const Value& value) {
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  ImGui::TextUnformatted(name);
  for (const SideShown& side : now.sides) {
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(value(side).c_str());
  }
}

std::string text_of(double value, const char* unit) {
  char text[48];
  std::snprintf(text, sizeof text, "%.4g %s", value, unit);
  return text;
}

/// Returns a series of one side over the stored moments that have measures.
template <class Value>
Series series_of(const Snapshot& now, std::size_t side, const std::string& name, const Value& value) {
  Series series{name, {}, {}};
  for (const auto& moment : now.moments)
    if (const Frame& frame = *moment->frames[side]; frame.measures)
      series.times.push_back(frame.time), series.values.push_back(value(frame));
  return series;
}

void graphs_of(const Snapshot& now, std::size_t side) {
  const auto measured = [&](const std::string& name, auto value) {
    return series_of(now, side, name, [value](const Frame& frame) { return double(value(*frame.measures)); });
  };
  std::vector<Series> passes{series_of(now, side, "step", [](const Frame& frame) { return frame.step_ms; })};
  for (std::size_t p = 0; p < kPassNames.size(); ++p) {
    Series pass = series_of(now, side, kPassNames[p], [p](const Frame& frame) { return frame.pass_ms[p]; });
    const auto most = std::max_element(pass.values.begin(), pass.values.end());
    if (most != pass.values.end() && *most > 0) passes.push_back(std::move(pass));
  }
  graph("a step and its passes", "ms", passes);
  graph("energy", "J",
        {measured("kinetic", [](const Measures& m) { return m.kinetic; }),
         measured("potential", [](const Measures& m) { return m.potential; }),
         measured("elastic", [](const Measures& m) { return m.elastic; }),
         measured("sum", [](const Measures& m) { return m.energy(); })});
  graph("momentum", "kg m/s",
        {measured("x", [](const Measures& m) { return m.momentum[0]; }),
         measured("y", [](const Measures& m) { return m.momentum[1]; }),
         measured("z", [](const Measures& m) { return m.momentum[2]; })});
  graph("strain", "",
        {measured("largest", [](const Measures& m) { return m.strain_max; }),
         measured("RMS", [](const Measures& m) { return m.strain_rms; })});
  const Scene& scene = *now.sides[side].scene;
  if (!scene.environment.empty() || scene.self_collision)
    graph("contacts", "",
          {measured("environment", [](const Measures& m) { return m.contacts; }),
           measured("self", [](const Measures& m) { return m.self_contacts; }),
           measured("crossings", [](const Measures& m) { return m.crossings; })});
}

}  // namespace

void toggle_second(const Snapshot& now, Session& session) {
  if (now.sides.size() == 2)
    session.compare(std::nullopt);
  else if (!now.sides.empty())
    session.compare(*now.sides[0].scene);
}

void run_panel(const Snapshot& now, Session& session, Choices& choices) {
  if (ImGui::Button(now.running ? "pause" : "run")) session.run(!now.running);
  ImGui::SameLine();
  if (ImGui::Button("step")) session.step();
  ImGui::SameLine();
  if (ImGui::Button("substep")) session.substep();
  ImGui::SameLine();
  if (ImGui::Button("reset")) session.reset();
  if (ImGui::Button(now.sides.size() == 2 ? "one" : "two")) toggle_second(now, session);
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("the same scene twice, side by side, with settings of their own");
  ImGui::SameLine();
  if (ImGui::Button("keys")) choices.help = !choices.help;
  static constexpr std::array kPaces{0.0, 0.01, 0.1, 0.25, 0.5, 1.0, 2.0};
  static constexpr std::array kPaceNames{"as fast as it goes", "1/100 of real time", "1/10 of real time",
                                         "1/4 of real time",   "1/2 of real time",   "real time",
                                         "twice real time"};
  const auto found = std::find(kPaces.begin(), kPaces.end(), now.pace);
  const int pace = int(found - kPaces.begin());
  ImGui::PushItemWidth(-1);
  const std::string other = text_of(now.pace, "of real time");
  if (ImGui::BeginCombo("##pace", found == kPaces.end() ? other.c_str() : kPaceNames[std::size_t(pace)])) {
    for (std::size_t k = 0; k < kPaces.size(); ++k)
      if (ImGui::Selectable(kPaceNames[k], int(k) == pace)) session.set_pace(kPaces[k]);
    ImGui::EndCombo();
  }
  int field = int(choices.field), surface = int(choices.surface);
  if (ImGui::Combo("##visual field", &field, kVisualFieldNames.data(), int(kVisualFieldNames.size())))
    choices.field = VisualField(field), session.set_visual_field(choices.field);
  if (ImGui::Combo("##surface", &surface, "shaded\0wireframe\0particles\0")) choices.surface = Surface(surface);
  if (ImGui::BeginCombo("##scene", "open a scene ...")) {
    for (const std::string& path : choices.scenes)
      if (ImGui::Selectable(path.c_str())) session.open(path);
    ImGui::EndCombo();
  }
  ImGui::PopItemWidth();
}

void numbers_panel(const Snapshot& now, const Choices& choices) {
  if (now.sides.empty()) return;
  if (ImGui::BeginTable("numbers", 1 + int(now.sides.size()), ImGuiTableFlags_SizingStretchProp)) {
    line_of_each(now, "method", [](const SideShown& s) { return s.scene->solver.type; });
    line_of_each(now, "substeps", [](const SideShown& s) { return std::to_string(s.scene->solver.substeps); });
    line_of_each(now, "particles", [](const SideShown& s) { return std::to_string(s.frame->x.size()); });
    line_of_each(now, "time", [](const SideShown& s) { return text_of(s.frame->time, "s"); });
    line_of_each(now, "step", [](const SideShown& s) {
      return std::to_string(s.frame->steps) +
             (s.frame->substep > 0 ? " and substep " + std::to_string(s.frame->substep) : "");
    });
    line_of_each(now, "a step takes", [](const SideShown& s) { return text_of(s.frame->step_ms, "ms"); });
    line_of_each(now, "1 s simulated takes",
                 [](const SideShown& s) { return text_of(1e-3 * s.frame->step_ms / s.scene->solver.dt, "s"); });
    ImGui::EndTable();
  }
  if (now.running) ImGui::Text("%.2f of real time", now.share);
  if (now.apart) ImGui::Text("apart: RMS %.4g m, most %.4g m", (*now.apart)[0], (*now.apart)[1]);
  for (std::size_t s = 0; s < now.sides.size(); ++s)
    for (const std::string& warning : now.sides[s].warnings) {
      const char* whose = now.sides.size() < 2 ? "" : s == 0 ? "left: " : "right: ";
      ImGui::PushStyleColor(ImGuiCol_Text, ImVec4(1, 0.75f, 0.3f, 1));
      ImGui::TextWrapped("%s%s", whose, warning.c_str());
      ImGui::PopStyleColor();
    }
  graphs_of(now, std::min(choices.side, now.sides.size() - 1));
}

void timeline(const Snapshot& now, Session& session) {
  if (now.moments.empty() || now.sides.empty()) return;
  ImGui::PushItemWidth(-1);
  int moment = int(now.moment);
  const double time = now.sides.at(0).frame->time;
  char text[64];
  std::snprintf(text, sizeof text, "%.3f s", time);
  if (ImGui::SliderInt("##timeline", &moment, 0, std::max(int(now.moments.size()) - 1, 1), text))
    session.show(std::size_t(std::max(moment, 0)));
  ImGui::PopItemWidth();
}

void help_panel(Choices& choices) {
  if (!choices.help) return;
  ImGui::SetNextWindowPos(ImVec2(0.5f * ImGui::GetIO().DisplaySize.x, 0.5f * ImGui::GetIO().DisplaySize.y),
                          ImGuiCond_Appearing, ImVec2(0.5f, 0.5f));
  if (ImGui::Begin("keys", &choices.help, ImGuiWindowFlags_AlwaysAutoResize) &&
      ImGui::BeginTable("keys", 2, ImGuiTableFlags_SizingFixedFit)) {
    for (const Key& key : kKeys) {
      ImGui::TableNextRow();
      ImGui::TableNextColumn(), ImGui::TextUnformatted(key.keys);
      ImGui::TableNextColumn(), ImGui::TextUnformatted(key.what);
    }
    ImGui::EndTable();
  }
  ImGui::End();
}

}  // namespace malha::view
