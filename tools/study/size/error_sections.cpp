// SPDX-License-Identifier: Apache-2.0
#include "tools/study/size/error_sections.h"

#include <algorithm>
#include <functional>

#include "tools/bench/output.h"
#include "tools/study/cloth_methods.h"

namespace malha::study {

namespace {

using bench::formatted;
using RowValue = std::function<double(const Json& row)>;

double value_of(const Json& row, const char* key) { return row.at(key).get<double>(); }

std::vector<Json> hanging_rows(const Json& rows, const char* measures, const HangingMethod& method,
                               const std::string& mesh) {
  std::vector<Json> found;
  for (const Json& row : rows)
    if (row["measures"] == measures && row["method"] == method.name && row["mesh"] == mesh && row["left_out"].is_null())
      found.push_back(row);
  return found;
}

/// gnuplot's settings of the axis of sizes.
constexpr const char* kClothSides =
    "set xrange [12:1400]\nset xtics (17, 46, 100, 316, 1000)\nset xlabel 'particles a side (irregular meshes: square "
    "root of their number)'\n";
constexpr const char* kStripEdges = "set xrange [20:240]\nset xtics (24, 48, 96, 192)\nset xlabel 'edges along'\n";

/// A chart with a solid line of the grids and a dashed one of irregular meshes, for each method.
Chart hanging_chart(const std::vector<HangingMethod>& methods, const Json& rows, const char* measures, bool settings,
                    const std::string& name, const std::string& title, const std::string& axis,
                    const RowValue& row_value, const char* sizes = kClothSides) {
  Chart chart{name, "", {}};
  for (const HangingMethod& method : methods)
    for (const std::string mesh : {"grid", "irregular"}) {
      std::string points;
      for (const Json& row : hanging_rows(rows, measures, method, mesh))
        points += formatted("%.9g %.9g\n", value_of(row, "side"), row_value(row));
      if (points.empty()) continue;
      const bool grid = mesh == "grid";
      chart.series.push_back({points,
                              std::string("with linespoints ps 0.9 ") + method.line + (grid ? " pt 7" : " pt 6 dt 2"),
                              (settings ? method.title() : method.name) + (grid ? "" : ", irregular")});
    }
  chart.settings = std::string("set logscale xy\nset format y '%g'\n") + sizes + "set ylabel '" + axis +
                   "'\nset title '" + title + "'\n" + bench::label_series_ends(chart.series);
  return chart;
}

/// The values at the first and the last side: "levels 0.0025 at 17, 0.0035 at 316".
std::string hanging_ranges(const std::vector<HangingMethod>& methods, const Json& rows, const char* measures,
                           const std::string& mesh, const char* format, const RowValue& row_value) {
  std::string line;
  for (const HangingMethod& method : methods) {
    const std::vector<Json> found = hanging_rows(rows, measures, method, mesh);
    if (found.empty()) continue;
    line += (line.empty() ? "" : "; ") + method.name + " ";
    for (std::size_t k = 0; k < found.size(); k += std::max<std::size_t>(1, found.size() - 1))
      line += (k == 0 ? "" : ", ") + formatted(format, row_value(found[k])) +
              formatted(" at %g", value_of(found[k], "side"));
  }
  return line;
}

double ns_a_particle(const Json& row) { return value_of(row, "step_ms") * 1e6 / value_of(row, "particles"); }

std::string value_or_dash(const Json& row, const char* key, const char* format) {
  return row.contains(key) ? formatted(format, value_of(row, key)) : "-";
}

}  // namespace

std::vector<Section> size_error_sections(const std::vector<HangingMethod>& methods,
                                         const std::vector<HangingMethod>& bending, const Json& rows) {
  const RowValue strain = [](const Json& row) { return value_of(row, "strain_rms"); };
  const RowValue error = [](const Json& row) { return value_of(row, "error_m"); };

  Section strains{"How much a hanging cloth stretches, at about the same cost", {}, {}, {}};
  strains.sentences = {
      "RMS strain of a cloth of 2 m and 1 kg, pinned at a row, 1 s after its release from the horizontal, by "
      "particles a side: " +
          hanging_ranges(methods, rows, "error", "grid", "%.2g", strain) + ".",
      "Irregular triangles: " + hanging_ranges(methods, rows, "error", "irregular", "%.2g", strain) + ".",
      "ns a particle and step of 1/60 s on one thread, grids: " +
          hanging_ranges(methods, rows, "error", "grid", "%.3g", ns_a_particle) + "."};
  strains.chart = hanging_chart(methods, rows, "error", true, "strain",
                                "A hanging cloth after 1 s: its strain, at about the same cost", "RMS strain", strain);
  strains.table.columns = {"method",         "mesh",       "a side",         "ns a particle",
                           "levels",         "RMS strain", "largest strain", "m off after 0.5 s",
                           "m off after 1 s"};

  Section errors{"How far off a hanging cloth is, at about the same cost", {}, {}, {}};
  errors.sentences = {
      "The reference is an inextensible cloth: its rows move as the joints of a chain (SHAKE, in double, 500 links). "
      "RMS distance to it after 1 s, m: " +
          hanging_ranges(methods, rows, "error", "grid", "%.2g", error) + ".",
      "Irregular triangles: " + hanging_ranges(methods, rows, "error", "irregular", "%.2g", error) + "."};
  errors.chart =
      hanging_chart(methods, rows, "error", true, "error",
                    "A hanging cloth after 1 s: distance to one that does not stretch, at about the same cost",
                    "RMS distance to the truth, m", error);

  Section work{"What a strain of 1 % costs", {}, {}, {}};
  work.sentences = {
      "Time of the fewest substeps (Desbrun: refinements of one substep) that leave an RMS strain of 1 % after 1 s, in "
      "ns a particle and step: " +
          hanging_ranges(methods, rows, "work", "grid", "%.3g", ns_a_particle) + ".",
      "Irregular triangles: " + hanging_ranges(methods, rows, "work", "irregular", "%.3g", ns_a_particle) + "."};
  work.chart =
      hanging_chart(methods, rows, "work", false, "work", "A hanging cloth after 1 s: what an RMS strain of 1 % costs",
                    "ns a particle and step", ns_a_particle);
  work.table.columns = {"method",        "mesh",       "a side",         "substeps or refinements", "levels",
                        "ns a particle", "RMS strain", "largest strain", "m off after 1 s"};

  Section strips{"How far off a clamped strip is that bends under its weight", {}, {}, {}};
  strips.sentences = {
      "The cantilever of the study accuracy, a heavy elastica of Gamma 10, after 5 s in air. PBD projects or filters "
      "its bending, with levels where they help. RMS distance to the elastica, m, by edges along: " +
          hanging_ranges(bending, rows, "bending", "grid", "%.2g", error) + ".",
      "ns a particle and step of 1/60 s on one thread: " +
          hanging_ranges(bending, rows, "bending", "grid", "%.3g", ns_a_particle) + "."};
  strips.chart = hanging_chart(bending, rows, "bending", true, "bending",
                               "A clamped strip at rest under its weight: distance to the heavy elastica",
                               "RMS distance to the truth, m", error, kStripEdges);
  strips.table.columns = {"method",     "mesh",           "edges along",       "ns a particle",  "levels",
                          "RMS strain", "largest strain", "m off after 2.5 s", "m off after 5 s"};

  for (const Json& row : rows) {
    const bool of_work = row["measures"] == "work";
    std::vector<std::string> line{row["method"].get<std::string>(), row["mesh"].get<std::string>(),
                                  std::to_string(row["side"].get<int>())};
    if (!row["left_out"].is_null()) {
      line.push_back(row["left_out"].get<std::string>());
      line.resize(9, "-");
    } else {
      if (of_work) line.push_back(value_or_dash(row, "count", "%g"));
      if (!of_work) line.push_back(formatted("%.3g", ns_a_particle(row)));
      line.push_back(value_or_dash(row, "levels", "%g"));
      if (of_work) line.push_back(formatted("%.3g", ns_a_particle(row)));
      for (const char* key : {"strain_rms", "strain_max"}) line.push_back(value_or_dash(row, key, "%.3g"));
      if (!of_work) line.push_back(value_or_dash(row, "error_half_m", "%.3g"));
      line.push_back(value_or_dash(row, "error_m", "%.3g"));
    }
    (of_work ? work : row["measures"] == "bending" ? strips : strains).table.rows.push_back(line);
  }
  return {strains, errors, work, strips};
}

}  // namespace malha::study
