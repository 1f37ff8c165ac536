// SPDX-License-Identifier: Apache-2.0
#include "host/report/report.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "host/base/build_info.h"
#include "host/model/tear.h"
#include "host/report/resolution.h"
#include "host/report/warnings.h"
#include "malha/text.h"

namespace malha {

namespace {

using Json = nlohmann::ordered_json;

std::string cpu_name() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.rfind("model name", 0) == 0 && line.find(": ") != std::string::npos)
      return line.substr(line.find(": ") + 2);
  return "unknown";
}

Json by_name(const NamedNumbers& parts) {
  Json json;
  for (const auto& [name, value] : parts) json[name] = value;
  return json;
}

Json constraints(const SolverStats& facts, const Model& model) {
  Json kinds = Json::object();
  for (const SetStats& set : facts.sets) {
    Json& kind =
        kinds.emplace(set.type, Json{{"count", 0}, {"contiguous", 0}, {"max_colors_per_patch", 0}}).first.value();
    kind["count"] = kind["count"].get<int>() + set.constraints;
    kind["contiguous"] = kind["contiguous"].get<int>() + set.in_runs;
    kind["max_colors_per_patch"] = std::max(kind["max_colors_per_patch"].get<int>(), set.most_batches);
  }
  for (const AttachmentSet& set : model.attached) {
    Json& kind = kinds.emplace("attachment", Json{{"count", 0}}).first.value();
    kind["count"] = kind["count"].get<std::size_t>() + set.particles.size();
  }
  for (const UserConstraintStats& own : facts.user_constraints) {
    Json& kind = kinds.emplace("user", Json{{"count", 0}, {"batches", 0}}).first.value();
    kind["count"] = kind["count"].get<int>() + own.constraints;
    kind["batches"] = kind["batches"].get<int>() + own.batches;
  }
  if (!model.pressures.empty()) kinds["pressure"] = {{"count", model.pressures.size()}};
  if (facts.long_range > 0) kinds["long_range"] = {{"count", facts.attachments}, {"particles", facts.long_range}};
  return kinds;
}

Json patches(const PatchStats& facts) {
  return {{"count", facts.patches},
          {"patch_colors", facts.colours},
          {"soa_patches", facts.columns},
          {"particles_shared", facts.shared},
          {"max_patch_slots", facts.most_slots}};
}

Json levels(const SolverStats& facts) {
  Json all = Json::array();
  for (const LevelStats& level : facts.levels)
    all.push_back(
        {{"particles", level.particles}, {"constraints", level.constraints}, {"patches", level.patches.patches}});
  return {{"every_substeps", facts.levels_interval},
          {"levels_fine_to_coarse", all},
          {"bytes", facts.level_bytes},
          {"setup_s", facts.level_seconds}};
}

Json filter(const Solver& solver, const Model& model) {
  const FilterStats& facts = *solver.facts().filter;
  const FilterErrors errors = *solver.filter_errors();
  const SolverSpec& spec = model.scene.solver;
  Json json{{"kind", facts.kind},
            {"why", facts.why},
            {"storage", facts.storage},
            {"particles", facts.unknowns},
            {"bodies", facts.bodies},
            {"bodies_free", solver.facts().free_bodies},
            {"nonzeros", facts.numbers},
            {"relative_error_random", errors.noise},
            {"relative_error_elastic", errors.elastic}};
  if (spec.type == "desbrun") {
    json["filter_external_forces"] = spec.desbrun.filter_external_forces;
    json["refinement_iterations"] = spec.desbrun.refinement_iterations;
  }
  return json;
}

