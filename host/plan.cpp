#include "host/plan.h"

#include <algorithm>
#include <sstream>

#include "host/model.h"
#include "host/solver.h"

namespace malha {

namespace {

std::string bytes(std::size_t count) {
  std::ostringstream text;
  text.precision(3);
  if (count < 10 * 1024)
    text << count << " B";
  else if (count < 10 * 1024 * 1024)
    text << count / 1024.0 << " KiB";
  else
    text << count / 1048576.0 << " MiB";
  return text.str();
}

void list_constraints(std::ostream& out, const Model& model, const SolverFacts& facts) {
  for (std::size_t s = 0; s < facts.sets.size(); ++s) {
    const SetFacts& set = facts.sets[s];
    out << "  " << set.type << ": " << set.constraints << " in " << set.batch_sizes.size() << " colours, ";
    if (model.sets[s].compliance)
      out << "compliance " << *model.sets[s].compliance;
    else
      out << "stiffness " << model.sets[s].stiffness;
    out << "; batches of";
    for (int size : set.batch_sizes) out << " " << size;
    out << "\n";
  }
  for (const PressureSet& set : model.pressures)
    out << "  pressure: 1 over " << set.particles.size() << " particles and " << set.triangles.size() << " triangles\n";
}

/// Every pass that exists in this scene, in its order, with its launches a step.
void list_passes(std::ostream& out, const Model& model, const SolverFacts& facts) {
  const SolverSpec& solver = model.scene.solver;
  const int substeps = solver.substeps, projections = substeps * solver.iterations;
  const auto line = [&out](const char* pass, std::size_t launches) {
    if (launches > 0) out << "  " << pass << ": " << launches << " launches\n";
  };
  std::size_t colours = 0, bouncing = 0;
  for (const SetFacts& set : facts.sets) colours += set.batch_sizes.size();
  for (const EnvironmentMesh& mesh : model.environment) bouncing += mesh.spec.restitution > 0;
  line("damping", 3 * substeps * model.damped.size());
  line("prediction", substeps * (model.scene.wind ? 2 : 1));
  line("collision", substeps * model.environment.size());
  line("projection", projections * colours);
  line("pressure", 3 * projections * model.pressures.size());
  line("contact", projections * model.environment.size() + substeps * bouncing);
  line("state", substeps);
}

}  // namespace

std::string plan(const Simulation& simulation) {
  const Model& model = simulation.model();
  const SolverFacts& facts = simulation.solver().facts();
  const Scene& scene = model.scene;
  const auto pinned = std::count(model.w.begin(), model.w.end(), 0.0);
  std::ostringstream out;
  out << "scene: " << scene.name << "\n"
      << "solver: " << scene.solver.type << ", " << (scene.solver.precision == Precision::Double ? "double" : "float")
      << ", dt " << scene.solver.dt << " s in " << scene.solver.substeps << " substeps of " << scene.solver.iterations
      << " iterations, " << simulation.threads() << " threads\n"
      << "particles: " << model.count() << " in " << scene.bodies.size() << " bodies, " << pinned << " pinned\n"
      << "constraints: " << facts.projections_per_step << " projections a step\n";
  list_constraints(out, model, facts);
  out << "passes of a step:\n";
  list_passes(out, model, facts);
  out << "memory:\n"
      << "  particles: " << bytes(facts.particle_bytes) << "\n"
      << "  constraints: " << bytes(facts.constraint_bytes) << "\n";
  if (scene.environment.empty()) {
    out << "Embree: no (no environment)\n";
  } else {
    out << "  collision: " << bytes(facts.collision_bytes) << " and Embree's own\n"
        << "Embree: yes, " << scene.environment.size() << " environment meshes\n";
  }
  if (model.zero_area_faces > 0) out << "dropped: " << model.zero_area_faces << " faces without area\n";
  return out.str();
}

}  // namespace malha
