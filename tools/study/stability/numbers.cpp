// SPDX-License-Identifier: Apache-2.0
// Part of the study "stability": known failures due to PBD's stiffness, which depends on the step, and to the precision
// of float.
#include <algorithm>
#include <cmath>

#include "malha/simulation.h"
#include "tools/bench/output.h"
#include "tools/study/reference/sweep.h"
#include "tools/study/stability/lines.h"
#include "tools/study/stability/map.h"

namespace malha::study {

namespace {

using bench::formatted;

std::vector<double> powers(double first, double factor, int count) {
  std::vector<double> all;
  for (int k = 0; k < count; ++k) all.push_back(first * std::pow(factor, k));
  return all;
}

void run_frames(Simulation& simulation, int frames, const Cells& cells) {
  for (int frame = 0; frame < frames; ++frame) simulation.step(), cells.check_interrupt();
}

/// A chain of ten links of 0.1 m and 0.1 kg in all, which hangs at rest and is damped.
Scene hanging_chain(double stiffness, double compliance, int substeps, int iterations) {
  Scene scene = pinned_chain({0, -1, 0}, 10, 0.1, compliance);
  scene.bodies[0].damping = 0.3, scene.bodies[0].constraints[0].stiffness = stiffness;
  scene.solver.substeps = substeps, scene.solver.iterations = iterations;
  scene.solver.precision = Precision::Double;
  return scene;
}

double elongation(const Scene& scene, const Cells& cells) {
  Simulation simulation(scene, {.threads = 1});
  run_frames(simulation, 300, cells);
  return std::abs(simulation.positions().back()[1] + 1);
}

/// Positions after half a second of a sheet at the distance `far` from the origin along all axes, relative to there.
Vector sheet_positions(double far, Precision precision, int substeps, const Cells& cells) {
  Scene scene = hanging_sheet(17, 1, 0.2, 0);
  scene.bodies[0].transform.translate = {far, far, far};
  scene.solver.precision = precision, scene.solver.substeps = substeps;
  Simulation simulation(scene, {.threads = 1});
  run_frames(simulation, 30, cells);
  return flat(simulation.positions()).array() - far;
}

template <class R>
Vector plain_sweep_positions(const SpringSystem& system, const std::vector<int>& order, int substeps,
                             const Cells& cells) {
  PlainSweep<R> sweep(system, order);
  for (int frame = 0; frame < 30; ++frame, cells.check_interrupt())
    for (int s = 0; s < substeps; ++s) sweep.substep(kFrame / substeps);
  return sweep.state().x;
}

}  // namespace

Section stiffness_failure(Cells& cells, Json& rows) {
  constexpr double strain = 0.05;                 // mean over the links
  const double load = 0.1 / 11 * kGravity * 5.5;  // mean load of a link, N
  const double compliance = strain * 0.1 / load;
  LineChart lines{"stiffness",
                  "PBD stiffness depends on the step, compliance does not",
                  "sweeps a frame of 1/60 s",
                  "elongation of a hanging chain of 1 m (m)",
                  {}};
  const std::vector<double> counts = powers(1, cells.quick() ? 8 : 2, cells.quick() ? 3 : 8);
  for (const bool pbd : {true, false})
    for (const bool substeps : {true, false}) {
      const std::string title =
          std::string(pbd ? "PBD, stiffness 0.5, " : "compliance, ") + (substeps ? "substeps" : "iterations");
      lines.lines.push_back(line_over(cells, lines, title, counts, 1, [&](double n) {
        const int many = int(n);
        return elongation(hanging_chain(0.5, pbd ? 0 : compliance, substeps ? many : 1, substeps ? 1 : many), cells);
      }));
    }
  if (cells.is_partial()) return {};
  Section section = lines_section(lines, rows);
  for (const Line& line : lines.lines) {
    const auto [low, high] = std::minmax_element(line.points.begin(), line.points.end(),
                                                 [](const auto& a, const auto& b) { return a.second < b.second; });
    section.sentences.push_back(
        line.title + formatted(": %.2g to %.2g m, %.1f times.", low->second, high->second, high->second / low->second));
  }
  section.sentences.push_back(
      formatted("Springs of that compliance stretch by %.3g m. Remedy: \"compliance\" or \"rigidity\" instead of "
                "\"stiffness\".",
                strain));
  return section;
}

Section substeps_failure(Cells& cells, Json& rows) {
  const auto system = spring_system(hanging_sheet(17, 1, 0.2, 1));
  const std::vector<int> order = order_by_colour(*system);
  LineChart lines{"substeps",
                  "Float with many substeps: 17 x 17 particles pinned at one row, after 0.5 s",
                  "substeps a frame of 1/60 s",
                  "RMS distance of float from double (m)",
                  {}};
  const std::vector<double> counts = powers(1, cells.quick() ? 32 : 4, cells.quick() ? 3 : 7);
  const Line malha_line = line_over(cells, lines, "malha", counts, 1, [&](double n) {
    return rms_distance(sheet_positions(0, Precision::Float, int(n), cells),
                        sheet_positions(0, Precision::Double, int(n), cells));
  });
  const Line plain_line = line_over(cells, lines, "plain sweep, v = (p - x) / h", counts, 1, [&](double n) {
    return rms_distance(plain_sweep_positions<float>(*system, order, int(n), cells),
                        plain_sweep_positions<double>(*system, order, int(n), cells));
  });
  lines.lines = {malha_line, plain_line};
  if (cells.is_partial()) return {};
  Section section = lines_section(lines, rows);
  const double most = malha_line.points.back().first;
  section.sentences = {
      formatted("With %g substeps float is %.2g m from double in malha and %.2g m in a plain sweep, whose velocities "
                "are differences of rounded positions; the sheet itself falls by %.2g m.",
                most, malha_line.at(most), plain_line.at(most), 0.5 * kGravity * 0.25),
      "Remedies: malha computes displacements, which are small in a substep, and carries the rounding remainders of "
      "positions; \"precision\": \"double\"."};
  return section;
}

Section distance_failure(Cells& cells, Json& rows) {
  LineChart lines{"distance",
                  "Far from the origin: 17 x 17 particles after 0.5 s, 10 substeps",
                  "distance from the origin (m)",
                  "RMS distance from double at the origin (m)",
                  {}};
  const Vector truth = sheet_positions(0, Precision::Double, 10, cells);
  const std::vector<double> distances = powers(1, cells.quick() ? 100 : 10, cells.quick() ? 3 : 6);
  for (const Precision precision : {Precision::Float, Precision::Double})
    lines.lines.push_back(
        line_over(cells, lines, precision == Precision::Float ? "float" : "double", distances, 1,
                  [&](double far) { return rms_distance(sheet_positions(far, precision, 10, cells), truth); }));
  if (cells.is_partial()) return {};
  Section section = lines_section(lines, rows);
  const double most = lines.lines[0].points.back().first;
  section.sentences = {
      formatted(
          "At %s m the error of float is %.2g m, where its numbers are %.2g m apart, and that of double is %.2g m.",
          short_number(most).c_str(), lines.lines[0].at(most), std::nextafter(float(most), 1e30f) - float(most),
          lines.lines[1].at(most)),
      "Remedies: malha computes displacements and carries the rounding remainders of positions. Contacts and Desbrun's "
      "method use positions only; run, plan and reports warn if a thousandth of an edge is lost to rounding. Then "
      "\"precision\": \"double\" helps, or a scene that is moved to the origin."};
  return section;
}

}  // namespace malha::study
