// SPDX-License-Identifier: Apache-2.0
#include "host/scene/scene_fields.h"

namespace malha {

namespace {

Fields fields_of(DesbrunSpec& desbrun) {
  return {
      field("spring_constant", desbrun.spring_constant, above(0, "N/m")),
      choice("filter", "filter", desbrun.filter,
             {{"auto", FilterKind::Auto}, {"dense", FilterKind::Dense}, {"sparse", FilterKind::Sparse}}),
      checked(choice("storage", "storage", desbrun.storage,
                     {{"float", Storage::Float}, {"double", Storage::Double}, {"int16", Storage::Int16}}),
              [&desbrun](const JsonReader& at) {
                if (desbrun.storage == Storage::Int16 && desbrun.filter == FilterKind::Sparse)
                  at.refuse("int16 with the filter \"sparse\"", "float or double there; int16 is for \"dense\"");
              }),
      field("filter_external_forces", desbrun.filter_external_forces),
      choice("corrector", "corrector", desbrun.corrector,
             {{"inertia", Corrector::Inertia}, {"paper", Corrector::Paper}, {"off", Corrector::Off}}),
      field("refinement_iterations", desbrun.refinement_iterations, Integers{0, 1000}),
      field("tolerance", desbrun.tolerance, at_least(0, "of a distance limit's length")),
      field("time_budget", desbrun.time_budget, above(0, "s")),
  };
}

Field levels_field(int& levels) {
  const auto read = [&levels](const JsonReader& at) {
    const bool word = at.value().is_string();
    levels = !word ? at.integer({1, kMaxLevels}) : at.choice("choice", {"auto", "off"}) == "auto" ? kAutoLevels : 0;
  };
  return {"levels", read, false, [&levels](JsonValue& json) {
            json["levels"] = levels > 0 ? JsonValue(levels) : JsonValue(levels == 0 ? "off" : "auto");
          }};
}

}  // namespace

Fields fields_of(SolverSpec& solver) {
  constexpr int max_passes = 100000;
  Fields fields{
      {"type", [](const JsonReader&) {}, true, [&](JsonValue& json) { json["type"] = solver.type; }},
      field("dt", solver.dt, above(0, "s")),
      field("substeps", solver.substeps, Integers{1, max_passes}),
      field("iterations", solver.iterations, Integers{1, max_passes}),
      choice("precision", "precision", solver.precision, {{"float", Precision::Float}, {"double", Precision::Double}}),
  };
  const auto add = [&fields](Fields more) { fields.insert(fields.end(), more.begin(), more.end()); };
  if (solver.type == "pbd")
    add({choice("corrector", "corrector", solver.keeps_momenta, {{"inertia", true}, {"off", false}}),
         levels_field(solver.levels),
         written_if(solver.levels_interval > 0,
                    field("levels_interval", solver.levels_interval, Integers{1, kMaxLevelsInterval})),
         choice("bending", "bending", solver.bending,
                {{"auto", BendingMethod::Auto},
                 {"projected", BendingMethod::Projected},
                 {"filtered", BendingMethod::Filtered}}),
         choice("stiffness_basis", "choice", solver.stiffness_of_step, {{"projections", false}, {"step", true}})});
  if (solver.type == "desbrun") add(fields_of(solver.desbrun));
  return fields;
}

SolverSpec read_solver(const JsonReader& at) {
  SolverSpec solver;
  solver.type = at.at("type").choice("solver", {"pbd", "desbrun"});
  if (solver.type == "desbrun") {
    solver.substeps = 1, solver.iterations = 10;
    if (at.has("stiffness"))  // the former name of the key
      at.at("stiffness").refuse("'stiffness', which is a constraint's, from 0 to 1", "'spring_constant' (N/m)");
  }
  at.object(fields_of(solver));
  return solver;
}

}  // namespace malha