Json timings(const Solver& solver, const RunTimes& times) {
  const StepStatistics& step = times.steps;
  if (step.count() == 0) return {{"steps", 0}};
  const auto steps = static_cast<double>(step.count());
  Json passes = Json::object();
  for (std::size_t k = 0; k < kPassNames.size(); ++k)
    if (solver.pass_seconds()[k] > 0)
      passes[std::string(kPassNames[k]) + "_ms"] = solver.pass_seconds()[k] * 1000 / steps;
  Json json{{"steps", step.count()},
            {"step_ms_median", median_step_ms(times)},
            {"step_ms_min", step.least() * 1000},
            {"step_ms_max", step.most() * 1000},
            {"step_ms_by_pass", passes}};
  for (const double level : solver.level_seconds()) json["step_ms_by_level"].push_back(level * 1000 / steps);
  if (times.steps_alone > 0) json["steps_on_one_thread"] = times.steps_alone;
  if (const auto projections = solver.facts().projections_per_step; projections > 0 && !solver.facts().filter)
    json["ns_per_projection"] = step.sum() * 1e9 / (steps * static_cast<double>(projections));
  return json;
}

Json by_kernel(const std::vector<Launches>& all) {
  Json kernels = Json::array();
  for (const auto& [kernel, launches, items] : all)
    kernels.push_back({{"kernel", kernel}, {"launches", launches}, {"items", items}});
  return kernels;
}

Json precision_of_positions(const Model& model, const std::vector<Vec3>& x) {
  const Resolution found = resolution(model, x);
  Json json{{"farthest_m", found.farthest}, {"spacing_m", found.spacing}};
  if (std::isfinite(found.edge)) json["shortest_edge_m"] = found.edge, json["strain"] = found.strain();
  return json;
}

Json measured(const Measures& m, const Scene& scene, const SolverStats& facts, const RunTimes& times) {
  const bool self_collision = scene.self_collision.has_value(), edges = facts.edges.has_value();
  Json json;
  const LargestStrains& run = times.strains;
  if (m.has_strain) {
    json["strain_rms"] = m.strain_rms, json["strain_max"] = m.strain_max;
    json["strain_max_of_run"] = std::max(m.strain_max, run.largest);
    if (run.largest > m.strain_max) json["strain_max_of_run_at_s"] = static_cast<double>(run.step) * scene.solver.dt;
    json["strain_sampled_every_steps"] = run.every;
  }
  if (facts.long_range > 0) json["long_range_beyond_max"] = run.beyond;
  json["momentum_kg_m_per_s"] = m.momentum;
  json["angular_momentum_kg_m2_per_s"] = m.angular_momentum;
  json["kinetic_energy_j"] = m.kinetic;
  json["potential_energy_j"] = m.potential;
  json["elastic_energy_j"] = m.elastic;
  json["energy_j"] = m.energy();
  json["speed_max_m_per_s"] = m.speed_max;
  json["contacts"] = m.contacts;
  json["penetration_max_m"] = m.penetration_max;
  if (!facts.deforming.empty()) json["max_pinched"] = m.max_pinched;
  if (self_collision) json["self_contacts"] = m.self_contacts;
  if (edges) json["edge_contacts"] = m.edge_contacts;
  if (self_collision || edges) {
    json["crossings"] = m.crossings;
    json["max_intersections"] = std::max(m.crossings, times.most_crossings);
    json["intersection_checks"] = times.crossings_counted + 1;
  }
  json["degenerate_constraints_skipped"] = m.degenerate;
  if (!m.volume_ratios.empty()) json["volume_ratios"] = m.volume_ratios;
  if (m.has_seams) json["max_seam_gap_m"] = m.max_seam_gap;
  if (m.has_tetrahedra) json["inverted_tetrahedra"] = m.inverted_tetrahedra;
  return json;
}

}  // namespace

std::string measures_json(const Model& model, const Solver& solver, const RunTimes& times) {
  return measured(solver.measure(), model.scene, solver.facts(), times).dump();
}

