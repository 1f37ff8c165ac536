// SPDX-License-Identifier: Apache-2.0
#include "tools/study/accuracy/order.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "malha/simulation.h"
#include "tools/bench/output.h"
#include "tools/study/reference/chain.h"
#include "tools/study/reference/sweep.h"
#include "tools/study/rows.h"
#include "tools/study/step_length.h"

namespace malha::study {

namespace {

using bench::formatted;

constexpr double kOrderTime = 0.5;                           // s
constexpr int kOrderFrames = 30, kReferenceSubsteps = 2048;  // steps of the truth a frame
constexpr double kReferenceUncertainty = 1e-7;               // m, by halving those

enum class Scheme { OneWay, Malha, Converged, ConvergedLater };

struct OrderLine {
  std::string title;
  Scheme scheme;
  int edges;
  std::vector<int> substeps;
  const char* style;
};

std::vector<OrderLine> order_lines(bool quick) {
  if (quick)
    return {{"one way, gradients at the end", Scheme::OneWay, 16, {10, 20, 40}, "lc rgb '#d55e00' pt 5"},
            {"malha, 1 iteration", Scheme::Malha, 16, {10, 20, 40}, "lc rgb '#0072b2' pt 7"},
            {"malha, as many iterations as substeps", Scheme::Converged, 16, {10, 20, 40}, "lc rgb '#009e73' pt 9"},
            {"the same, to half a substep later", Scheme::ConvergedLater, 16, {10, 20, 40}, "lc rgb '#000000' pt 13"}};
  return {{"one way, gradients at the end", Scheme::OneWay, 16, {5, 10, 20, 40, 80, 160, 320}, "lc rgb '#d55e00' pt 5"},
          {"malha, 1 iteration", Scheme::Malha, 16, {5, 10, 20, 40, 80, 160, 320}, "lc rgb '#0072b2' pt 7"},
          {"malha, 1 iteration, 46 edges", Scheme::Malha, 46, {5, 10, 20, 40, 80, 160}, "lc rgb '#56b4e9' pt 6 dt 2"},
          {"malha, as many iterations as substeps", Scheme::Converged, 16, {10, 20, 40, 80}, "lc rgb '#009e73' pt 9"},
          {"the same, to half a substep later", Scheme::ConvergedLater, 16, {5, 10, 20, 40}, "lc rgb '#000000' pt 13"}};
}

/// The positions of the chain's joints at a time.
using Joints = std::vector<ReferenceChain::Position>;
Joints joints_at(int edges, double time) {
  static std::map<int, std::vector<Joints>> known;  // after each step
  std::vector<Joints>& all = known[edges];
  if (all.empty()) {
    ReferenceChain chain(edges, 1, 9.81);
    // The longest substep after the end is included, for the series that is compared half a substep later.
    for (int k = 0; k < (kOrderFrames + 1) * kReferenceSubsteps; ++k) {
      chain.step(kFrame / kReferenceSubsteps);
      if (k >= (kOrderFrames - 1) * kReferenceSubsteps) all.push_back(chain.joints());
    }
  }
  // The chain starts with a whole kick as well, and is half a step ahead of its time.
  const double step = time / kFrame * kReferenceSubsteps - 1.5 - (kOrderFrames - 1) * kReferenceSubsteps;
  const int below = static_cast<int>(std::floor(step));
  const double part = step - below;
  Joints found = all.at(below);
  for (std::size_t i = 0; i < found.size(); ++i)
    for (int a = 0; a < 2; ++a) found[i][a] += part * (all.at(below + 1)[i][a] - found[i][a]);
  return found;
}

Scene order_sheet(int edges, int substeps, int iterations) {
  ConstraintSpec lengths;
  lengths.type = "distance", lengths.elements = {"edges", "shear"};
  BodySpec body;
  body.name = "sheet", body.shape = GridShape{{1, 1}, {edges, edges}}, body.mass = 0.2, body.pins = {RowPin{}};
  body.constraints = {lengths};
  Scene scene;
  scene.file = "malha study", scene.name = "sheet", scene.gravity = {0, -9.81, 0}, scene.bodies = {body};
  scene.solver.dt = kFrame, scene.solver.substeps = substeps, scene.solver.iterations = iterations;
  scene.solver.precision = Precision::Double;
  return scene;
}

/// The final positions of the sheet's particles.
Vector final_positions(const OrderLine& line, int substeps, const Cells& cells) {
  if (line.scheme != Scheme::OneWay) {
    Simulation simulation(order_sheet(line.edges, substeps, line.scheme == Scheme::Malha ? 1 : substeps),
                          {.threads = 1});
    for (int frame = 0; frame < kOrderFrames; ++frame) simulation.step(), cells.check_interrupt();
    return flat(simulation.positions());
  }
  Scene scene = order_sheet(line.edges, 1, 1);
  scene.bodies[0].constraints[0].compliance = 1;  // required by spring_system(); the sweep does not use it
  const auto system = spring_system(scene);
  PlainSweep<double> sweep(*system, order_by_colour(*system));
  for (int frame = 0; frame < kOrderFrames; ++frame, cells.check_interrupt())
    for (int k = 0; k < substeps; ++k) sweep.substep(kFrame / substeps);
  return sweep.state().x;
}

double order_error(const OrderLine& line, int substeps, const Cells& cells) {
  const bool later = line.scheme == Scheme::ConvergedLater;
  const Joints joints = joints_at(line.edges, kOrderTime + (later ? kFrame / substeps / 2 : 0));
  Vector truth(3 * joints.size() * joints.size());
  for (std::size_t i = 0, k = 0; i < joints.size(); ++i)
    for (std::size_t j = 0; j < joints.size(); ++j, k += 3)
      truth.segment<3>(k) = Eigen::Vector3d(double(j) / line.edges, joints[i][0], joints[i][1]);
  return rms_distance(final_positions(line, substeps, cells), truth);
}

/// The order -d log(error) / d log(substeps), by least squares.
double fitted_order(const std::vector<std::pair<double, double>>& points) {
  double x = 0, y = 0, xx = 0, xy = 0;
  for (const auto& [n, error] : points) {
    const double a = std::log(n), b = std::log(error);
    x += a, y += b, xx += a * a, xy += a * b;
  }
  const double count = static_cast<double>(points.size());
  return -(count * xy - x * y) / (count * xx - x * x);
}

}  // namespace

int order_cells(bool quick) {
  int count = 0;
  for (const OrderLine& line : order_lines(quick)) count += static_cast<int>(line.substeps.size());
  return count;
}

Section order_of_convergence(Cells& cells, Json& rows) {
  Section section{
      "A hanging sheet: order of convergence", {}, {}, {{"method", "edges", "substeps", "RMS error, m"}, {}}};
  Chart chart{"order",
              "set logscale xy\nset format x '%g'\nset format y '10^{%T}'\nset xlabel 'substeps a frame of 1/60 s'\n"
              "set ylabel 'RMS distance to the exact motion after 0.5 s (m)'\n"
              "set title 'A sheet of 1 m that hangs by a row, let go from the horizontal'\n",
              {}};
  section.sentences = {formatted(
      "1 m and 16 x 16 edges with both diagonals, inextensible, pinned at a row and released from the horizontal: its "
      "rows move as the joints of a chain of rigid links, whose motion is known to %g m (SHAKE, each step solved by "
      "Newton's method). Errors after %g s; the slope of each line is fitted to its logarithms.",
      kReferenceUncertainty, kOrderTime)};
  for (const OrderLine& line : order_lines(cells.quick())) {
    std::vector<std::pair<double, double>> points;
    bench::Series series{"", std::string("with linespoints lw 2 ") + line.style, line.title};
    for (const int n : line.substeps) {
      const std::string key = formatted("order: %s, %d", line.title.c_str(), n);
      const Json cell = cells(key, [&]() -> Json { return {{"error", order_error(line, n, cells)}}; });
      if (!cell.is_object()) continue;
      const double error = cell["error"].get<double>();
      points.push_back({n, error});
      series.data += formatted("%d %.6g\n", n, error);
      section.table.rows.push_back(
          {line.title, std::to_string(line.edges), std::to_string(n), formatted("%.3g", error)});
      rows.push_back({{"case", "order"},
                      {"series", line.title},
                      {"settings", std::to_string(n)},
                      {"variant", false},
                      {"ours", line.scheme != Scheme::OneWay},
                      {"precision", "double"},
                      {"substeps", n},
                      {"iterations", line.scheme == Scheme::Malha || line.scheme == Scheme::OneWay ? 1 : n},
                      {"refinement_iterations", 0},
                      {"key", key},
                      {"status", "finished"},
                      {"time_s", kOrderTime},
                      {"truth_known_to_m", kReferenceUncertainty},
                      {"rms_error_m", error}});
      copy_machine(rows.back(), cell);
    }
    if (points.size() < 2) continue;
    const double order = fitted_order(points);
    series.title += formatted(": slope %.1f", order);
    chart.series.push_back(series);
    section.sentences.push_back(line.title + formatted(": %.2g m with %g substeps, %.2g m with %g, slope %.2f.",
                                                       points.front().second, points.front().first,
                                                       points.back().second, points.back().first, order));
  }
  section.sentences.push_back(
      "From rest the first substep applies a whole kick at once, so that a run is half a substep ahead of the exact "
      "motion. Only this error is of first order: compared with the motion half a substep later, converged substeps "
      "are "
      "of second order, down to some 5e-5 m, where the remaining strains of 1e-6 limit them.");
  chart.settings += "set xrange [4:400]\n";
  section.chart = chart;
  return section;
}

}  // namespace malha::study
