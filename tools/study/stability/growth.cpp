// SPDX-License-Identifier: Apache-2.0
// Part of the study "stability": growth of small motions about rest, by the order of the sweep and by the kind of
// constraint, and conservation of a free body's energy and momenta over a minute.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>

#include "host/report/amplification.h"
#include "malha/simulation.h"
#include "tools/bench/irregular.h"
#include "tools/bench/output.h"
#include "tools/study/reference/sweep.h"
#include "tools/study/rows.h"
#include "tools/study/stability/lines.h"
#include "tools/study/stability/maps.h"

namespace malha::study {

namespace {

using bench::formatted;

constexpr double kLeastGrowth = 0.1;  // 1/s; smaller and negative growth is drawn here

ConstraintSpec of_kind(const std::string& type, std::optional<double> rigidity = {}, double stiffness = 1) {
  ConstraintSpec spec;
  spec.type = type, spec.rigidity = rigidity, spec.stiffness = stiffness;
  if (type == "distance") spec.elements = {"edges"};
  if (type == "membrane" || type == "neo_hookean") spec.young_modulus = 1000, spec.parameter = 0.3;
  if (type == "plate") spec.parameter = 0;  // Poisson's ratio
  return spec;
}

Scene body_in_vacuum(const Shape& shape, const std::vector<ConstraintSpec>& kinds, int substeps) {
  BodySpec body;
  body.name = "body", body.shape = shape, body.mass = 1, body.constraints = kinds;
  Scene scene;
  scene.file = "malha study", scene.name = "body", scene.bodies = {body};
  scene.solver.dt = kFrame, scene.solver.substeps = substeps, scene.solver.precision = Precision::Double;
  return scene;
}

/// Growth rate of small motions about rest, 1/s; NaN if the body does not come to rest.
double growth_of(const Scene& scene, const Cells& cells) {
  constexpr int steps = 180;
  const auto found = measure_amplification(scene, 0, steps);
  cells.check_interrupt();
  return found ? found->growth : NAN;
}

/// An irregular sheet whose points are numbered row by row, or shuffled.
Shape irregular(bool by_rows) {
  Mesh mesh = bench::irregular_sheet(17, 1);
  if (by_rows) {
    std::vector<int> order(mesh.points.size()), place(mesh.points.size());
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [&](int a, int b) {
      const auto row = [&](int i) { return std::pair(std::round(16 * mesh.points[i][2]), mesh.points[i][0]); };
      return row(a) < row(b);
    });
    std::vector<Vec3> points;
    for (std::size_t k = 0; k < order.size(); ++k) place[order[k]] = int(k), points.push_back(mesh.points[order[k]]);
    for (Quad& face : mesh.faces)
      for (int& corner : face)
        if (corner >= 0) corner = place[corner];
    std::sort(mesh.faces.begin(), mesh.faces.end());
    mesh.points = points;
  }
  return MeshDataShape{mesh.points, mesh.faces, {}, {}};
}

struct SweepOrder {
  std::string title;
  std::vector<int> order;
  bool back = false;
};

Section growth_by_order(Cells& cells, Json& rows) {
  LineChart lines{"amplification",
                  "Growth of small motions about rest, by the order of the sweep: a shell of 162 particles",
                  "substeps a frame of 1/60 s",
                  "growth a second (0.1: none)",
                  {}};
  const Shape shell = SphereShape{0.5, 2};
  const std::vector<ConstraintSpec> lengths{of_kind("distance")};
  Scene springs = body_in_vacuum(shell, lengths, 1);
  springs.bodies[0].constraints[0].compliance = 1;  // required by spring_system(); linearised_sweep() does not use it
  const auto system = spring_system(springs);
  std::vector<int> in_order(system->springs.size());
  std::iota(in_order.begin(), in_order.end(), 0);
  std::vector<int> shuffled = in_order;
  std::mt19937 random(1);
  for (std::size_t k = shuffled.size(); k > 1; --k) std::swap(shuffled[k - 1], shuffled[random() % k]);
  std::vector<SweepOrder> all{{"one way, in order", in_order}, {"there and back, in order", in_order, true}};
  if (!cells.quick())
    all.insert(all.begin() + 1, {{"one way, shuffled", shuffled}, {"one way, by colours", order_by_colour(*system)}});
  const std::vector<double> counts =
      cells.quick() ? std::vector<double>{10, 160} : std::vector<double>{10, 20, 40, 80, 160};
  for (const SweepOrder& sweep_order : all) {
    Line of_substep{sweep_order.title, {}}, line{sweep_order.title, {}};
    of_substep.add(1, cells, "amplification, " + sweep_order.title, [&] {
      std::vector<int> order = sweep_order.order;
      if (sweep_order.back) order.insert(order.end(), sweep_order.order.rbegin(), sweep_order.order.rend());
      return amplification_of_sweep(linearised_sweep(*system, order));
    });
    for (const double n : counts)
      line.points.push_back({n, std::max(kLeastGrowth, std::log(of_substep.at(1)) * n / kFrame)}),
          line.cells.push_back(of_substep.cells[0]);
    lines.lines.push_back(line);
  }
  const Line malha_line = line_over(cells, lines, "malha", counts, 1, [&](double n) {
    return std::max(kLeastGrowth, growth_of(body_in_vacuum(shell, lengths, int(n)), cells));
  });
  lines.lines.push_back(malha_line);
  if (cells.is_partial()) return {};
  Section section = lines_section(lines, rows);
  section.sentences.push_back(
      "Hard constraints on the lengths of the edges. For the plain orders the growth is the spectral radius from the "
      "eigenvalues of the whole linearised sweep; for malha it is measured as by malha plan.");
  for (const Line& line : lines.lines) {
    const auto& [n, growth] = line.points.front();
    section.sentences.push_back(
        line.title + (growth > kLeastGrowth
                          ? formatted(": with %g substeps motion grows by %.3g a second, %.3g times a substep.", n,
                                      growth, std::exp(growth * kFrame / n))
                          : ": it does not grow."));
  }
  return section;
}

Section growth_by_kind(Cells& cells, Json& rows) {
  Section section{"Growth of small motions about rest: kinds, meshes, numberings"};
  const std::vector<int> counts = cells.quick() ? std::vector<int>{10} : std::vector<int>{10, 40, 160};
  section.table.columns = {"constraints", "mesh"};
  for (const int n : counts) section.table.columns.push_back(formatted("growth a second, %d substeps", n));
  const ConstraintSpec lengths = of_kind("distance");
  const std::vector<std::pair<std::string, std::vector<ConstraintSpec>>> kinds{
      {"distance", {lengths}},
      {"distance, bending of stiffness 0.02", {lengths, of_kind("bending", {}, 0.02)}},
      {"distance, bending of 1e-3 N m", {lengths, of_kind("bending", 1e-3)}},
      {"distance, isometric_bending of 1e-3 N m", {lengths, of_kind("isometric_bending", 1e-3)}},
      {"distance, plate of 1e-3 N m", {lengths, of_kind("plate", 1e-3)}},
      {"membrane of 1 kN/m", {of_kind("membrane")}}};
  const std::vector<std::pair<std::string, Shape>> meshes{{"grid of 17 x 17", GridShape{{1, 1}, {16, 16}}},
                                                          {"irregular, by rows", irregular(true)},
                                                          {"irregular, shuffled", irregular(false)}};
  struct GrowthCase {
    std::string kind, mesh;
    Scene scene;
  };
  std::vector<GrowthCase> all;
  for (const auto& [kind, constraints] : kinds)
    for (const auto& [mesh, shape] : meshes)
      if (!cells.quick() || (mesh == meshes.back().first && kind != "membrane of 1 kN/m"))
        all.push_back({kind, mesh, body_in_vacuum(shape, constraints, 1)});
  all.push_back(
      {"distance, pressure", "shell", body_in_vacuum(SphereShape{0.5, 2}, {lengths, of_kind("pressure")}, 1)});
  all.push_back({"neo_hookean of 1 kPa", "cells of five tetrahedra",
                 body_in_vacuum(TetBoxShape{{1, 0.3, 0.3}, {9, 3, 3}}, {of_kind("neo_hookean")}, 1)});
  if (!cells.quick()) {
    Scene hung = body_in_vacuum(GridShape{{1, 1}, {46, 46}}, {lengths}, 1);
    hung.bodies[0].pins = {RowPin{}}, hung.solver.levels = kAutoLevels;
    all.push_back({"distance, with levels", "grid of 47 x 47, pinned by a row", hung});
  }
  double most = -INFINITY;
  for (const GrowthCase& one : all) {
    std::vector<std::string> row{one.kind, one.mesh};
    for (const int n : counts) {
      Scene scene = one.scene;
      scene.solver.substeps = n;
      Line cell{one.kind, {}};
      cell.add(n, cells, formatted("growth, %s, %s, %d", one.kind.c_str(), one.mesh.c_str(), n),
               [&] { return growth_of(scene, cells); });
      if (cell.cells[0].is_null()) continue;
      const double growth = cell.at(n);
      most = std::max(most, growth);
      row.push_back(formatted("%.2g", growth));
      rows.push_back({{"map", "growth"},
                      {"panel", one.kind + ", " + one.mesh},
                      {"x_name", "substeps"},
                      {"x", n},
                      {"y_name", "growth a second"},
                      {"y", growth}});
      copy_machine(rows.back(), cell.cells[0]);
    }
    section.table.rows.push_back(row);
  }
  if (cells.is_partial()) return {};
  section.sentences = {"Undamped bodies of 1 m in vacuum, by malha in double, as malha plan measures them over 3 s.",
                       formatted("The largest growth of all is %.2g a second: ", most) +
                           (most < 0.5 ? "none adds energy." : "some add energy.")};
  return section;
}

}  // namespace

