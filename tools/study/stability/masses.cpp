// SPDX-License-Identifier: Apache-2.0
// Maps of the study "stability" that need many projections: heavy weights, and bodies of many particles.
#include <cmath>

#include "tools/bench/output.h"
#include "tools/study/stability/maps.h"

namespace malha::study {

namespace {

using bench::formatted;

constexpr int kFrames = 120;
constexpr int kLinks = 20;
constexpr double kLength = 1, kLight = 0.01;  // m, kg

/// A chain, horizontal at the start and pinned at one end, whose last particle is `ratio` times as heavy as the others.
Model weighted_chain(double ratio, const SolverSpec& solver, double compliance) {
  Scene scene = pinned_chain({kLength, 0, 0}, kLinks, kLight * (kLinks + 1), compliance);
  scene.solver = solver, scene.solver.dt = kFrame, scene.solver.levels = 0;
  Model model = build_model(scene);
  for (int i = 0; i < model.count(); ++i) {
    model.mass[i] = kLight * (model.user_index[i] == kLinks ? ratio : 1);
    if (model.user_index[i] != 0) model.w[i] = 1 / model.mass[i];
  }
  return model;
}

/// The number of substeps with which one sweep per substep leaves this strain. A link between particles of mass m that
/// bears `load` times their weight stays 2 load g h^2 too long: each end moves by half of the excess length, which must
/// compensate load g h^2.
double substeps_for(double load, double length, double strain) {
  return kFrame * std::sqrt(2 * load * kGravity / (length * strain));
}

std::string boundary_sentence(const Panel& panel) {
  std::string line;
  for (std::size_t k = 0; k < panel.columns.size(); ++k) {
    const Json& column = panel.columns[k];
    line += (line.empty() ? "" : ", ") + short_number(panel.x.values[k]) + ": ";
    const bool all = column["verdicts"].back() == int(Verdict::Stable);
    line += column.contains("stable_to") ? formatted("%g", column["stable_to"].get<double>())
            : all                        ? std::string("1")
                                         : formatted("more than %g", panel.y.values[0]);
    if (column.contains("stable_from")) line += formatted(" (and at most %g)", column["stable_from"].get<double>());
  }
  return panel.title + ": the fewest " + panel.y.name + " that are stable, by " + panel.x.name + ": " + line + ".";
}

Outcome chain_outcome(double ratio, const SolverSpec& solver, double compliance, const Cells& cells) {
  const double scale = kLight * (kLinks + ratio) * kGravity * kLength;
  return judge(malha_trial(weighted_chain(ratio, solver, compliance), kFrames, scale), cells);
}

Outcome sheet_outcome(int n, const SolverSpec& solver, bool corners, double compliance, const Cells& cells) {
  constexpr double side = 2, mass = 1;
  Scene scene = (corners ? corner_pinned_sheet : hanging_sheet)(n, side, mass, compliance);
  scene.solver = solver, scene.solver.dt = kFrame,
  scene.solver.levels = 0;  // the map is about sweeps over the particles
  return judge(malha_trial(scene, kFrames, mass * kGravity * side), cells);
}

}  // namespace

Section masses_map(Cells& cells, Json& rows) {
  const bool quick = cells.quick();
  const Axis x{"mass ratio", quick ? std::vector<double>{10, 1e3} : std::vector<double>{1, 10, 100, 1e3, 1e4, 1e5}};
  const std::vector<double> counts = quick ? std::vector<double>{1024, 64, 16, 4, 1}
                                           : std::vector<double>{1024, 512, 256, 128, 64, 32, 16, 8, 4, 2, 1};
  TheoryLine theory{"one sweep leaves 2 (3 R) g h^2 / l = 50 %", {}};
  for (const double ratio : x.values)
    theory.points.push_back({ratio, substeps_for(3 * ratio, kLength / kLinks, kWrongStrain)});
  struct Variant {
    const char *title, *counted;
    bool springs = false;
    SolverSpec solver = {};
  };
  std::vector<Variant> variants{{"PBD, double", "substeps"},
                                {"PBD, float", "substeps"},
                                {"PBD, 1 substep", "iterations"},
                                {"PBD, 10 substeps", "iterations"},
                                {"XPBD, 1 % springs", "substeps", true},
                                {"Desbrun, 1 % springs", "substeps", true}};
  for (Variant& variant : variants) variant.solver.precision = Precision::Double;
  variants[1].solver.precision = Precision::Float;
  variants[2].solver.substeps = 1, variants[3].solver.substeps = 10, variants[5].solver.type = "desbrun";
  std::vector<Panel> panels;
  for (const Variant& variant : variants) {
    Panel panel{variant.title, x, {variant.counted, counts}};
    const bool substeps = variant.counted == std::string("substeps");
    if (substeps && variant.solver.type == "pbd") panel.theory = {theory};
    run_columns(
        panel, cells, std::string("masses: ") + variant.title + ", 1:", "", true, [&](std::size_t k, double count) {
          const double ratio = x.values[k];
          SolverSpec solver = variant.solver;
          (substeps ? solver.substeps : solver.iterations) = int(count);
          return chain_outcome(ratio, solver,
                               variant.springs ? 0.01 * kLength / kLinks / ((ratio + kLinks) * kLight * kGravity) : 0,
                               cells);
        });
    panels.push_back(panel);
  }
  Section section{"Mass ratio, by substeps and by iterations"};
  if (cells.is_partial()) return section;
  section.sentences = {formatted(
      "A chain of %d links (1 m) is released from the horizontal for 2 s in steps of 1/60 s. Its last particle "
      "is R times as heavy as each of the others. With one sweep per substep h, a link that bears the weight of n "
      "particles stays 2 n g h^2 too long: each of its ends moves by half of that, which must compensate the "
      "fall. A link of a body that swings down bears up to three times its weight.",
      kLinks)};
  for (const Panel& panel : panels) section.sentences.push_back(boundary_sentence(panel));
  complete_map_section(section, "masses", "A weight at the end of a chain", panels, 3, rows);
  return section;
}

Section resolution_map(Cells& cells, Json& rows) {
  const bool quick = cells.quick();
  const Axis x{"particles a side", quick ? std::vector<double>{9, 33} : std::vector<double>{9, 17, 33, 65, 129}};
  const std::vector<double> counts =
      quick ? std::vector<double>{16, 4, 1} : std::vector<double>{64, 32, 16, 8, 4, 2, 1};
  TheoryLine theory{"one sweep leaves 2 (n / 3) g h^2 / l = 50 %, at rest", {}};
  for (const double n : x.values) theory.points.push_back({n, substeps_for(n / 3, 2 / (n - 1), kWrongStrain)});
  struct Variant {
    const char *title, *counted;
    bool corners, springs = false, filtered = false;
  };
  std::vector<Panel> panels;
  for (const Variant& variant :
       {Variant{"PBD, held at one row", "substeps", false}, Variant{"PBD, two corners", "substeps", true},
        Variant{"PBD, 1 substep, one row", "iterations", false},
        Variant{"XPBD 10 kN/m, one row", "substeps", false, true},
        Variant{"XPBD 10 kN/m, two corners", "substeps", true, true},
        Variant{"Desbrun 10 kN/m, two corners", "substeps", true, true, true}}) {
    Panel panel{variant.title, x, {variant.counted, counts}};
    if (panels.empty()) panel.theory = {theory};
    run_columns(panel, cells, std::string("resolution: ") + variant.title + ", ", "", true,
                [&](std::size_t k, double count) {
                  SolverSpec solver;
                  const bool substeps = variant.counted == std::string("substeps");
                  solver.substeps = substeps ? int(count) : 1, solver.iterations = substeps ? 1 : int(count);
                  if (variant.filtered) solver.type = "desbrun", solver.desbrun.filter = FilterKind::Sparse;
                  return sheet_outcome(int(x.values[k]), solver, variant.corners, variant.springs ? 1e-4 : 0, cells);
                });
    panels.push_back(panel);
  }
  Section section{"Resolution, by substeps"};
  if (cells.is_partial()) return section;
  section.sentences = {
      "A sheet of 2 m and 1 kg is released from the horizontal for 2 s in steps of 1/60 s. The edge and the two "
      "diagonals that support each particle next to the row bear a column of n particles."};
  for (const Panel& panel : panels) section.sentences.push_back(boundary_sentence(panel));
  complete_map_section(section, "resolution", "A hanging sheet: particles a side and substeps", panels, 3, rows);
  return section;
}

}  // namespace malha::study
