// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "host/report/amplification.h"
#include "host/report/device_estimate.h"
#include "host/report/plan.h"
#include "host/report/plan_passes.h"
#include "host/report/report.h"
#include "host/report/whole_steps.h"
#include "host/solver/solver.h"

namespace malha {

namespace {

using Json = nlohmann::ordered_json;

Json constraints(const Model& model, const SolverStats& facts) {
  Json all = Json::array();
  for (std::size_t s = 0; s < facts.sets.size(); ++s) {
    const SetStats& set = facts.sets[s];
    Json one{{"type", set.type},
             {"count", set.constraints},
             {"contiguous", set.in_runs},
             {"max_colors_per_patch", set.most_batches}};
    if (model.sets[s].compliance)
      one["compliance"] = *model.sets[s].compliance;
    else
      one["stiffness"] = model.sets[s].stiffness;
    all.push_back(one);
  }
  for (const PressureSet& set : model.pressures)
    all.push_back({{"type", "pressure"}, {"count", 1}, {"particles", set.particles.size()}});
  if (facts.long_range > 0)
    all.push_back({{"type", "long_range"}, {"count", facts.attachments}, {"particles", facts.long_range}});
  for (const AttachmentSet& set : model.attached)
    all.push_back({{"type", "attachment"}, {"count", set.particles.size()}});
  for (const SpringSet& set : model.springs)
    if (!set.ends.empty()) all.push_back({{"type", set.type}, {"count", set.ends.size()}, {"filtered", true}});
  for (const ConstraintSet& set : model.stencils)
    all.push_back({{"type", set.type}, {"count", set.count()}, {"filtered", true}});
  for (const UserConstraintStats& own : facts.user_constraints)
    all.push_back({{"type", "user"},
                   {"name", own.name},
                   {"count", own.constraints},
                   {"particles", own.particles},
                   {"batches", own.batches}});
  return all;
}

Json of_demand(const DeviceEstimate& demand) {
  Json json{{"machine", demand.machine.name}, {"launches_a_step", demand.launches}};
  if (demand.phases == 0) return json;
  json["patch_colors"] = demand.phases, json["groups_at_once"] = demand.at_once;
  json["groups_fewest"] = demand.groups_fewest, json["groups_most"] = demand.groups_most;
  json["group_bytes_most"] = demand.group_bytes, json["fits_fast_memory"] = !demand.is_too_large();
  json["particle_bytes_a_step"] = demand.moved.particle_bytes;
  json["constraint_bytes_a_step"] = demand.moved.constraint_bytes;
  json["bytes_per_second"] = demand.bytes_per_second, json["memory_ms"] = demand.ms();
  json["not_counted"] = demand.not_counted;
  return json;
}

}  // namespace

std::string plan_json(const Simulation& simulation, const DeviceEstimate* demand,
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
  json["constraints"] = constraints(model, facts);
  json["projections_a_step"] = facts.projections_per_step;
  json["patches"] = {{"count", facts.patches.patches},
                     {"patch_colors", facts.patches.phases},
                     {"soa_patches", facts.patches.columns},
                     {"max_patch_slots", facts.patches.most_slots}};
  json["levels"] = Json::array();
  for (const LevelStats& level : facts.levels)
    json["levels"].push_back({{"particles", level.particles}, {"constraints", level.constraints}});
  if (const auto& filter = facts.filter)
    json["filter"] = {{"kind", filter->kind}, {"why", filter->why}, {"storage", filter->storage}};
  json["launches_a_step"] = Json::object();
  for (const PassOfAStep& pass : passes_of_a_step(model, facts)) json["launches_a_step"][pass.name] = pass.launches;
  for (const auto& [owner, bytes] : memory_parts(model, facts))
    json["memory"][owner + "_bytes"] = static_cast<std::size_t>(bytes);
  json["memory"]["peak_mib"] = peak_memory_mib();
  json["memory"]["checkpoint_bytes"] = simulation.save_state().size();
  json["embree"] = !scene.environment.empty();
  for (const Launches& of : simulation.times().launches)
    json["launches_of_first_step"].push_back({{"kernel", of.kernel}, {"launches", of.launches}, {"items", of.items}});
  for (std::size_t body = 0; amplifications && body < amplifications->size(); ++body)
    if (const auto& of = (*amplifications)[body])
      json["amplification"].push_back({{"body", scene.bodies[body].name},
                                       {"of_a_substep", of->of_a_substep(solver)},
                                       {"growth_per_s", of->growth},
                                       {"damping_per_s", of->damping},
                                       {"measured_s", of->seconds}});
  if (demand) json["for"] = of_demand(*demand);
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";  // a name may have any bytes
}

}  // namespace malha