std::vector<Section> growth_of_motion(Cells& cells, Json& rows) {
  return {growth_by_order(cells, rows), growth_by_kind(cells, rows)};
}

Section minute_in_vacuum(Cells& cells, Json& rows) {
  LineChart lines{"minute",
                  "A free shell that turns, in vacuum, 10 substeps: what it keeps",
                  "time (s)",
                  "change, over what it had",
                  {}};
  Scene scene = body_in_vacuum(SphereShape{0.5, 2}, {of_kind("distance")}, 10);
  scene.bodies[0].transform.scale = {1, 2, 0.5};  // so that it tumbles
  scene.bodies[0].velocity = {0.3, 0.2, -0.1}, scene.bodies[0].spin = {2, 3, -1};
  Scene springs = scene;
  springs.bodies[0].constraints[0].compliance = 1;
  auto system = spring_system(springs);
  for (Spring& s : system->springs) s.stiffness = 0;  // hard: no elastic energy
  const ConservedQuantities then = conserved_quantities(*system, system->start);
  const std::vector<double> times =
      cells.quick() ? std::vector<double>{1, 10} : std::vector<double>{1, 2, 5, 10, 20, 60};
  enum Quantity { Energy, Momentum, Angular };
  constexpr std::array names{"energy", "momentum", "angular momentum"};
  const auto add = [&](const std::string& title, const std::vector<Quantity>& shown, const std::function<void()>& frame,
                       const std::function<State()>& state) {
    const Json cell = cells("minute: " + title, [&]() -> Json {
      Json at = Json::array();
      int frames = 0;
      for (const double time : times) {
        for (; frames < std::lround(time / kFrame); ++frames) frame(), cells.check_interrupt();
        const ConservedQuantities now = conserved_quantities(*system, state());
        at.push_back({std::abs(now.kinetic - then.kinetic) / then.kinetic,
                      (now.momentum - then.momentum).norm() / then.momentum.norm(),
                      (now.angular_momentum - then.angular_momentum).norm() / then.angular_momentum.norm()});
      }
      return {{"at", at}};
    });
    for (const Quantity what : shown) {
      Line line{title + ": " + names[what], {}};
      for (std::size_t k = 0; cell.is_object() && k < times.size(); ++k)
        line.points.push_back({times[k], cell["at"][k][what].get<double>()}), line.cells.push_back(cell);
      lines.lines.push_back(line);
    }
  };
  PlainSweep<double> plain(*system, order_by_colour(*system));
  const auto sweep = [&] {
    for (int k = 0; k < 10; ++k) plain.substep(kFrame / 10);
  };
  add("one way", {Energy, Angular}, sweep, [&] { return plain.state(); });
  for (const Precision precision : {Precision::Float, Precision::Double}) {
    const bool in_float = precision == Precision::Float;
    scene.solver.precision = precision;
    Simulation simulation(scene, {.threads = 1});
    add(
        in_float ? "malha, float" : "malha, double",
        in_float ? std::vector{Momentum, Angular} : std::vector{Energy, Momentum, Angular}, [&] { simulation.step(); },
        [&] {
          return State{flat(simulation.positions()), flat(simulation.velocities())};
        });
  }
  if (cells.is_partial()) return {};
  Section section = lines_section(lines, rows);
  section.sentences.push_back(
      formatted("After %g s, over what there was: ", times.back()) +
      listed(lines.lines, [&](const Line& line) { return line.title + formatted(" %.2g", line.at(times.back())); }) +
      ".");
  section.sentences.push_back(
      "One way: a plain sweep in double by colours, along current gradients. malha's sweeps are symmetric (there and "
      "back), along the gradients at the start of the substep.");
  return section;
}

}  // namespace malha::study
