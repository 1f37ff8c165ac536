#include "host/results/plan.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <sstream>

#include "host/base/shown.h"
#include "host/model/model.h"
#include "host/model/tear.h"
#include "host/results/report.h"
#include "host/results/resolution.h"
#include "host/results/whole_steps.h"
#include "host/solver/solver.h"

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

void list_constraints(std::ostream& out, const Model& model, const SolverFacts& facts) {
  for (std::size_t s = 0; s < facts.sets.size(); ++s) {
    const SetFacts& set = facts.sets[s];
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
    if (pins.until) out << ", released at " << *pins.until << " s";
    out << "\n";
  }
  for (const AttachmentSet& set : model.attached) {
    out << "  " << counted(set.particles.size(), "attachment");
    target(set.target);
    if (set.compliance)
      out << ", compliance " << *set.compliance;
    else
      out << ", stiffness " << set.stiffness;
    if (set.until) out << ", until " << *set.until << " s";
    out << "\n";
  }
}

void list_own(std::ostream& out, const SolverFacts& facts) {
  for (const OwnFacts& own : facts.own)
    out << "  own '" << own.name << "': " << own.constraints << " of " << counted(own.particles, "particle") << " in "
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
void list_springs(std::ostream& out, const Model& model, const SolverFacts& facts) {
  if (!facts.filter) return;
  const FilterFacts& filter = *facts.filter;
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

void list_self_collision(std::ostream& out, const Scene& scene, const SolverFacts& facts) {
  if (!facts.self) return;
  out << "self-collision: " << facts.self->particles << " particles, " << facts.self->edges << " edges and "
      << facts.self->triangles << " triangles, " << scene.self_collision->thickness << " m apart, friction "
      << scene.self_collision->friction << "\n";
}

void list_levels(std::ostream& out, const Model& model, const SolverFacts& facts) {
  if (facts.levels.empty()) return;
  out << "levels: " << facts.levels.size() << ", every " << counted(model.scene.solver.levels_every, "substep") << "\n";
  for (const LevelFacts& level : facts.levels)
    out << "  " << counted(level.particles, "particle") << ", " << counted(level.constraints, "constraint") << " in "
        << counted(level.patches.patches, "patch", "patches") << "\n";
}

/// A step's: of what restricts to each level, and of the sweeps over it.
std::size_t launches_of_levels(const Model& model, const SolverFacts& facts) {
  if (facts.levels.empty()) return 0;
  const int substeps = model.scene.solver.substeps, every = model.scene.solver.levels_every;
  const std::size_t uses = (substeps + every - 1) / every;
  std::size_t each = 2 * (facts.levels.size() - 1);  // the coarser ones: means, and those whose parts lie in patches
  for (const LevelFacts& level : facts.levels) each += level.patches.phases;
  // The finest: in a step's later substeps the visits leave the means, and where they predict they hand down too.
  return uses * each + uses + (facts.whole_steps ? 1 : uses) + (facts.fused ? 0 : uses);
}

/// Launches of the passes that filter forces.
void list_filter_passes(const Model& model, const SolverFacts& facts,
                        const std::function<void(const char*, std::size_t)>& line) {
  if (!facts.filter) return;
  const std::size_t substeps = model.scene.solver.substeps, refine = model.scene.solver.desbrun.refine;
  line("forces", facts.force_launches * substeps * (1 + refine));
  line("filter", substeps * (1 + refine) * facts.filter->launches);
  line("correction", substeps * facts.free_bodies * (2 * refine + (facts.corrects ? 3 : 2)));
}

std::size_t pinned_at_start(const Model& model) {
  std::size_t pinned = std::count(model.w.begin(), model.w.end(), 0.0);
  for (const MovedPins& pins : model.moved) pinned += pins.until ? pins.particles.size() : 0;
  return pinned;
}

void list_edges(std::ostream& out, const SolverFacts& facts) {
  if (const auto& edges = facts.edges)
    out << "edges: " << edges->edges << " edges and " << edges->corners
        << " corners of the environment can touch, beside its faces; " << bytes(static_cast<double>(edges->bytes))
        << ", and what pairs take\n";
}

/// Every pass that exists in this scene, in its order, with its launches a step.
void list_passes(std::ostream& out, const Model& model, const SolverFacts& facts) {
  const SolverSpec& solver = model.scene.solver;
  const std::size_t substeps = solver.substeps, projections = substeps * solver.iterations;
  const auto line = [&out](const char* pass, std::size_t launches) {
    if (launches > 0) out << "  " << pass << ": " << counted(launches, "launch", "launches") << "\n";
  };
  const std::size_t sweeps = projections * facts.patches.phases, obstacles = model.environment.size();
  std::size_t moving = 0;
  for (const MovedPins& pins : model.moved) moving += pins.target.moves() ? 2 : 0;  // placed, and given their velocity
  line("pins", substeps * moving);
  line("damping", 3 * substeps * model.damped.size());
  line("air", facts.air_particles > 0 ? 2 * substeps : 0);
  list_filter_passes(model, facts, line);
  // Measured before and after what the visits do, or each iteration's projections; then given back.
  const std::size_t measured = facts.fused ? (facts.whole_steps ? 1 : substeps) : projections;
  line("correction", model.free.empty() ? 0 : 2 * measured + (facts.fused ? 1 : 2));
  const bool drags = model.scene.wind && model.scene.wind->drag > 0;
  const bool twice = model.scene.wind && facts.filter && solver.desbrun.internal_only;  // p once more, after the wind
  line("prediction", substeps * ((drags ? 1 : 0) + (facts.fused ? 0 : 1) + (twice ? 1 : 0)));
  line("levels", launches_of_levels(model, facts));
  // Found before the iterations, held back after them; twice a first test. None without an environment.
  line("collision", (obstacles > 0 ? substeps * (6 * obstacles + 1) : 0) + (facts.flies ? obstacles : 0));
  line("visits of prediction, projection and state", facts.fused ? sweeps : 0);
  line("projection", facts.fused || facts.sets.empty() ? 0 : sweeps);
  line("pressure", 3 * projections * model.pressures.size());
  line("long_range", facts.long_range > 0 ? projections : 0);
  line("attachments", projections * model.attached.size());
  line("contact", (projections + substeps) * obstacles);  // resolved, and restitution, which without any still stops
  std::size_t batches = 0;
  for (const OwnFacts& own : facts.own) batches += own.batches;
  line("own", 2 * projections * batches);
  if (facts.self)
    out << "  self-collision: " << counted(18 * substeps + 4 * projections, "launch", "launches")
        << ", and 19 in a substep that looks for pairs anew\n";
  if (facts.edges)
    out << "  edges: at least " << counted(10 * substeps, "launch", "launches") << ", and more where pairs are near\n";
  line("state", facts.fused ? 0 : substeps);
  line("tearing", tears(model.scene) ? 1 : 0);
  line("sleep", model.scene.sleep ? 1 : 0);  // asleep, a step is none of all these
  if (facts.flies)
    out << "  while nothing comes near the environment: " << counted(2 * obstacles + sweeps, "launch", "launches")
        << ", of collision and of visits, and none between them\n";
}

void list_memory(std::ostream& out, const Model& model, const SolverFacts& facts) {
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
  const SolverFacts& facts = simulation.solver().facts();
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
  if (const std::string coarse = coarse_resolution(model, model.look.points); !coarse.empty())
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
  list_levels(out, model, facts);
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

std::string list_launches(const Simulation& simulation) {
  std::ostringstream out;
  for (const Launches& of : simulation.times().launches)
    out << "  " << of.kernel << ": " << counted(of.launches, "launch", "launches") << ", " << counted(of.items, "item")
        << "\n";
  return out.str().empty() ? "" : "kernels that the first step launched:\n" + out.str();
}

}  // namespace malha
