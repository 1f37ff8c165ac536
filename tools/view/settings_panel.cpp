// SPDX-License-Identifier: Apache-2.0
#include <imgui.h>

#include "malha/text.h"
#include "tools/view/panels.h"

namespace malha::view {

namespace {

/// Returns true once a number was entered or a slider released.
bool done() { return ImGui::IsItemDeactivatedAfterEdit(); }

bool number(const char* name, double& value, const char* unit = "") {
  ImGui::InputDouble(name, &value, 0, 0, "%.6g");
  if (*unit && ImGui::IsItemHovered()) ImGui::SetTooltip("%s", unit);
  return done();
}
bool vector(const char* name, Vec3& value, const char* unit) {
  ImGui::InputScalarN(name, ImGuiDataType_Double, value.data(), 3, nullptr, nullptr, "%.4g");
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", unit);
  return done();
}
bool whole(const char* name, int& value) {
  ImGui::InputInt(name, &value, 0);
  return done();
}

bool solver(SolverSpec& spec) {
  bool changed = false;
  bool levels = spec.levels != 0;
  int method = spec.type == "pbd" ? 0 : 1, precision = spec.precision == Precision::Float ? 0 : 1;
  if (ImGui::Combo("method", &method, "pbd\0desbrun\0")) spec.type = method == 0 ? "pbd" : "desbrun", changed = true;
  changed |= number("dt", spec.dt, "s, of a step");
  changed |= whole("substeps", spec.substeps);
  changed |= whole("iterations", spec.iterations);
  if (ImGui::Combo("precision", &precision, "float\0double\0"))
    spec.precision = precision == 0 ? Precision::Float : Precision::Double, changed = true;
  if (spec.type == "pbd" && ImGui::Checkbox("levels where they help", &levels))
    spec.levels = levels ? kAutoLevels : 0, changed = true;
  if (spec.type == "desbrun") {
    changed |= number("spring constant", spec.desbrun.spring_constant, "N/m");
    changed |= whole("refinement_iterations", spec.desbrun.refinement_iterations);
  }
  return changed;
}

bool air(Scene& scene) {
  bool changed = vector("gravity", scene.gravity, "m/s^2"), on = scene.wind.has_value();
  if (ImGui::Checkbox("wind", &on)) {
    changed = true;
    scene.wind.reset();
    if (on) scene.wind.emplace(), scene.wind->velocity = {3, 0, 0}, scene.wind->density = 1.2;
  }
  if (!scene.wind) return changed;
  changed |= vector("velocity", scene.wind->velocity, "m/s");
  changed |= number("air density", scene.wind->density, "kg/m^3, of air that meets faces");
  changed |= number("drag", scene.wind->drag, "N s/m, of each particle");
  return changed;
}

bool constraint(ConstraintSpec& spec) {
  ImGui::TextUnformatted(spec.type.c_str());
  bool changed = false;
  if (spec.type == "long_range") {
    changed |= number("limit", spec.parameter, "times the distance to the pin along the surface at the start");
  } else if (spec.compliance) {
    changed |= number("compliance", *spec.compliance, "m/N of lengths, rad/(N m) of angles, m^5/N of volumes");
  } else if (spec.rigidity) {
    changed |= number("rigidity", *spec.rigidity, "of the material, see scenes/README.md");
  } else if (spec.young_modulus) {
    changed |= number("Young's modulus", *spec.young_modulus, "Pa of solids, N/m of membranes");
  } else {
    float stiffness = float(spec.stiffness);
    if (ImGui::SliderFloat("stiffness", &stiffness, 0, 1)) spec.stiffness = stiffness;
    changed |= done();
    if (ImGui::Button("give it a compliance")) spec.compliance = 1e-6, changed = true;
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("so that substeps and iterations do not change how stiff it is");
  }
  if (spec.orthotropy) changed |= number("that across", spec.orthotropy->across, "of the same unit");
  return changed;
}

bool bodies(Scene& scene) {
  bool changed = false;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    BodySpec& body = scene.bodies[b];
    ImGui::PushID(int(b));
    if (ImGui::TreeNodeEx("body", ImGuiTreeNodeFlags_DefaultOpen, "body '%s'", body.name.c_str())) {
      changed |= number("damping", body.damping, "[0, 1] a step");
      for (std::size_t c = 0; c < body.constraints.size(); ++c) {
        ImGui::PushID(int(c));
        changed |= constraint(body.constraints[c]);
        ImGui::PopID();
      }
      if (body.tear) changed |= number("tears at strain", body.tear->strain);
      ImGui::TreePop();
    }
    ImGui::PopID();
  }
  return changed;
}

bool obstacles(Scene& scene) {
  bool changed = false;
  for (std::size_t e = 0; e < scene.environment.size(); ++e) {
    EnvironmentSpec& one = scene.environment[e];
    ImGui::PushID(int(1000 + e));
    if (ImGui::TreeNode("object", "object '%s'", one.name.c_str())) {
      changed |= number("friction", one.friction, "Coulomb's coefficient");
      changed |= number("restitution", one.restitution, "[0, 1]");
      changed |= number("thickness", one.thickness, "m");
      ImGui::TreePop();
    }
    ImGui::PopID();
  }
  if (scene.self_collision && ImGui::TreeNode("self-collision")) {
    changed |= number("friction", scene.self_collision->friction, "Coulomb's coefficient");
    changed |= number("thickness", scene.self_collision->thickness, "m");
    ImGui::TreePop();
  }
  return changed;
}

}  // namespace

void settings_panel(const Snapshot& now, Session& session, Choices& choices, std::vector<Edited>& edited) {
  edited.resize(now.sides.size());
  for (std::size_t s = 0; s < now.sides.size(); ++s)
    if (edited[s].of != now.sides[s].scene || edited[s].refused != now.refused)
      edited[s] = {now.sides[s].scene, *now.sides[s].scene, now.refused};
  if (now.sides.empty()) return;
  choices.side = std::min(choices.side, now.sides.size() - 1);
  if (now.sides.size() == 2) {
    int side = int(choices.side);
    ImGui::RadioButton("left", &side, 0), ImGui::SameLine(), ImGui::RadioButton("right", &side, 1);
    choices.side = std::size_t(side);
  }
  const SideShown& shown_side = now.sides[choices.side];
  Scene& scene = edited[choices.side].scene;
  ImGui::PushID(int(choices.side));
  ImGui::PushItemWidth(0.5f * ImGui::GetContentRegionAvail().x);
  bool changed = solver(scene.solver);
  ImGui::Separator();
  changed |= air(scene);
  ImGui::Separator();
  changed |= bodies(scene), changed |= obstacles(scene);
  ImGui::PopItemWidth();
  ImGui::TextWrapped("A change sets the scene up again. The last time it took %.3g ms.", shown_side.set_up_ms);
  ImGui::PopID();
  if (changed) session.change(choices.side, scene);
}

}  // namespace malha::view
