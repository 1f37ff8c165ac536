// SPDX-License-Identifier: Apache-2.0
#include "host/scene/scene_read.h"

namespace malha {
namespace {

std::vector<JsonReader::Field> desbrun_fields(SolverSpec& solver) {
  DesbrunSpec& desbrun = solver.desbrun;
  return {
      {"spring_constant", [&](const JsonReader& v) { desbrun.spring_constant = v.number(above(0, "N/m")); }},
      {"filter",
       [&](const JsonReader& v) {
         const std::string name = v.choice("filter", {"auto", "dense", "sparse"});
         desbrun.filter = name == "dense"    ? FilterKind::Dense
                          : name == "sparse" ? FilterKind::Sparse
                                             : FilterKind::Auto;
       }},
      {"storage",
       [&](const JsonReader& v) {
         const std::string name = v.choice("storage", {"float", "double", "int16"});
         desbrun.storage = name == "double" ? Storage::Double : name == "int16" ? Storage::Int16 : Storage::Float;
         if (desbrun.storage == Storage::Int16 && desbrun.filter == FilterKind::Sparse)
           v.refuse("int16 with the filter \"sparse\"", "float or double there; int16 is for \"dense\"");
       }},
      {"filter_external_forces", [&](const JsonReader& v) { desbrun.filter_external_forces = v.boolean(); }},
      {"corrector",
       [&](const JsonReader& v) {
         const std::string name = v.choice("corrector", {"inertia", "paper", "off"});
         desbrun.corrector = name == "inertia" ? Corrector::Inertia
                             : name == "paper" ? Corrector::Paper
                                               : Corrector::Off;
       }},
      {"refinement_iterations", [&](const JsonReader& v) { desbrun.refinement_iterations = v.integer(0, 1000); }},
      {"tolerance",
       [&](const JsonReader& v) { desbrun.tolerance = v.number(at_least(0, "of a distance limit's length")); }},
      {"time_budget", [&](const JsonReader& v) { desbrun.time_budget = v.number(above(0, "s")); }},
  };
}

int read_levels(const JsonReader& at) {
  if (at.value().type == JsonValue::Type::Text) return at.choice("choice", {"auto", "off"}) == "auto" ? kAutoLevels : 0;
  return at.integer(1, kMaxLevels);
}

}  // namespace

SolverSpec read_solver(const JsonReader& at) {
  constexpr int max_passes = 100000;
  SolverSpec solver;
  solver.type = at.at("type").choice("solver", {"pbd", "desbrun"});
  std::vector<JsonReader::Field> fields{
      {"type", [](const JsonReader&) {}, true},
      {"dt", [&](const JsonReader& v) { solver.dt = v.number(above(0, "s")); }},
      {"substeps", [&](const JsonReader& v) { solver.substeps = v.integer(1, max_passes); }},
      {"iterations", [&](const JsonReader& v) { solver.iterations = v.integer(1, max_passes); }},
      {"precision",
       [&](const JsonReader& v) {
         solver.precision =
             v.choice("precision", {"float", "double"}) == "double" ? Precision::Double : Precision::Float;
       }},
  };
  if (solver.type == "pbd") {
    fields.push_back({"corrector", [&](const JsonReader& v) {
                        solver.keeps_momenta = v.choice("corrector", {"inertia", "off"}) == "inertia";
                      }});
    fields.push_back({"levels", [&](const JsonReader& v) { solver.levels = read_levels(v); }});
    fields.push_back(
        {"levels_interval", [&](const JsonReader& v) { solver.levels_interval = v.integer(1, kMaxLevelsInterval); }});
    fields.push_back({"stiffness_basis", [&](const JsonReader& v) {
                        solver.stiffness_of_step = v.choice("choice", {"projections", "step"}) == "step";
                      }});
  }
  if (solver.type == "desbrun") {
    solver.substeps = 1, solver.iterations = 10;
    if (at.has("stiffness"))  // the former name of the key
      at.at("stiffness").refuse("'stiffness', which is a constraint's, from 0 to 1", "'spring_constant' (N/m)");
    for (JsonReader::Field& field : desbrun_fields(solver)) fields.push_back(std::move(field));
  }
  at.object(fields);
  return solver;
}

}  // namespace malha
