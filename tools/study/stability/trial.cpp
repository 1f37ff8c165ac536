// SPDX-License-Identifier: Apache-2.0
#include "tools/study/stability/trial.h"

#include <algorithm>
#include <cmath>

#include "host/report/warnings.h"
#include "host/solver/solver.h"
#include "malha/simulation.h"

namespace malha::study {

namespace {

Sample sample_of(const Measures& m) { return {m.strain_max, m.strain_rms, m.kinetic + m.potential}; }

/// A scene of one body of distance constraints, with gravity.
Scene spring_scene(const std::string& name, const Shape& shape, double mass, const Pin& pin,
                   std::vector<std::string> on, double compliance) {
  ConstraintSpec lengths;
  lengths.type = "distance", lengths.elements = std::move(on);
  if (compliance > 0) lengths.compliance = compliance;
  BodySpec body;
  body.name = name, body.shape = shape, body.mass = mass, body.pins = {pin}, body.constraints = {lengths};
  Scene scene;
  scene.file = "malha study", scene.name = name, scene.gravity = {0, -kGravity, 0}, scene.bodies = {body};
  scene.solver.dt = kFrame;
  return scene;
}

}  // namespace

Outcome judge(const Trial& trial, const Cells& cells) {
  Outcome outcome;
  outcome.warned = trial.warned;
  const double start = trial.sample().energy;
  const int every = (trial.steps + 199) / 200;
  try {
    for (int step = 1; step <= trial.steps; ++step) {
      trial.step();
      if (step % every != 0 && step != trial.steps) continue;
      cells.check_interrupt();
      const Sample now = trial.sample();
      const double gain = (now.energy - start) / trial.scale;
      if (!std::isfinite(now.rms) || !(gain <= kDivergedGain)) {
        outcome.verdict = Verdict::Diverged;
        return outcome;
      }
      outcome.strain = std::max(outcome.strain, now.strain);
      outcome.rms = std::max(outcome.rms, now.rms);
      outcome.gain = std::max(outcome.gain, gain);
    }
  } catch (const Diverged&) {
    outcome.verdict = Verdict::Diverged;
    return outcome;
  }
  if (outcome.strain > kWrongStrain || outcome.gain > kWrongGain) outcome.verdict = Verdict::Wrong;
  return outcome;
}

int steps_of(double seconds, double step, int most) {
  return static_cast<int>(std::clamp(std::ceil(seconds / step), std::min(200.0, double(most)), double(most)));
}

Trial malha_trial(const Scene& scene, int steps, double scale) {
  const auto simulation = std::make_shared<Simulation>(scene, SimulationOptions{.threads = 1});
  return {[simulation] { simulation->step(); }, [simulation] { return sample_of(simulation->measure()); }, steps, scale,
          !warnings(simulation->model()).empty()};
}

Trial malha_trial(const Model& model, int steps, double scale) {
  const auto copy = std::make_shared<Model>(model);
  const std::shared_ptr<Solver> solver = make_solver(*copy, 1);
  return {[copy, solver] { solver->step(); }, [copy, solver] { return sample_of(solver->measure()); }, steps, scale,
          !warnings(*copy).empty()};
}

Sample sample_of(const SpringSystem& system, const State& state) {
  const Vector strain = system.strains(state.x);
  return {strain.cwiseAbs().maxCoeff(), strain.norm() / std::sqrt(static_cast<double>(strain.size())),
          conserved_quantities(system, state).energy()};
}

Trial reference_trial(const SpringSystem& system, std::function<void(State&)> advance, int steps, double scale) {
  const auto state = std::make_shared<State>(system.start);
  return {[state, advance] { advance(*state); }, [state, &system] { return sample_of(system, *state); }, steps, scale};
}

Scene hanging_sheet(int n, double side, double mass, double compliance) {
  Scene scene =
      spring_scene("sheet", GridShape{{side, side}, {n - 1, n - 1}}, mass, RowPin{}, {"edges", "shear"}, compliance);
  scene.solver.levels = 0;  // the boundaries are those of sweeps over the particles
  return scene;
}

Scene corner_pinned_sheet(int n, double side, double mass, double compliance) {
  Scene scene = hanging_sheet(n, side, mass, compliance);
  scene.bodies[0].pins = {ListPin{{0, n - 1}}};
  return scene;
}

Scene pinned_chain(const Vec3& end, int links, double mass, double compliance) {
  return spring_scene("chain", ChainShape{{0, 0, 0}, end, links}, mass, ListPin{{0}}, {"edges"}, compliance);
}

}  // namespace malha::study
