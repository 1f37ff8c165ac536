// SPDX-License-Identifier: Apache-2.0
#include "host/report/overstretched.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "host/base/median.h"
#include "host/model/model.h"
#include "host/report/report.h"
#include "host/solver/solver.h"
#include "malha/text.h"

namespace malha {

namespace {

constexpr double kMaxStrain = 0.1;       // RMS strain
constexpr double kAdvisedStrain = 0.05;  // RMS strain that the advised substeps leave
// A substep makes a spring of compliance alpha softer by this share of s = h^2 sum w / alpha (Softening of
// host/model/softening.h).
constexpr double kSofter = 0.6;
// Strain falls with a power of the substeps between 1 and 2: hammocks under a falling weight and flags in winds of 30
// to 300 m/s had strains of 0.028 to 0.055 with the advised substeps.
constexpr double kPower = 0.75;

/// Returns the share of the strain of a body's constraints that their compliance does not explain; 1 without
/// compliance.
double inelastic_share(const Model& model, const LengthRun& run) {
  const ConstraintSet& set = model.sets[static_cast<std::size_t>(run.set)];
  if (!(set.compliance.value_or(0) > 0)) return 1;
  const SolverSpec& solver = model.scene.solver;
  const double h = solver.dt / solver.substeps, n = solver.iterations;
  std::vector<double> s;
  for (int c = run.first; c < run.first + run.count; ++c) {
    const double w = model.w[set.particles[2 * c]] + model.w[set.particles[2 * c + 1]];
    if (set.alpha(c) > 0) s.push_back(h * h * w / set.alpha(c));
  }
  if (s.empty()) return 1;
  const double share = kSofter * median(std::move(s)) / (n * n);
  return share / (1 + share);
}

/// Returns whether more than loads stretches the body, so that no number of substeps helps: tearing, rest lengths that
/// are not those of its shape, or pins that move apart.
bool stretches_by_design(const BodySpec& body) {
  const auto other_length = [](const ConstraintSpec& of) {
    return of.type == "distance" && (of.parameter != 1 || of.parameter_map);
  };
  const auto moves = [](const Pin& pin) { return !pin.motion.empty(); };
  return body.tear.has_value() || std::ranges::any_of(body.constraints, other_length) ||
         (body.pins.size() > 1 && std::ranges::any_of(body.pins, moves));
}

}  // namespace

std::vector<std::string> overstretch_warnings(const Simulation& simulation) {
  const Model& model = simulation.model();
  const Scene& scene = model.scene;
  if (scene.solver.type != "pbd") return {};
  LargestStrains strains = simulation.times().strains;
  strains.take(simulation.solver().strains(), simulation.steps());  // the end of the run, which may lie between samples
  const std::vector<LengthRun>& lengths = simulation.solver().lengths();
  std::vector<bool> left_out;
  for (const BodySpec& body : scene.bodies) left_out.push_back(stretches_by_design(body));
  for (const PressureSet& set : model.pressures)
    if (set.volume_ratio > 1)
      for (const int i : set.particles) left_out[body_of(model, model.user_index[i])] = true;
  struct Worst {
    double strain = 0, part = 0;
    std::int64_t step = 0;
  };
  std::map<int, Worst> worst;  // by body
  for (std::size_t r = 0; r < std::min(lengths.size(), strains.runs.size()); ++r) {
    const LengthRun& run = lengths[r];
    if (run.springs || left_out[run.body] || model.sets[static_cast<std::size_t>(run.set)].stiffness < 1) continue;
    const double rms = strains.runs[r].rms, part = rms > kMaxStrain ? inelastic_share(model, run) : 0;
    Worst& of = worst[run.body];
    if (rms * part > of.strain * of.part) of = {rms, part, strains.runs[r].step};
  }
  std::vector<std::string> lines;
  for (const auto& [body, of] : worst) {
    const double left = of.strain * of.part;
    if (!(left > kMaxStrain)) continue;
    const double substeps = std::ceil(scene.solver.substeps * std::pow(left / kAdvisedStrain, kPower));
    lines.push_back(
        "body '" + scene.bodies[body].name + "': the load on it at " +
        shown(static_cast<double>(of.step) * scene.solver.dt, 2) + " s stretched its \"distance\" by " +
        shown(100 * of.strain, 2) + " % (RMS)" +
        (of.part < 1 ? ", of which its compliance explains " + shown(100 * (of.strain - left), 2) + " %" : "") +
        ", because " + counted(scene.solver.substeps, "substep") + " of " +
        counted(scene.solver.iterations, "iteration") + " are too few for such a load; take about " +
        std::to_string(static_cast<long long>(substeps)) + " substeps, or a lighter load (scenes/accuracy.md, Loads)");
  }
  return lines;
}

}  // namespace malha
