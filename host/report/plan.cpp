// SPDX-License-Identifier: Apache-2.0
#include "host/report/plan.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string_view>

#include "host/model/model.h"
#include "host/report/amplification.h"
#include "host/report/device_estimate.h"
#include "host/report/plan_passes.h"
#include "host/report/report.h"
#include "host/report/resolution.h"
#include "host/report/whole_steps.h"
#include "host/solver/solver.h"
#include "malha/text.h"

namespace malha {

namespace {

using Json = nlohmann::ordered_json;

template <class Set>
void add_material(Json& json, const Set& set) {
  if (set.compliance)
    json["compliance"] = *set.compliance;
  else
    json["stiffness"] = set.stiffness;
}

void add_target(Json& json, const Target& target, const std::optional<double>& release_time) {
  if (!target.environment.empty()) json["environment"] = target.environment;
  if (target.deforms) json["follows_triangles"] = true;
  if (target.point) json["to_point"] = true;
  if (!target.motion.empty()) json["keyframes"] = target.motion.size();
  if (release_time) json["release_time_s"] = *release_time;
}

Json constraints(const Model& model, const SolverStats& facts) {
  Json all = Json::array();
  for (std::size_t s = 0; s < facts.sets.size(); ++s) {
    const SetStats& set = facts.sets[s];
    all.push_back({{"type", set.type},
                   {"count", set.constraints},
                   {"contiguous", set.in_runs},
                   {"max_colors_per_patch", set.most_batches}});
    add_material(all.back(), model.sets[s]);
    if (const double rate = model.sets[s].per_closing; rate > 0) all.back()["closing_s"] = 1 / rate;
  }
  for (const PressureSet& set : model.pressures)
    all.push_back(
        {{"type", "pressure"}, {"count", 1}, {"particles", set.particles.size()}, {"triangles", set.triangles.size()}});
  if (facts.long_range > 0)
    all.push_back({{"type", "long_range"}, {"count", facts.attachments}, {"particles", facts.long_range}});
  for (const AttachmentSet& set : model.attached) {
    all.push_back({{"type", "attachment"}, {"count", set.particles.size()}});
    add_material(all.back(), set), add_target(all.back(), set.target, set.release_time);
  }
  for (const SpringSet& set : model.springs) {
    if (set.ends.empty()) continue;
    const auto [softest, stiffest] = std::minmax_element(set.stiffness.begin(), set.stiffness.end());
    all.push_back({{"type", set.type},
                   {"count", set.ends.size()},
                   {"filtered", true},
                   {"stiffness_min_n_per_m", *softest},
                   {"stiffness_max_n_per_m", *stiffest}});
  }
  for (const ConstraintSet& set : model.stencils) {
    all.push_back({{"type", set.type}, {"count", set.count()}, {"filtered", true}});
    all.back()["compliance"] = set.compliance.value_or(0), all.back()["compliance_scaled"] = !set.softness.empty();
  }
  for (const UserConstraintStats& own : facts.user_constraints)
    all.push_back({{"type", "user"},
                   {"name", own.name},
                   {"count", own.constraints},
                   {"particles", own.particles},
                   {"batches", own.batches}});
  return all;
}

/// Parts of a scene that most scenes lack.
void add_optional_parts(Json& json, const Model& model, const SolverStats& facts) {
  const Scene& scene = model.scene;
  if (scene.solver.type == "desbrun") json["solver"]["iterations_are_limit"] = true;
  if (const std::string rounding = rounding_of("the duration", scene.duration, scene.solver.dt); !rounding.empty())
    json["duration_rounding"] = rounding;
  if (const std::string coarse = resolution_warning(model, model.render_mesh.points); !coarse.empty())
    json["resolution"] = coarse;
  if (!model.free.empty()) json["momentum_corrected_bodies"] = model.free.size();
  if (scene.sleep) json["sleep"] = {{"below_speed_m_per_s", scene.sleep->speed}, {"after_s", scene.sleep->after}};
  for (const auto& body : model.tetrahedra) json["tetrahedra_by_body"].push_back(body.size());
  if (model.zero_area_faces > 0) json["zero_area_faces_dropped"] = model.zero_area_faces;
  for (const MovedPins& pins : model.moved) {
    json["moved_pins"].push_back({{"count", pins.particles.size()}});
    add_target(json["moved_pins"].back(), pins.target, pins.release_time);
  }
  for (const BodySpec& body : scene.bodies)
    if (body.tear) json["tears"].push_back({{"body", body.name}, {"above_strain", body.tear->strain}});
  if (const auto& self = facts.self)
    json["self_collision"] = {{"particles", self->particles},
                              {"edges", self->edges},
                              {"triangles", self->triangles},
                              {"thickness_m", scene.self_collision->thickness},
                              {"friction", scene.self_collision->friction}};
  for (const DeformingStats& object : facts.deforming)
    json["deforming_objects"].push_back(
        {{"name", object.name}, {"triangles", object.triangles}, {"bytes", object.bytes}});
  if (const auto& edges = facts.edges)
    json["environment_edges"] = {{"edges", edges->edges}, {"corners", edges->corners}, {"bytes", edges->bytes}};
}

Json json_of(const DeviceEstimate& estimate) {
  const Machine& machine = estimate.machine;
  Json json{{"machine", machine.name},
            {"description", machine.what},
            {"launches_a_step", estimate.launches},
            {"launches_are_minimum", estimate.launches_at_least},
            {"launches_recorded", estimate.replays}};
  if (estimate.colours == 0) return json;
  json["patch_colors"] = estimate.colours, json["groups_at_once"] = estimate.groups_at_once;
  json["groups_fewest"] = estimate.groups_fewest, json["groups_most"] = estimate.groups_most;
  json["group_bytes_most"] = estimate.group_bytes, json["group_bytes_available"] = machine.fast_bytes;
  json["fits_fast_memory"] = !estimate.is_too_large();
  json["particle_bytes_a_step"] = estimate.traffic.particle_bytes;
  json["constraint_bytes_a_step"] = estimate.traffic.constraint_bytes;
  json["bytes_per_second"] = estimate.bytes_per_second, json["bandwidth_measured"] = !(machine.bytes_per_second > 0);
  json["memory_ms"] = estimate.ms(), json["not_counted"] = estimate.not_counted;
  return json;
}

Json json_of(const StepPlan& plan, bool has_environment) {
  Json json{{"patch_solves", name_of(plan.solves)}, {"recorded", name_of(plan.recorded)}};
  if (has_environment) json["skips_contacts"] = plan.skips_contacts;
  for (const Stage stage : plan.substep) json["substep"].push_back(name_of(stage));
  json["iteration"] = Json::array();
  for (const IterationStage stage : plan.iteration) json["iteration"].push_back(name_of(stage));
  return json;
}

Json data_of(const Simulation& simulation, const DeviceEstimate* estimate,
             const std::vector<std::optional<Amplification>>* amplifications) {
  const Model& model = simulation.model();
  const SolverStats& facts = simulation.solver().facts();
  const Scene& scene = model.scene;
  const SolverSpec& solver = scene.solver;
  Json json{{"scene", scene.name}};
  json["solver"] = {{"type", solver.type},
                    {"precision", solver.precision == Precision::Double ? "double" : "float"},
                    {"dt_s", solver.dt},
                    {"substeps", solver.substeps},
                    {"iterations", solver.iterations}};
  json["threads"] = simulation.threads(), json["instructions"] = facts.instructions;
  json["steps"] = whole_steps(scene.duration, solver.dt);
  json["bodies"] = scene.bodies.size(), json["particles"] = model.count();
  json["particles_pinned"] = pinned_at_start(model);
  add_optional_parts(json, model, facts);
  json["constraints"] = constraints(model, facts);
  json["projections_a_step"] = facts.projections_per_step;
  json["patches"] = {{"count", facts.patches.patches},
                     {"patch_colors", facts.patches.colours},
                     {"soa_patches", facts.patches.columns},
                     {"max_patch_slots", facts.patches.most_slots}};
  json["levels"] = Json::array();
  for (const LevelStats& level : facts.levels)
    json["levels"].push_back(
        {{"particles", level.particles}, {"constraints", level.constraints}, {"patches", level.patches.patches}});
  if (!facts.levels.empty()) json["levels_interval"] = facts.levels_interval;
  if (const auto& filter = facts.filter)
    json["filter"] = {{"kind", filter->kind},          {"why", filter->why},       {"storage", filter->storage},
                      {"particles", filter->unknowns}, {"bodies", filter->bodies}, {"bodies_free", facts.free_bodies},
                      {"nonzeros", filter->numbers}};
  json["step"] = json_of(simulation.solver().step_plan(), !model.environment.empty());
  json["launches_a_step"] = Json::object();
  for (const StepPass& pass : step_passes(model, simulation.solver())) {
    json["launches_a_step"][pass.name] = pass.launches;
    if (!pass.remark.empty()) json["launches_remarks"][pass.name] = pass.remark;
  }
  for (const auto& [owner, bytes] : memory_parts(model, facts))
    json["memory"][owner + "_bytes"] = static_cast<std::size_t>(bytes);
  json["memory"]["peak_mib"] = peak_memory_mib();
  json["memory"]["checkpoint_bytes"] = simulation.save_state().size();
  if (mesh_count(model) > 0) json["memory_not_counted"].push_back("Embree");
  if (facts.self || facts.edges) json["memory_not_counted"].push_back("pairs in contact");
  json["embree"] = mesh_count(model) > 0;
  if (!scene.environment.empty()) json["environment_objects"] = scene.environment.size();
  for (const Launches& of : simulation.times().launches)
    json["launches_of_first_step"].push_back({{"kernel", of.kernel}, {"launches", of.launches}, {"items", of.items}});
  for (std::size_t body = 0; amplifications && body < amplifications->size(); ++body)
    if (const auto& of = (*amplifications)[body])
      json["amplification"].push_back({{"body", scene.bodies[body].name},
                                       {"of_a_substep", of->of_a_substep(solver)},
                                       {"growth_per_s", of->growth},
                                       {"damping_per_s", of->damping},
                                       {"measured_s", of->seconds}});
  if (estimate) json["for"] = json_of(*estimate);
  return json;
}

/// Returns whether the text leaves an entry out.
bool is_empty(const Json& value) {
  if (value.is_number()) return value == 0;
  return value.is_structured() && std::all_of(value.begin(), value.end(), is_empty);
}

std::string bytes_text(double size) {
  char text[32];
  if (size < 10'000)
    std::snprintf(text, sizeof text, "%.0f B", size);
  else if (size < 10'000'000)
    std::snprintf(text, sizeof text, "%.1f KiB", size / 1024);
  else
    std::snprintf(text, sizeof text, "%.1f MiB", size / 1048576);
  return text;
}

/// Returns an entry as its name and value, separated by `between`; the suffix of the name becomes the unit.
std::string entry(std::string name, const Json& value, const char* between) {
  constexpr std::pair<const char*, const char*> kUnits[]{{"_m_per_s", "m/s"}, {"_n_per_m", "N/m"}, {"_per_s", "1/s"},
                                                         {"_ms", "ms"},       {"_mib", "MiB"},     {"_s", "s"},
                                                         {"_m", "m"}};
  if (value.is_boolean()) return name + between + (value.get<bool>() ? "yes" : "no");
  if (value.is_string()) return name + between + value.get<std::string>();
  if (value.is_array()) {
    std::string all;
    for (const Json& one : value)
      all += (all.empty() ? "" : ", ") + (one.is_string() ? one.get<std::string>() : one.dump());
    return name + between + all;
  }
  if (name.find("bytes") != std::string::npos && !name.ends_with("_second")) {
    if (name.ends_with("_bytes")) name.resize(name.size() - 6);
    return name + between + bytes_text(value.get<double>());
  }
  const std::string number = value.is_number_float() ? shown(value.get<double>()) : value.dump();
  for (const auto& [suffix, unit] : kUnits)
    if (name.ends_with(suffix)) return name.substr(0, name.rfind(suffix)) + between + number + " " + unit;
  return name + between + number;
}

/// Returns an object in a list as one line, which starts with its name if it has one.
std::string line(const Json& object) {
  std::string text;
  for (const auto& [name, value] : object.items())
    if (text.empty() && value.is_string())
      text = value.get<std::string>() + ": ";
    else if (!is_empty(value))
      text += (text.empty() || text.ends_with(": ") ? "" : ", ") + entry(name, value, " ");
  return text;
}

std::string text_of(const Json& object, const std::string& indent = "") {
  std::string text;
  for (const auto& [name, value] : object.items()) {
    if (is_empty(value)) continue;
    if (value.is_object()) {
      text += indent + name + ":\n" + text_of(value, indent + "  ");
    } else if (value.is_array() && value[0].is_object()) {
      text += indent + name + ":\n";
      for (const Json& one : value) text += indent + "  " + line(one) + "\n";
    } else {
      text += indent + entry(name, value, ": ") + "\n";
    }
  }
  return text;
}

}  // namespace

std::string plan_json(const Simulation& simulation, const DeviceEstimate* estimate,
                      const std::vector<std::optional<Amplification>>* amplifications) {
  const Json json = data_of(simulation, estimate, amplifications);
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";  // a name may have any bytes
}

std::string plan(const Simulation& simulation, const DeviceEstimate* estimate,
                 const std::vector<std::optional<Amplification>>* amplifications) {
  return text_of(data_of(simulation, estimate, amplifications));
}

}  // namespace malha
