// SPDX-License-Identifier: Apache-2.0
// Part of the study "stability": known failures due to random or collapsed initial positions, and to surfaces thinner
// than the displacement in a step.
#include <cmath>
#include <random>

#include "host/mesh/generate.h"
#include "host/solver/solver.h"
#include "host/solver/state.h"
#include "malha/simulation.h"
#include "malha/text.h"
#include "tools/bench/output.h"
#include "tools/study/reference/steps.h"
#include "tools/study/rows.h"
#include "tools/study/stability/lines.h"
#include "tools/study/stability/map.h"
#include "tools/study/stability/trial.h"

namespace malha::study {

namespace {

using bench::formatted;

enum class Start { Random, Collapsed, NearlyCollapsed };

/// Initial positions of a sheet's particles, in the user's order.
std::vector<Vec3> start_positions(const Scene& scene, int n, Start start) {
  std::vector<Vec3> places = make_mesh(scene.bodies[0].shape).points;
  std::mt19937 random(7);
  const auto unit = [&random] { return double(random()) / 4294967296.0; };  // the same with every standard library
  for (int i = 0; i < n * n; ++i) {
    if (i == 0 || i == n - 1) continue;
    places[i] = {0.5, -0.5, 0.5};
    if (start == Start::Random) places[i] = {unit(), unit() - 0.5, unit()};
    if (start == Start::NearlyCollapsed)
      for (double& a : places[i]) a += 1e-6 * unit();
  }
  return places;
}

constexpr int kHalf = 30, kEnd = 180;  // frames

/// RMS strains at the start, after 0.5 s and after 3 s (null if no longer finite), and the number of constraints
/// without a direction.
Json unfolding_strains(const Scene& scene, int n, Start start, const Cells& cells) {
  const Model model = build_model(scene);
  const std::unique_ptr<Solver> solver = make_solver(model, 1);
  const std::vector<Vec3> user = start_positions(scene, n, start);
  std::vector<Vec3> places;
  for (const int i : model.user_index) places.push_back(user[i]);
  solver->restore(save_state(state_at_rest<float>(places)));
  Json strain = Json::array({solver->measure().strain_rms});
  for (int frame = 1; frame <= kEnd; ++frame) {
    solver->step(), cells.check_interrupt();
    if (frame == kHalf || frame == kEnd) strain.push_back(solver->measure().strain_rms);
  }
  return {{"strain", strain}, {"degenerate", solver->measure().degenerate}};
}

/// The same strains by symplectic Euler, with a step that the springs' spectrum allows.
Json unfolding_strains_by_euler(const Scene& scene, int n, Start start, const Cells& cells) {
  const auto system = spring_system(scene);
  const double h = 0.5 / largest_frequency(*system, system->start.x);
  State state{flat(start_positions(scene, n, start)), Vector::Zero(system->start.x.size())};
  Json strain = Json::array({sample_of(*system, state).rms});
  const int half = int(kHalf * kFrame / h), end = int(kEnd * kFrame / h);
  for (int step = 1; step <= end; ++step) {
    symplectic_euler(*system, h, state), cells.check_interrupt();
    if (step != half && step != end) continue;
    const double now = sample_of(*system, state).rms;
    strain.push_back(std::isfinite(now) ? Json(now) : Json());
  }
  return {{"strain", strain}, {"degenerate", nullptr}};
}

constexpr double kThickness = 0.002;  // m

/// Throws 11 x 11 free particles at a wall, and returns how many are behind it in the end.
int count_tunnelled(double speed, const Cells& cells) {
  BodySpec bullets;
  bullets.name = "bullets", bullets.shape = LatticeShape{{-1, -0.5, -0.5}, {-1, 0.5, 0.5}, {1, 11, 11}};
  bullets.mass = 1, bullets.velocity = {speed, 0, 0};
  EnvironmentSpec wall;
  wall.name = "wall", wall.shape = GridShape{{10, 10}, {4, 4}}, wall.sides = Sides::TwoSided,
  wall.thickness = kThickness;
  wall.transform.translate = {0, -5, -5}, wall.transform.axis = {0, 0, 1}, wall.transform.degrees = 90;
  Scene scene;
  scene.file = "malha study", scene.name = "bullets", scene.bodies = {bullets}, scene.environment = {wall};
  scene.solver.dt = kFrame, scene.solver.substeps = 1;
  Simulation simulation(scene, {.threads = 1});
  const int steps = std::max(2, int(std::ceil(2 / speed / kFrame)));
  for (int step = 0; step < steps; ++step) simulation.step(), cells.check_interrupt();
  int count = 0;
  for (const Vec3& x : simulation.positions()) count += x[0] > 0;
  return count;
}

/// True if a particle would pass the wall with a discrete test at the end of each step, which finds particles within
/// the thickness. `phase`: offset of the start, in steps.
bool tunnels_through_end_test(double speed, double phase) {
  double x = -1 - phase * speed * kFrame;
  while (x < -kThickness) x += speed * kFrame;
  return x > kThickness;
}

/// The number of intersections of edges and triangles after one sheet was thrown at another.
double count_intersections(double speed, const Cells& cells) {
  Scene scene = hanging_sheet(9, 0.5, 0.05, 0);
  scene.gravity = {0, 0, 0}, scene.solver.substeps = 1, scene.solver.iterations = 4;
  scene.bodies[0].pins.clear();
  BodySpec other = scene.bodies[0];
  other.name = "other", other.transform.translate = {0.03, 0.3, 0.02}, other.velocity = {0, -speed, 0};
  scene.bodies.push_back(other);
  SelfCollision self;
  self.thickness = kThickness;
  scene.self_collision = self;
  Simulation simulation(scene, {.threads = 1});
  const int steps = std::max(2, int(std::ceil(0.6 / speed / kFrame)));
  for (int step = 0; step < steps; ++step) simulation.step(), cells.check_interrupt();
  return double(simulation.measure().crossings);
}

}  // namespace

Section start_failure(Cells& cells, Json& rows) {
  const int n = cells.quick() ? 7 : 17;
  Section section{formatted("Random and collapsed starts: %d x %d particles pinned at two corners", n, n)};
  section.table.columns = {"start",       "method",    "RMS strain at the start",
                           "after 0.5 s", "after 3 s", "without a direction"};
  const std::vector<std::pair<Start, std::string>> starts{
      {Start::Random, "anywhere in 1 m^3"}, {Start::NearlyCollapsed, "within 1e-6 m"}, {Start::Collapsed, "one point"}};
  struct Unfolding {
    Start start;
    std::string title, method;
  };
  std::vector<Unfolding> all;
  for (const auto& [start, title] : starts)
    for (const char* method : {"PBD", "XPBD, 1 kN/m", "Desbrun, 1 kN/m", "symplectic Euler, 1 kN/m"})
      all.push_back({start, title, method});
  const std::vector<Json> kept = cells.measure_all(
      all,
      [&](const Unfolding& unfolding) {
        return formatted("start: %d, %s, %s", n, unfolding.title.c_str(), unfolding.method.c_str());
      },
      [&](const Unfolding& unfolding) {
        Scene scene = corner_pinned_sheet(n, 1, 0.2, unfolding.method == "PBD" ? 0 : 1e-3);
        if (unfolding.method.starts_with("Desbrun")) scene.solver.type = "desbrun";
        return unfolding.method.starts_with("symplectic") ? unfolding_strains_by_euler(scene, n, unfolding.start, cells)
                                                          : unfolding_strains(scene, n, unfolding.start, cells);
      });
  if (cells.is_partial()) return section;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const auto& [start, title, method] = all[k];
    const Json& cell = kept[k];
    std::vector<std::string> row{title, method};
    for (const auto& strain : cell["strain"])
      row.push_back(strain.is_null() ? "not finite" : formatted("%.2g", strain.get<double>()));
    row.push_back(cell["degenerate"].is_null() ? "" : std::to_string(cell["degenerate"].get<int>()));
    section.table.rows.push_back(row);
    rows.push_back({{"map", "start"}, {"panel", method}, {"x_name", title}, {"rms_strain", cell["strain"].back()}});
    copy_machine(rows.back(), cell);
    section.sentences.push_back(method + ", " + title + ": RMS strain " + row[2] + " at the start and " + row[4] +
                                " after 3 s.");
  }
  section.sentences.push_back(
      "Remedy: a constraint between coincident particles has no direction. It is skipped, and counted in the report "
      "(degenerate_constraints_skipped), until other constraints separate its ends.");
  return section;
}

