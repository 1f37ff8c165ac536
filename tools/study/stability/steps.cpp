// SPDX-License-Identifier: Apache-2.0
// Map of the study "stability" over time step and stiffness.
#include "tools/study/reference/steps.h"

#include "tools/bench/output.h"
#include "tools/study/stability/maps.h"

namespace malha::study {

namespace {

using bench::formatted;

constexpr double kSide = 1, kMass = 0.2, kSeconds = 2;  // m, kg, s
constexpr double kEulerLimit = 2, kRk4Limit = 2.828;    // stability limits of omega_max h

struct StepMethod {
  using Step = std::function<void(State&)>;
  std::string title;
  SolverSpec solver;                                         // for malha
  Step (*advance)(const SpringSystem&, double h) = nullptr;  // makes a step function; null: malha's solver
  double limit = 0;                                          // theoretical limit of omega_max h; 0: none
  int most = 4000;                                           // largest number of steps
};

int newton_steps(bool quick) { return quick ? 60 : 200; }

std::vector<StepMethod> step_methods(bool quick) {
  std::vector<StepMethod> all;
  SolverSpec solver;
  solver.substeps = 1;
  all.push_back({"XPBD, 1 iteration", solver});
  solver.iterations = 10;
  all.push_back({"XPBD, 10 iterations", solver});
  solver.iterations = 1, solver.type = "desbrun", solver.desbrun.filter = FilterKind::Sparse;
  all.push_back({"Desbrun, sparse", solver});
  solver.desbrun.filter = FilterKind::Dense;
  all.push_back({"Desbrun, dense", solver});
  solver.desbrun.storage = Storage::Int16;
  all.push_back({"Desbrun, int16", solver});
  solver.desbrun.storage.reset(), solver.desbrun.refinement_iterations = 8, solver.desbrun.filter = FilterKind::Sparse;
  all.push_back({"Desbrun, refine 8", solver});
  const auto euler = [](const SpringSystem& system, double h) -> StepMethod::Step {
    return [&system, h](State& state) { symplectic_euler(system, h, state); };
  };
  const auto runge = [](const SpringSystem& system, double h) -> StepMethod::Step {
    return [&system, h](State& state) { rk4(system, h, state); };
  };
  const auto backward = [](const SpringSystem& system, double h) -> StepMethod::Step {
    return [newton = std::make_shared<BackwardEuler>(system), h](State& state) { newton->step(h, state); };
  };
  all.push_back({"symplectic Euler", {}, euler, kEulerLimit});
  all.push_back({"RK4", {}, runge, kRk4Limit});
  all.push_back({"backward Euler", {}, backward, 0, newton_steps(quick)});
  for (StepMethod& method : all)
    if (quick) method.most = std::min(method.most, 400);
  return all;
}

Outcome run_trial(const StepMethod& method, const SpringSystem& system, Scene scene, double h, const Cells& cells) {
  const int steps = steps_of(kSeconds, h, method.most);
  const double scale = kMass * kGravity * kSide;
  if (method.advance) return judge(reference_trial(system, method.advance(system, h), steps, scale), cells);
  scene.solver = method.solver, scene.solver.dt = h, scene.solver.levels = 0;
  return judge(malha_trial(scene, steps, scale), cells);
}

/// The smallest and the largest time step from which columns fail, each times its scale (1 if none are given); the
/// largest is 0 if no column fails.
std::pair<double, double> failure_range(const Panel& panel, const std::vector<double>& scales = {}) {
  double least = 1e300, most = 0;
  for (std::size_t k = 0; k < panel.columns.size(); ++k) {
    if (!panel.columns[k].contains("fails_from")) continue;
    const double at = panel.columns[k]["fails_from"].get<double>() * (scales.empty() ? 1 : scales[k]);
    least = std::min(least, at), most = std::max(most, at);
  }
  return {least, most};
}

/// A sentence that compares the boundaries with theory.
std::string theory_sentence(const Panel& panel, const StepMethod& method, const std::vector<double>& omega) {
  const auto [least, most] = failure_range(panel, omega);
  if (most == 0) return method.title + " fails nowhere on the map.";
  return method.title +
         formatted(" fails from omega_max h = %.2f to %.2f; theory says %.2f.", least, most, method.limit);
}

std::string steps_sentence(const Panel& panel) {
  const auto [least, most] = failure_range(panel);
  int diverged = 0, nowhere = 0;
  for (const Json& column : panel.columns) {
    for (const auto& verdict : column["verdicts"]) diverged += verdict == int(Verdict::Diverged);
    nowhere += !column.contains("fails_from");
  }
  std::string line = panel.title + ": ";
  if (most == 0) return line + "stable everywhere.";
  line += least == most ? formatted("wrong or worse from steps of %.3g s on", least)
                        : formatted("wrong or worse from steps of %.3g to %.3g s on, by stiffness", least, most);
  if (nowhere > 0) line += formatted(", at %d nowhere", nowhere);
  return line + (diverged > 0 ? formatted("; %d cells diverged.", diverged) : "; nothing diverged.");
}

}  // namespace

Section steps_map(Cells& cells, Json& rows) {
  const bool quick = cells.quick();
  const int n = quick ? 5 : 7;
  const Axis y{"time step (s)", quick ? std::vector<double>{1e-4, 1e-3, 1e-2, 1e-1}
                                      : std::vector<double>{1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3}};
  const Axis x{"stiffness (N/m)",
               quick ? std::vector<double>{1e3, 1e5} : std::vector<double>{1e2, 1e3, 1e4, 1e5, 1e6, 1e7}};
  std::vector<std::unique_ptr<SpringSystem>> systems;
  std::vector<double> omega;
  for (const double k : x.values) {
    systems.push_back(spring_system(hanging_sheet(n, kSide, kMass, 1 / k)));
    omega.push_back(largest_frequency(*systems.back(), systems.back()->start.x));
  }
  Section section{"Time step and stiffness"};
  std::vector<Panel> panels;
  const std::vector<StepMethod> all = step_methods(quick);
  for (const StepMethod& method : all) {
    Panel panel{method.title, x, y, {}, {}, method.advance == nullptr};
    run_columns(panel, cells, "steps: " + method.title + ", ", " N/m", false, [&](std::size_t k, double h) {
      return run_trial(method, *systems[k], hanging_sheet(n, kSide, kMass, 1 / x.values[k]), h, cells);
    });
    if (method.limit > 0) {
      TheoryLine line{formatted("omega h = %.2f, from the spectrum", method.limit), {}};
      for (std::size_t k = 0; k < omega.size(); ++k) line.points.push_back({x.values[k], method.limit / omega[k]});
      panel.theory = {line};
    }
    panels.push_back(panel);
  }
  const Axis stiffnesses{"PBD stiffness",
                         quick ? std::vector<double>{0.01, 1} : std::vector<double>{1e-4, 1e-3, 0.01, 0.1, 0.5, 1}};
  Panel pbd{"PBD, 1 iteration", stiffnesses, y};
  run_columns(pbd, cells, "steps: PBD, ", "", false, [&](std::size_t k, double h) {
    Scene scene = hanging_sheet(n, kSide, kMass, 0);
    scene.bodies[0].constraints[0].stiffness = stiffnesses.values[k];
    return run_trial({"PBD", step_methods(quick)[0].solver, nullptr, 0, quick ? 400 : 4000}, *systems[0], scene, h,
                     cells);
  });
  if (cells.is_partial()) return section;
  section.sentences = {
      formatted(
          "A sheet of %d x %d particles (1 m, 0.2 kg), pinned at one row, is released from the horizontal for 2 s (at "
          "least 200 steps, at most %d, with Newton's method %d). Wrong: some strain exceeds 50 %%, or the energy "
          "grows by "
          "more than 5 %% of the potential energy that the sheet can lose; diverged: no longer finite, or grown by "
          "more "
          "than ten times that energy.",
          n, n, quick ? 400 : 4000, newton_steps(quick)),
      steps_sentence(pbd)};
  for (std::size_t k = 0; k < all.size(); ++k)
    section.sentences.push_back(all[k].limit > 0 ? theory_sentence(panels[k], all[k], omega)
                                                 : steps_sentence(panels[k]));
  panels.insert(panels.begin(), pbd);
  complete_map_section(section, "steps", "Time step and stiffness: where each method holds", panels, 5, rows);
  return section;
}

}  // namespace malha::study
