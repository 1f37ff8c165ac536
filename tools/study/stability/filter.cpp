// SPDX-License-Identifier: Apache-2.0
// Part of the study "stability": known failures of Desbrun's linear filter.
#include <cmath>
#include <map>

#include "malha/simulation.h"
#include "tools/bench/output.h"
#include "tools/study/reference/steps.h"
#include "tools/study/stability/lines.h"
#include "tools/study/stability/map.h"

namespace malha::study {

namespace {

using bench::formatted;

double norm(const std::array<double, 3>& a) { return std::hypot(a[0], a[1], a[2]); }

SolverSpec filtered(Corrector corrector, int refine) {
  SolverSpec solver;
  solver.type = "desbrun", solver.substeps = 1, solver.precision = Precision::Double, solver.dt = kFrame;
  solver.desbrun.corrector = corrector, solver.desbrun.refinement_iterations = refine,
  solver.desbrun.filter = FilterKind::Sparse;
  return solver;
}

/// A free sheet of 0.2 kg that rotates about all axes without gravity; its springs start a tenth longer than at rest.
Scene tumbling(double stiffness, const SolverSpec& solver) {
  Scene scene = hanging_sheet(9, 1, 0.2, 1 / stiffness);
  scene.gravity = {0, 0, 0}, scene.solver = solver;
  scene.bodies[0].pins.clear(), scene.bodies[0].spin = {1, 2, -3};
  scene.bodies[0].constraints[0].parameter = 0.9;
  return scene;
}

/// The relative change of angular momentum in 10 steps.
double relative_momentum_change(const Scene& scene, const Cells& cells) {
  Simulation simulation(scene, {.threads = 1});
  const auto before = simulation.measure().angular_momentum;
  for (int step = 0; step < 10; ++step) simulation.step(), cells.check_interrupt();
  auto after = simulation.measure().angular_momentum;
  for (int k = 0; k < 3; ++k) after[k] -= before[k];
  return norm(after) / norm(before);
}

std::vector<double> stiffnesses(bool quick) {
  return quick ? std::vector<double>{1e-3, 0.1, 10, 1e3}
               : std::vector<double>{1e-3, 1e-2, 0.1, 1, 10, 100, 1e3, 1e4, 1e5, 1e6};
}

/// A straight chain of 1 m, pinned at one end and released from the horizontal.
Scene falling_chain(double stiffness, const SolverSpec& solver) {
  Scene scene = pinned_chain({1, 0, 0}, 10, 0.1, 1 / stiffness);
  scene.solver = solver, scene.solver.dt = kFrame;
  return scene;
}

constexpr int kFallFrames = 15;  // frames

/// RMS distance of the final state from the true one, m.
double final_distance(const Scene& scene, const Vector& truth, const Cells& cells) {
  Simulation simulation(scene, {.threads = 1});
  for (int step = 0; step < kFallFrames; ++step) simulation.step(), cells.check_interrupt();
  return rms_distance(flat(simulation.positions()), truth);
}

/// The largest strain after 3 s of a sheet that hangs at rest.
double strain_at_rest(int n, bool filter_weight, double h, const Cells& cells) {
  Scene scene = hanging_sheet(n, 1, 0.2, 1e-4);
  scene.bodies[0].transform.axis = {1, 0, 0}, scene.bodies[0].transform.degrees = 90;
  scene.solver = filtered(Corrector::Inertia, 0), scene.solver.dt = h;
  scene.solver.desbrun.filter_external_forces = filter_weight;
  Simulation simulation(scene, {.threads = 1});
  for (int step = 0; step < int(3 / h); ++step) simulation.step(), cells.check_interrupt();
  return simulation.measure().strain_max;
}

Section turning(Cells& cells, Json& rows) {
  LineChart lines{"turning",
                  "Rotating parts: a chain falls about its pin for 0.25 s, steps of 1/60 s",
                  "k h^2 / m",
                  "RMS distance from the true springs (m)",
                  {}};
  const double mass = 0.01;
  const std::vector<double> all =
      cells.quick() ? std::vector<double>{1e3, 1e5} : std::vector<double>{1e2, 1e3, 1e4, 1e5, 1e6};
  std::map<double, Vector> truth;
  for (const double k : all) {
    const auto system = spring_system(falling_chain(k, {}));
    const Json x = cells(formatted("turning: truth, %g", k), [&]() -> Json {
      State state = system->start;
      const double h = 0.5 / largest_frequency(*system, state.x);
      const int steps = int(std::ceil(kFallFrames * kFrame / h));
      for (int step = 0; step < steps; ++step)
        rk4(*system, kFallFrames * kFrame / steps, state), cells.check_interrupt();
      return numbers_of(state.x);
    });
    truth[k] = vector_of(x.get<std::vector<double>>());
  }
  const auto add = [&](const std::string& title, const SolverSpec& solver) {
    lines.lines.push_back(line_over(cells, lines, title, all, kFrame * kFrame / mass, [&](double k) {
      return final_distance(falling_chain(k, solver), truth.at(k), cells);
    }));
  };
  for (const auto& [refine, substeps] : {std::pair{0, 1}, {4, 1}, {16, 1}, {0, 16}, {0, 256}}) {
    SolverSpec solver = filtered(Corrector::Off, refine);
    solver.substeps = substeps;
    add(substeps > 1 ? formatted("%d substeps", substeps) : formatted("refine %d", refine), solver);
  }
  SolverSpec xpbd;
  xpbd.substeps = 16, xpbd.precision = Precision::Double;
  add("XPBD, 16 substeps", xpbd);
  Section section = lines_section(lines, rows);
  for (const Line& line : lines.lines) {
    const auto& [x, y] = line.points.back();
    section.sentences.push_back(line.title + formatted(": error %.2g m at k h^2 / m = %.2g.", y, x));
  }
  section.sentences.push_back(
      "The corrector of a body's total momentum does not act on parts that rotate against each other, nor on pinned "
      "bodies. Remedies: \"refinement_iterations\" if k h^2 / m is small, substeps, or XPBD; run and plan warn if the "
      "filter damps oscillations about the pins by more than a fifth of critical damping.");
  return section;
}

}  // namespace

Section torque_failure(Cells& cells, Json& rows) {
  LineChart lines{"torque",
                  "Torque of the linear filter: a free rotating sheet, 10 steps of 1/60 s",
                  "k h^2 / m",
                  "relative change of angular momentum",
                  {}};
  const double mass = 0.2 / 81;
  struct CorrectorCase {
    const char* title;
    Corrector corrector;
    int refine;
  };
  for (const auto& [title, corrector, refine] :
       {CorrectorCase{"corrector paper", Corrector::Paper, 0}, CorrectorCase{"corrector off", Corrector::Off, 0},
        CorrectorCase{"corrector inertia (default)", Corrector::Inertia, 0},
        CorrectorCase{"corrector off, refine 8", Corrector::Off, 8},
        CorrectorCase{"corrector off, refine 32", Corrector::Off, 32}}) {
    const SolverSpec solver = filtered(corrector, refine);
    lines.lines.push_back(line_over(cells, lines, title, stiffnesses(cells.quick()), kFrame * kFrame / mass,
                                    [&](double k) { return relative_momentum_change(tumbling(k, solver), cells); }));
  }
  if (cells.is_partial()) return {};
  Section section = lines_section(lines, rows);
  const double x = lines.lines[0].points[cells.quick() ? 2 : 4].first;
  for (const Line& line : lines.lines)
    section.sentences.push_back(line.title +
                                (std::isfinite(line.at(x)) ? formatted(": %.2g", line.at(x)) : ": not finite") +
                                formatted(" at k h^2 / m = %.2g.", x));
  section.sentences.push_back(
      "Remedy: the default corrector, which uses the body's inertia; run and plan warn if the scene has another one "
      "and "
      "too few refinements, so that half of the angular momentum would be lost in 10 steps.");
  return section;
}

Section turning_failure(Cells& cells, Json& rows) {
  Section section;
  cells.measure_together([&] { section = turning(cells, rows); });  // errors need the reference solution
  return section;
}

Section weight_failure(Cells& cells, Json& rows) {
  LineChart lines{"weight",
                  "Gravity that is not filtered: a sheet of 1 m hanging at rest by a row",
                  "g h^2 / l",
                  "largest strain after 3 s",
                  {}};
  for (const bool filter_weight : {false, true}) {
    Line line{filter_weight ? "filter_external_forces: true (default)" : "filter_external_forces: false", {}};
    for (const auto& sheet : cells.quick()
                                 ? std::vector<std::pair<int, double>>{{5, kFrame}, {17, 0.1}}
                                 : std::vector<std::pair<int, double>>{
                                       {5, kFrame}, {17, kFrame}, {65, kFrame}, {17, 0.05}, {17, 0.1}, {17, 0.2}}) {
      const int n = sheet.first;
      const double h = sheet.second;
      line.add(kGravity * h * h * (n - 1), cells, formatted("weight, %s, %d, %g s", line.title.c_str(), n, h),
               [&] { return strain_at_rest(n, filter_weight, h, cells); });
    }
    lines.lines.push_back(line);
  }
  if (cells.is_partial()) return {};
  Section section = lines_section(lines, rows);
  const double x = lines.lines[0].points.back().first;
  section.sentences = {formatted("At g h^2 / l = %.2g the largest strain is %.2g if gravity is not filtered and "
                                 "%.2g if all forces are.",
                                 x, lines.lines[0].at(x), lines.lines[1].at(x)),
                       "Remedy: all forces are filtered by default; run and plan warn if "
                       "\"filter_external_forces\": false would "
                       "stretch springs by more than 40 %."};
  return section;
}

}  // namespace malha::study