Section thickness_failure(Cells& cells, Json& rows) {
  Section section{"Thickness smaller than the displacement in a step"};
  section.table.columns = {"speed, m/s", "displacement in a step, thicknesses", "passed, malha, of 121",
                           "passed, discrete test", "intersections of two sheets, malha"};
  double most = 0, unseen_most = 0;
  const std::vector<double> speeds =
      cells.quick() ? std::vector<double>{1, 100} : std::vector<double>{0.1, 1, 10, 100, 1000};
  const std::vector<Json> kept = cells.measure_all(
      speeds, [](double speed) { return formatted("thickness: %g m/s", speed); },
      [&](double speed) -> Json {
        return {{"passed", count_tunnelled(speed, cells)}, {"crossings", count_intersections(speed, cells)}};
      });
  if (cells.is_partial()) return section;
  for (std::size_t at = 0; at < speeds.size(); ++at) {
    const double speed = speeds[at];
    const Json& cell = kept[at];
    int unseen = 0;
    for (int k = 0; k < 100; ++k) unseen += tunnels_through_end_test(speed, k / 100.0);
    section.table.rows.push_back({short_number(speed), formatted("%.3g", speed * kFrame / kThickness),
                                  std::to_string(cell["passed"].get<int>()), formatted("%d %%", unseen),
                                  formatted("%g", cell["crossings"].get<double>())});
    rows.push_back({{"map", "thickness"},
                    {"x_name", "speed (m/s)"},
                    {"x", speed},
                    {"passed", cell["passed"]},
                    {"passed_unseen_percent", unseen},
                    {"crossings", cell["crossings"]}});
    copy_machine(rows.back(), cell);
    most = std::max({most, cell["passed"].get<double>(), cell["crossings"].get<double>()});
    unseen_most = std::max(unseen_most, double(unseen));
  }
  section.sentences = {
      formatted(
          "121 particles fly at a wall %g m thick, and a sheet at another, one substep per step: a discrete test at "
          "the ends of steps lets up to %g %% pass; with malha, %g pass or intersect.",
          kThickness, unseen_most, most),
      "Remedy: collisions are detected along the whole motion (Embree's rays, swept boxes, division planes)."};
  return section;
}

}  // namespace malha::study
