// SPDX-License-Identifier: Apache-2.0
#include "host/scene/scene_read.h"

namespace malha {
namespace {

std::vector<JsonReader::Field> desbrun_fields(SolverSpec& solver) {
  DesbrunSpec& own = solver.desbrun;
  return {
      {"spring_constant", [&](const JsonReader& v) { own.spring_constant = v.number(above(0, "N/m")); }},
      {"filter",
       [&](const JsonReader& v) {
         const std::string word = v.word("filter", {"auto", "dense", "sparse"});
         own.filter = word == "dense" ? FilterKind::Dense : word == "sparse" ? FilterKind::Sparse : FilterKind::Auto;
       }},
      {"storage",
       [&](const JsonReader& v) {
         const std::string word = v.word("storage", {"float", "double", "int16"});
         own.storage = word == "double" ? Storage::Double : word == "int16" ? Storage::Int16 : Storage::Float;
         if (own.storage == Storage::Int16 && own.filter == FilterKind::Sparse)
           v.refuse("int16 with the filter \"sparse\"", "float or double there; int16 is for \"dense\"");
       }},
      {"filter_external_forces", [&](const JsonReader& v) { own.filter_external_forces = v.boolean(); }},
      {"corrector",
       [&](const JsonReader& v) {
         const std::string word = v.word("corrector", {"inertia", "paper", "off"});
         own.corrector = word == "inertia" ? Corrector::Inertia : word == "paper" ? Corrector::Paper : Corrector::Off;
       }},
      {"refinement_iterations", [&](const JsonReader& v) { own.refinement_iterations = v.integer(0, 1000); }},
      {"tolerance",
       [&](const JsonReader& v) { own.tolerance = v.number(at_least(0, "of a distance limit's length")); }},
      {"time_budget", [&](const JsonReader& v) { own.time_budget = v.number(above(0, "s")); }},
  };
}

int read_levels(const JsonReader& at) {
  if (at.value().type == JsonValue::Type::Text) return at.word("choice", {"auto", "off"}) == "auto" ? kAutoLevels : 0;
  return at.integer(1, kMaxLevels);
}

}  // namespace

SolverSpec read_solver(const JsonReader& at) {
  constexpr int most_passes = 100000;
  SolverSpec solver;
  solver.type = at.at("type").word("solver", {"pbd", "desbrun"});
  std::vector<JsonReader::Field> fields{
      {"type", [](const JsonReader&) {}, true},
      {"dt", [&](const JsonReader& v) { solver.dt = v.number(above(0, "s")); }},
      {"substeps", [&](const JsonReader& v) { solver.substeps = v.integer(1, most_passes); }},
      {"iterations", [&](const JsonReader& v) { solver.iterations = v.integer(1, most_passes); }},
      {"precision",
       [&](const JsonReader& v) {
         solver.precision = v.word("precision", {"float", "double"}) == "double" ? Precision::Double : Precision::Float;
       }},
  };
  if (solver.type == "pbd") {
    fields.push_back({"corrector", [&](const JsonReader& v) {
                        solver.keeps_momenta = v.word("corrector", {"inertia", "off"}) == "inertia";
                      }});
    fields.push_back({"levels", [&](const JsonReader& v) { solver.levels = read_levels(v); }});
    fields.push_back(
        {"levels_interval", [&](const JsonReader& v) { solver.levels_interval = v.integer(1, kMaxLevelsInterval); }});
    fields.push_back({"stiffness_basis", [&](const JsonReader& v) {
                        solver.stiffness_of_step = v.word("choice", {"projections", "step"}) == "step";
                      }});
  }
  if (solver.type == "desbrun") {
    solver.substeps = 1, solver.iterations = 10;
    if (at.has("stiffness"))  // its name in older scenes
      at.at("stiffness").refuse("'stiffness', which is a constraint's, from 0 to 1", "'spring_constant' (N/m)");
    for (JsonReader::Field& field : desbrun_fields(solver)) fields.push_back(std::move(field));
  }
  at.object(fields);
  return solver;
}

}  // namespace malha
