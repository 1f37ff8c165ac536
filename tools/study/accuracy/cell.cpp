// SPDX-License-Identifier: Apache-2.0
#include "tools/study/accuracy/cell.h"

#include <algorithm>
#include <cmath>

#include "host/base/stopwatch.h"
#include "host/solver/solver.h"
#include "malha/simulation.h"
#include "tools/bench/medians.h"
#include "tools/bench/output.h"
#include "tools/study/reference/steps.h"

namespace malha::study {

namespace {

int frames(double time) { return static_cast<int>(std::lround(time / kFrame)); }

double rms(const Vector& a) { return a.norm() / std::sqrt(static_cast<double>(a.size())); }

/// Advances by a frame at a time.
class Runner {
 public:
  virtual ~Runner() = default;
  virtual void frame() = 0;
  virtual State state() const = 0;
  /// What a simulated second takes, in units of its own.
  virtual void add_counts(Json& cell, int frames_run) const = 0;
};

class ByMalha : public Runner {
 public:
  ByMalha(const AccuracyCase& of, const Method& method, const bench::RunsOn& on)
      : simulation_(with_solver(of, method.solver, method.compliant), on.simulation_options(1, false)),
        solver_(method.solver) {}
  void frame() override { simulation_.step(); }
  State state() const override { return {flat(simulation_.positions()), flat(simulation_.velocities())}; }
  void add_counts(Json& cell, int) const override {
    const bool filtered = solver_.type == "desbrun";
    const double passes =
        solver_.substeps * (filtered ? 1 + solver_.desbrun.refinement_iterations : solver_.iterations) / kFrame;
    cell["sweeps_per_s"] = passes;
    if (filtered)
      cell["solves_per_s"] = passes;
    else
      cell["projections_per_s"] = static_cast<double>(simulation_.solver().facts().projections_per_step) / kFrame;
  }

 private:
  Simulation simulation_;
  SolverSpec solver_;
};

class ByReference : public Runner {
 public:
  ByReference(const System& system, const Method& method)
      : system_(system),
        how_(method.integrator),
        substeps_(method.solver.substeps),
        state_(system.start),
        newton_(how_ == Integrator::BackwardEuler
                    ? std::make_unique<BackwardEuler>(dynamic_cast<const SpringSystem&>(system))
                    : nullptr) {}
  void frame() override {
    const double h = kFrame / substeps_;
    for (int k = 0; k < substeps_; ++k)
      if (how_ == Integrator::ExplicitEuler)
        explicit_euler(system_, h, state_);
      else if (how_ == Integrator::SymplecticEuler)
        symplectic_euler(system_, h, state_);
      else if (how_ == Integrator::Rk4)
        rk4(system_, h, state_);
      else
        newton_->step(h, state_);
    if (!state_.x.allFinite() || state_.x.cwiseAbs().maxCoeff() > 1e6) throw Diverged("a reference");
  }
  State state() const override { return state_; }
  void add_counts(Json& cell, int frames_run) const override {
    const bool implicit = how_ == Integrator::BackwardEuler;
    const double sweeps = implicit ? static_cast<double>(newton_->solves()) / frames_run / kFrame
                                   : substeps_ * (how_ == Integrator::Rk4 ? 4 : 1) / kFrame;
    cell["sweeps_per_s"] = sweeps;
    cell[implicit ? "factorisations_per_s" : "evaluations_per_s"] = sweeps;
  }