std::string report_json(const std::string& status, const std::vector<std::string>& notes, const Model& model,
                        const Solver& solver, int threads, const RunTimes& times, const std::string& folder) {
  const Scene& scene = model.scene;
  const SolverStats& facts = solver.facts();
  Json json;
  json["scene"] = scene.name;
  json["input"] = {{"scene", Json::parse(to_json(scene, folder))}};
  json["status"] = status;
  json["notes"] = notes;
  for (const std::string& note : model.notes) json["notes"].push_back(note);
  json["warnings"] = warnings(model);
  json["malha_version"] = version();
  json["compiler"] = compiler();
  json["flags"] = flags();
  json["cpu"] = cpu_name();
  json["threads"] = threads;
  json["instructions"] = facts.instructions;
  json["solver"] = {{"type", scene.solver.type},
                    {"precision", scene.solver.precision == Precision::Double ? "double" : "float"},
                    {"dt_s", scene.solver.dt},
                    {"substeps", scene.solver.substeps},
                    {"iterations", scene.solver.iterations}};
  json["particles"] = model.count();
  if (!model.free.empty()) json["momentum_corrected_bodies"] = model.free.size();
  if (!model.tetrahedra.empty()) {
    std::size_t all = 0;
    for (const auto& body : model.tetrahedra) all += body.size();
    json["tetrahedra"] = all;
  }
  json["constraints"] = constraints(facts, model);
  json["patches"] = patches(facts.patches);
  if (!facts.levels.empty()) json["levels"] = levels(facts);
  if (facts.filter) {
    const auto count = [&json](const std::string& type, std::size_t springs) {
      Json& all = json["springs"][type];
      all = springs + (all.is_null() ? 0 : all.get<std::size_t>());
    };
    for (const SpringSet& set : model.springs) count(set.type, set.ends.size());
    for (const ConstraintSet& set : model.stencils) count(set.type, set.count());
    json["filter"] = filter(solver, model);
  }
  if (can_tear(scene))
    json["tears"] = {{"splits", times.splits}, {"layouts", times.layouts}, {"layout_s", times.layout_seconds}};
  if (const auto& self = facts.self)
    json["self_collision"] = {{"particles", self->particles},
                              {"edges", self->edges},
                              {"triangles", self->triangles},
                              {"crossings_at_start", self->crossings},
                              {"searches", self->searches},
                              {"substeps_truncated", self->substeps_truncated},
                              {"substeps_kinematic_penetration", self->substeps_kinematic_penetration},
                              {"candidates", self->candidates},
                              {"pairs", self->pairs},
                              {"patch_colors", self->colours}};
  if (const auto& edges = facts.edges)
    json["environment_edges"] = {{"edges", edges->edges},
                                 {"corners", edges->corners},
                                 {"candidates", edges->candidates},
                                 {"pairs", edges->pairs},
                                 {"bytes", edges->bytes},
                                 {"searches", edges->searches},
                                 {"substeps_redetected", edges->substeps_redetected},
                                 {"substeps_truncated", edges->substeps_truncated}};
  json["zero_area_faces_dropped"] = model.zero_area_faces;
  json["setup_s"] = by_name(setup_parts(model, facts));
  // Sums over some parts: everything before the solver, and the constraints' share of colour and layout.
  json["setup_s"]["model"] = times.model_seconds;
  json["setup_s"]["constraints"] = facts.constraint_seconds;
  json["setup_s"]["total"] = times.model_seconds + times.solver_seconds;
  for (const auto& [owner, bytes] : memory_parts(model, facts))
    json["memory"][owner + "_bytes"] = static_cast<std::size_t>(bytes);
  json["memory"]["peak_mib"] = peak_memory_mib();
  if (!times.launches.empty()) json["launches_of_first_step"] = by_kernel(times.launches);
  json["timing"] = timings(solver, times);
  json["time_s"] = solver.time();
  json["step"] = solver.steps();
  if (status != "diverged") {
    const std::vector<Vec3> x = solver.positions();
    if (const std::string coarse = resolution_warning(model, x); !coarse.empty()) json["notes"].push_back(coarse);
    json["resolution"] = precision_of_positions(model, x);
    json["state"] = measured(solver.measure(), scene, facts, times);
    if (const auto sleep = solver.sleep()) {
      json["sleep"] = {{"particles", sleep->particles}};
      if (sleep->particles > 0) json["sleep"]["since_s"] = sleep->since;
    }
    json["state_hash"] = hex(solver.state_hash());
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";  // a path may have any bytes
}

}  // namespace malha
