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

/// A method that advances a state frame by frame.
class Runner {
 public:
  virtual ~Runner() = default;
  virtual void frame() = 0;
  virtual State state() const = 0;
  /// Adds the method's operation counts per simulated second.
  virtual void add_counts(Json& cell, int frames_run) const = 0;
};

class MalhaRunner : public Runner {
 public:
  MalhaRunner(const AccuracyCase& test_case, const Method& method, const bench::RunsOn& on)
      : simulation_(with_solver(test_case, method.solver, method.compliant), on.simulation_options(1, false)),
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

class ReferenceRunner : public Runner {
 public:
  ReferenceRunner(const System& system, const Method& method)
      : system_(system),
        integrator_(method.integrator),
        substeps_(method.solver.substeps),
        state_(system.start),
        newton_(integrator_ == Integrator::BackwardEuler
                    ? std::make_unique<BackwardEuler>(dynamic_cast<const SpringSystem&>(system))
                    : nullptr) {}
  void frame() override {
    const double h = kFrame / substeps_;
    for (int k = 0; k < substeps_; ++k)
      if (integrator_ == Integrator::ExplicitEuler)
        explicit_euler(system_, h, state_);
      else if (integrator_ == Integrator::SymplecticEuler)
        symplectic_euler(system_, h, state_);
      else if (integrator_ == Integrator::Rk4)
        rk4(system_, h, state_);
      else
        newton_->step(h, state_);
    if (!state_.x.allFinite() || state_.x.cwiseAbs().maxCoeff() > 1e6) throw Diverged("a reference");
  }
  State state() const override { return state_; }
  void add_counts(Json& cell, int frames_run) const override {
    const bool implicit = integrator_ == Integrator::BackwardEuler;
    const double sweeps = implicit ? static_cast<double>(newton_->solves()) / frames_run / kFrame
                                   : substeps_ * (integrator_ == Integrator::Rk4 ? 4 : 1) / kFrame;
    cell["sweeps_per_s"] = sweeps;
    cell[implicit ? "factorisations_per_s" : "evaluations_per_s"] = sweeps;
  }

 private:
  const System& system_;
  Integrator integrator_;
  int substeps_;
  State state_;
  std::unique_ptr<BackwardEuler> newton_;  // null for other integrators
};

Json errors(const System& system, const State& state, const State& truth, double energy, double time) {
  const ConservedQuantities now = conserved_quantities(system, state), then = conserved_quantities(system, truth);
  return {{"time_s", time},
          {"rms_error_m", rms_distance(state.x, truth.x)},
          {"rms_strain", rms(system.strains(state.x))},
          {"rms_strain_error", rms(system.strains(state.x) - system.strains(truth.x))},
          {"energy_drift", (now.energy() - then.energy()) / energy},
          {"momentum_error_kg_m_per_s", (now.momentum - then.momentum).norm()},
          {"angular_momentum_error_kg_m2_per_s", (now.angular_momentum - then.angular_momentum).norm()}};
}

double kinetic_plus_elastic(const System& system, const State& state) {
  const ConservedQuantities b = conserved_quantities(system, state);
  return b.kinetic + b.elastic;
}

/// Runs RK4 with `substeps` a frame. Returns the states at the case's times, and the largest kinetic plus elastic
/// energy after any frame. `perturbation`: amplitude (m) that is added to the initial coordinates.
Json reference_run(const AccuracyCase& test_case, const System& system, int substeps, double perturbation,
                   const Cells& cells) {
  Json states = Json::array();
  State state = system.start;
  for (int k = 0; k < state.x.size(); ++k)
    if (!system.pinned[k / 3]) state.x[k] += perturbation * std::sin(1.7 * k);
  double energy = kinetic_plus_elastic(system, state);
  for (int frame = 1; frame <= frames(test_case.times.back()); ++frame) {
    for (int k = 0; k < substeps; ++k) rk4(system, kFrame / substeps, state);
    cells.check_interrupt();
    energy = std::max(energy, kinetic_plus_elastic(system, state));
    if (std::any_of(test_case.times.begin(), test_case.times.end(), [&](double t) { return frames(t) == frame; }))
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

Truth truth_of(const AccuracyCase& test_case, const System& system, Cells& cells) {
  Truth truth;
  truth.omega = largest_frequency(system, system.start.x);
  if (test_case.exact) {
    for (const double t : test_case.times)
      truth.at.push_back(test_case.exact(t)), truth.uncertainty.push_back(test_case.discretisation_error);
  } else {
    const auto run = [&](int substeps, double perturbation = 0) {
      const std::string key = test_case.name + " reference, RK4, " + std::to_string(substeps) + " substeps";
      return cells(key + (perturbation > 0 ? bench::formatted(", from %g m off", perturbation) : ""),
                   [&] { return reference_run(test_case, system, substeps, perturbation, cells); });
    };
    const std::vector<State> perturbed_difference = states_of(run(test_case.reference / 2, kPerturbation));
    const std::vector<State> coarse = states_of(run(test_case.reference / 2));
    const Json fine = run(test_case.reference);
    truth.at = states_of(fine), truth.energy = fine["energy_j"].get<double>();
    for (std::size_t k = 0; k < truth.at.size(); ++k) {
      truth.step_difference.push_back(rms_distance(truth.at[k].x, coarse[k].x));
      truth.perturbed_difference.push_back(rms_distance(perturbed_difference[k].x, coarse[k].x));
      truth.uncertainty.push_back(std::max(truth.step_difference[k], truth.perturbed_difference[k]));
    }
  }
  for (const State& state : truth.at) truth.energy = std::max(truth.energy, kinetic_plus_elastic(system, state));
  if (test_case.taut) truth.energy -= system.elastic_energy(system.start.x);
  return truth;
}

Json accuracy_cell(const AccuracyCase& test_case, const System& system, const Method& method, const Truth& truth,
                   const Cells& cells) {
  Json cell{{"status", "finished"}};
  Json at = Json::array();
  std::vector<double> seconds_of;
  std::unique_ptr<Runner> runner;
  const bool on_device = cells.runs_on().is_device() && method.integrator == Integrator::Malha;
  if (on_device) cell["backend"] = cells.runs_on().backend;
  if (method.integrator == Integrator::Malha)
    runner = std::make_unique<MalhaRunner>(test_case, method, cells.runs_on());
  else
    runner = std::make_unique<ReferenceRunner>(system, method);
  int frame = 0;
  try {
    for (std::size_t k = 0; k < test_case.times.size() && test_case.times[k] <= method.end_time; ++k) {
      for (; frame < frames(test_case.times[k]); ++frame) {
        const auto step = [&] { runner->frame(); };
        seconds_of.push_back(on_device ? seconds(step) : thread_seconds(step));
        cells.check_interrupt();
      }
      at.push_back(errors(system, runner->state(), truth.at[k], truth.energy, test_case.times[k]));
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
