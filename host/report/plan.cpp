// SPDX-License-Identifier: Apache-2.0
#include "host/report/plan.h"

#include <algorithm>
#include <cstdio>
#include <sstream>

#include "host/model/model.h"
#include "host/model/tear.h"
#include "host/report/plan_passes.h"
#include "host/report/report.h"
#include "host/report/resolution.h"
#include "host/report/whole_steps.h"
#include "host/solver/solver.h"
#include "malha/text.h"

namespace malha {

namespace {

std::string bytes(double size) {
  char text[32];
  if (size < 10'000)
    std::snprintf(text, sizeof text, "%.0f B", size);
  else if (size < 10'000'000)
    std::snprintf(text, sizeof text, "%.1f KiB", size / 1024);
  else
    std::snprintf(text, sizeof text, "%.1f MiB", size / 1048576);
  return text;
}

void list_constraints(std::ostream& out, const Model& model, const SolverStats& facts) {
  for (std::size_t s = 0; s < facts.sets.size(); ++s) {
    const SetStats& set = facts.sets[s];
    out << "  " << set.type << ": " << set.constraints << ", " << set.in_runs << " in runs, at most "
        << counted(set.most_batches, "batch", "batches") << " a patch, ";
    if (model.sets[s].compliance)
      out << "compliance " << *model.sets[s].compliance << "\n";
    else
      out << "stiffness " << model.sets[s].stiffness << "\n";
  }
  for (const PressureSet& set : model.pressures)
    out << "  pressure: 1 over " << set.particles.size() << " particles and " << set.triangles.size() << " triangles\n";
  if (facts.long_range > 0)
    out << "  long_range: " << facts.attachments << " on pins, of " << counted(facts.long_range, "particle") << "\n";
}

/// Pins that move or are released, and attachments.
void list_attachments(std::ostream& out, const Model& model) {
  const auto target = [&out](const Target& to) {
    if (!to.environment.empty()) out << " to '" << to.environment << "'";
    if (to.point) out << " to a point";
    if (!to.motion.empty()) out << " on " << counted(to.motion.size(), "keyframe");
  };
  for (const MovedPins& pins : model.moved) {
    out << "  " << counted(pins.particles.size(), "pin");
    target(pins.target);
    if (pins.release_time) out << ", released at " << *pins.release_time << " s";
    out << "\n";
  }
  for (const AttachmentSet& set : model.attached) {
    out << "  " << counted(set.particles.size(), "attachment");
    target(set.target);
    if (set.compliance)
      out << ", compliance " << *set.compliance;
    else
      out << ", stiffness " << set.stiffness;
    if (set.release_time) out << ", until " << *set.release_time << " s";
    out << "\n";
  }
}

void list_own(std::ostream& out, const SolverStats& facts) {
  for (const UserConstraintStats& own : facts.own)
    out << "  user '" << own.name << "': " << own.constraints << " of " << counted(own.particles, "particle") << " in "
        << counted(own.batches, "batch", "batches")
        << ", evaluated by the caller; prediction, projection and state are passes of their own\n";
}

void list_tears(std::ostream& out, const Scene& scene) {
  for (const BodySpec& body : scene.bodies)
    if (body.tear)
      out << "  '" << body.name << "' tears above a strain of " << body.tear->strain
          << ", after which all is laid out anew" << (scene.solver.type == "desbrun" ? " and factored" : "") << "\n";
}

/// Springs and their filter.
void list_springs(std::ostream& out, const Model& model, const SolverStats& facts) {
  if (!facts.filter) return;
  const FilterStats& filter = *facts.filter;
  out << "springs:\n";
  for (const SpringSet& set : model.springs) {
    const auto [softest, stiffest] = std::minmax_element(set.stiffness.begin(), set.stiffness.end());
    if (set.ends.empty()) continue;
    out << "  " << set.type << ": " << set.ends.size() << ", " << *softest;
    if (*softest != *stiffest) out << " to " << *stiffest;
    out << " N/m\n";
  }
  for (const ConstraintSet& set : model.stencils) {
    out << "  " << set.type << ": " << set.count() << ", compliance " << set.compliance.value_or(0);
    out << (set.softness.empty() ? "\n" : " times each one's own\n");
  }
  out << "filter: " << filter.kind << ", " << filter.storage << ", of " << counted(filter.unknowns, "particle")
      << " in " << counted(filter.bodies, "body", "bodies") << " (" << facts.free_bodies << " free), " << filter.numbers
      << " numbers\n  because: " << filter.why << "\n";
}

void list_self_collision(std::ostream& out, const Scene& scene, const SolverStats& facts) {
  if (!facts.self) return;
  out << "self-collision: " << facts.self->particles << " particles, " << facts.self->edges << " edges and "
      << facts.self->triangles << " triangles, " << scene.self_collision->thickness << " m apart, friction "
      << scene.self_collision->friction << "\n";
}

void list_levels(std::ostream& out, const SolverStats& facts) {
  if (facts.levels.empty()) return;
  out << "levels: " << facts.levels.size() << ", every " << counted(facts.levels_interval, "substep") << "\n";
  for (const LevelStats& level : facts.levels)
    out << "  " << counted(level.particles, "particle") << ", " << counted(level.constraints, "constraint") << " in "
        << counted(level.patches.patches, "patch", "patches") << "\n";
}

void list_edges(std::ostream& out, const SolverStats& facts) {
  if (const auto& edges = facts.edges)
    out << "edges: " << edges->edges << " edges and " << edges->corners
        << " corners of the environment can touch, beside its faces; " << bytes(static_cast<double>(edges->bytes))
        << ", and what pairs take\n";
}

/// Every pass that exists in this scene, in its order, with its launches a step.
void list_passes(std::ostream& out, const Model& model, const SolverStats& facts) {
  for (const PassOfAStep& pass : passes_of_a_step(model, facts)) {
    out << "  " << pass.name << ": " << (pass.at_least ? "at least " : "");
    out << counted(pass.launches, "launch", "launches") << pass.remark << "\n";
  }
}

void list_memory(std::ostream& out, const Model& model, const SolverStats& facts) {
  out << "memory:\n";
  for (const auto& [owner, count] : memory_parts(model, facts))
    if (count > 0)
      out << "  " << owner << ": " << bytes(count)
          << (owner != "collision"        ? "\n"
              : model.environment.empty() ? ", and what contacts take\n"
              : facts.self                ? " and Embree's own, and what contacts take\n"
                                          : " and Embree's own\n");
}

}  // namespace

std::string plan(const Simulation& simulation) {
  const Model& model = simulation.model();
  const SolverStats& facts = simulation.solver().facts();
  const Scene& scene = model.scene;
  const SolverSpec& solver = scene.solver;
  std::ostringstream out;
  out << "scene: " << scene.name << "\n"
      << "solver: " << solver.type << ", " << (solver.precision == Precision::Double ? "double" : "float")
      << " precision, " << counted(simulation.threads(), "thread") << "\n"
      << "steps: " << whole_steps(scene.duration, solver.dt) << " of " << solver.dt << " s, each "
      << counted(solver.substeps, "substep") << " of " << (solver.type == "desbrun" ? "at most " : "")
      << counted(solver.iterations, "iteration") << "\n";
  if (const std::string rounding = rounding_of("the duration", scene.duration, solver.dt); !rounding.empty())
    out << "  " << rounding << "\n";
  out << "particles: " << model.count() << " in " << counted(scene.bodies.size(), "body", "bodies") << ", "
      << pinned_at_start(model) << " pinned\n";
  if (!model.free.empty())
    out << "corrector: keeps the momenta of " << counted(model.free.size(), "free body", "free bodies") << "\n";
  if (scene.sleep)
    out << "sleep: when no particle has been faster than " << scene.sleep->speed << " m/s for " << scene.sleep->after
        << " s\n";
  if (const std::string coarse = coarse_resolution(model, model.render_mesh.points); !coarse.empty())
    out << "resolution: " << coarse << "\n";
  for (const auto& body : model.tetrahedra) out << "tetrahedra: " << body.size() << "\n";
  if (model.zero_area_faces > 0) out << "left out: " << counted(model.zero_area_faces, "face") << " without area\n";
  if (facts.projections_per_step > 0)
    out << "constraints: " << counted(facts.projections_per_step, "projection") << " a step\n";
  if (!facts.sets.empty())
    out << "patches: " << facts.patches.patches << " in " << counted(facts.patches.phases, "phase") << ", of at most "
        << counted(facts.patches.most_slots, "slot") << " of fast memory, " << facts.patches.columns
        << " of them laid out for runs\n";
  list_constraints(out, model, facts);
  list_attachments(out, model);
  list_own(out, facts);
  list_tears(out, scene);
  list_levels(out, facts);
  list_springs(out, model, facts);
  list_self_collision(out, scene, facts);
  list_edges(out, facts);
  out << "passes of a step:\n";
  list_passes(out, model, facts);
  list_memory(out, model, facts);
  if (scene.environment.empty())
    out << "Embree: no (no environment)\n";
  else
    out << "Embree: yes, for " << counted(scene.environment.size(), "environment object") << "\n";
  return out.str();
}

std::string list_process_memory(const Simulation& simulation) {
  const std::string peak = bytes(peak_memory_mib() * 1024 * 1024),
                    state = bytes(double(simulation.save_state().size()));
  return "memory of the process: " + peak + " so far, and " + state + " more while a checkpoint is written\n";
}

std::string list_launches(const Simulation& simulation) {
  std::ostringstream out;
  for (const Launches& of : simulation.times().launches)
    out << "  " << of.kernel << ": " << counted(of.launches, "launch", "launches") << ", " << counted(of.items, "item")
        << "\n";
  return out.str().empty() ? "" : "kernels that the first step launched:\n" + out.str();
}

}  // namespace malha