 private:
  const System& system_;
  Integrator how_;
  int substeps_;
  State state_;
  std::unique_ptr<BackwardEuler> newton_;  // if it is that
};

Json errors(const System& system, const State& state, const State& truth, double energy, double time) {
  const Balance now = balance(system, state), then = balance(system, truth);
  return {{"time_s", time},
          {"rms_error_m", rms_distance(state.x, truth.x)},
          {"rms_strain", rms(system.strains(state.x))},
          {"rms_strain_error", rms(system.strains(state.x) - system.strains(truth.x))},
          {"energy_drift", (now.energy() - then.energy()) / energy},
          {"momentum_error_kg_m_per_s", (now.momentum - then.momentum).norm()},
          {"angular_momentum_error_kg_m2_per_s", (now.angular_momentum - then.angular_momentum).norm()}};
}

double in_motion(const System& system, const State& state) {
  const Balance b = balance(system, state);
  return b.kinetic + b.elastic;
}

/// Positions and velocities at the times, at `substeps` a frame, and the most energy in motion after any frame.
/// `shake`: m, by which coordinates are off at the start.
Json reference_run(const AccuracyCase& of, const System& system, int substeps, double shake, const Cells& cells) {
  Json states = Json::array();
  State state = system.start;
  for (int k = 0; k < state.x.size(); ++k)
    if (!system.pinned[k / 3]) state.x[k] += shake * std::sin(1.7 * k);
  double energy = in_motion(system, state);
  for (int frame = 1; frame <= frames(of.times.back()); ++frame) {
    for (int k = 0; k < substeps; ++k) rk4(system, kFrame / substeps, state);
    cells.go_on();
    energy = std::max(energy, in_motion(system, state));
    if (std::any_of(of.times.begin(), of.times.end(), [&](double t) { return frames(t) == frame; }))
      states.push_back({{"x", numbers_of(state.x)}, {"v", numbers_of(state.v)}});
  }
  return {{"energy_j", energy}, {"states", states}};
}

std::vector<State> states_of(const Json& cell) {
  std::vector<State> states;
  for (const Json& state : cell["states"]) states.push_back({vector_of(state["x"]), vector_of(state["v"])});
  return states;
}

}  // namespace

Truth truth_of(const AccuracyCase& of, const System& system, Cells& cells) {
  Truth truth;
  truth.omega = largest_frequency(system, system.start.x);
  if (of.exact) {
    for (const double t : of.times) truth.at.push_back(of.exact(t)), truth.known.push_back(of.known);
  } else {
    const auto run = [&](int substeps, double shake = 0) {
      const std::string key = of.name + " reference, RK4, " + std::to_string(substeps) + " substeps";
      return cells(key + (shake > 0 ? bench::formatted(", from %g m off", shake) : ""),
                   [&] { return reference_run(of, system, substeps, shake, cells); });
    };
    const std::vector<State> shaken = states_of(run(of.reference / 2, kShake));
    const std::vector<State> coarse = states_of(run(of.reference / 2));
    const Json fine = run(of.reference);
    truth.at = states_of(fine), truth.energy = fine["energy_j"].get<double>();
    for (std::size_t k = 0; k < truth.at.size(); ++k) {
      truth.halved.push_back(rms_distance(truth.at[k].x, coarse[k].x));
      truth.shaken.push_back(rms_distance(shaken[k].x, coarse[k].x));
      truth.known.push_back(std::max(truth.halved[k], truth.shaken[k]));
    }
  }
  for (const State& state : truth.at) truth.energy = std::max(truth.energy, in_motion(system, state));
  if (of.taut) truth.energy -= system.elastic_energy(system.start.x);
  return truth;
}

Json accuracy_cell(const AccuracyCase& of, const System& system, const Method& method, const Truth& truth,
                   const Cells& cells) {
  Json cell{{"status", "finished"}};
  Json at = Json::array();
  std::vector<double> seconds_of;
  std::unique_ptr<Runner> runner;
  const bool on_device = cells.on().is_device() && method.integrator == Integrator::Malha;
  if (on_device) cell["backend"] = cells.on().backend;
  if (method.integrator == Integrator::Malha)
    runner = std::make_unique<ByMalha>(of, method, cells.on());
  else
    runner = std::make_unique<ByReference>(system, method);
  int frame = 0;
  try {
    for (std::size_t k = 0; k < of.times.size() && of.times[k] <= method.release_time; ++k) {
      for (; frame < frames(of.times[k]); ++frame) {
        const auto step = [&] { runner->frame(); };
        seconds_of.push_back(on_device ? seconds(step) : thread_seconds(step));
        cells.go_on();
      }
      at.push_back(errors(system, runner->state(), truth.at[k], truth.energy, of.times[k]));
    }
  } catch (const Diverged&) {
    cell["status"] = "diverged";
  }
  if (seconds_of.empty()) seconds_of.push_back(0);
  cell["ms_per_s"] = bench::median(seconds_of) * 1000 / kFrame;
  runner->add_counts(cell, std::max(frame, 1));
  cell["at"] = at;
  return cell;
}

}  // namespace malha::study
