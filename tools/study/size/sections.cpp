// SPDX-License-Identifier: Apache-2.0
#include "tools/study/size/sections.h"

#include <algorithm>
#include <functional>

#include "tools/bench/output.h"
#include "tools/study/cloth_methods.h"

namespace malha::study {

namespace {

using bench::formatted;
using Number = std::function<double(const Json& row)>;  // a value per particle

double number(const Json& row, const char* key) { return row.at(key).get<double>(); }
double particles(const Json& row) { return number(row, "particles"); }
Number of_particle(const char* key, double scale) {
  return [=](const Json& row) { return number(row, key) / particles(row) * scale; };
}

/// The rows of a method that were run, by increasing size.
std::vector<Json> rows_of(const Json& rows, const ClothMethod& method) {
  std::vector<Json> found;
  for (const Json& row : rows)
    if (row["method"] == method.name && row["left_out"].is_null()) found.push_back(row);
  return found;
}

Chart chart(const Json& rows, const std::string& name, const std::string& title, const std::string& axis,
            const Number& row_value, const std::vector<Number>& bars = {}) {
  Chart chart{name, "", {}};
  for (const ClothMethod& method : cloth_methods()) {
    std::string points;
    for (const Json& row : rows_of(rows, method)) {
      points += formatted("%.9g %.9g", particles(row), row_value(row));
      for (const Number& end : bars) points += formatted(" %.9g", end(row));
      points += "\n";
    }
    const std::string style = std::string(bars.empty() ? "with linespoints " : "with yerrorlines ") + method.style();
    if (!points.empty()) chart.series.push_back({points, style, method.name});
  }
  chart.settings =
      "set logscale xy\nset xrange [200:6e6]\nset format x '10^{%T}'\nset format y '%g'\nset xlabel 'particles'\nset "
      "ylabel '" +
      axis + "'\nset title '" + title + "'\n" + bench::label_series_ends(chart.series);
  return chart;
}

/// The first, the smallest and the last value of a method: "PBD, 10 substeps: 80 at 289, 30 at 1,000,000".
std::string range(const Json& rows, const ClothMethod& method, const char* format, const Number& row_value) {
  const std::vector<Json> found = rows_of(rows, method);
  if (found.empty()) return "";
  const Json& least = *std::min_element(found.begin(), found.end(),
                                        [&](const Json& a, const Json& b) { return row_value(a) < row_value(b); });
  std::string line = method.name + ": ";
  std::vector<Json> summary{found.front()};
  if (least != found.front() && least != found.back()) summary.push_back(least);
  if (found.size() > 1) summary.push_back(found.back());
  for (std::size_t k = 0; k < summary.size(); ++k)
    line += (k == 0 ? "" : ", ") + formatted(format, row_value(summary[k])) + " at " +
            with_commas(static_cast<long long>(particles(summary[k])));
  return line;
}

std::string ranges(const Json& rows, const char* format, const Number& row_value) {
  std::string line;
  for (const ClothMethod& method : cloth_methods())
    if (const std::string one = range(rows, method, format, row_value); !one.empty())
      line += (line.empty() ? "" : "; ") + one;
  return line;
}

std::string left_out(const Json& rows) {
  std::string line;
  for (const Json& row : rows)
    if (!row["left_out"].is_null())
      line += " " + row["method"].get<std::string>() + " with " + with_commas(row["particles"].get<long long>()) +
              " particles is left out: " + row["left_out"].get<std::string>() + ".";
  return line;
}

/// Bytes per particle by owner, for the largest body that was run.
std::string owners(const Json& rows, const ClothMethod& method) {
  const std::vector<Json> found = rows_of(rows, method);
  if (found.empty()) return "";
  std::string line;
  for (const auto& [key, value] : found.back().items())
    if (key.starts_with("bytes_by_owner_"))
      line += (line.empty() ? "" : ", ") + key.substr(15) +
              formatted(" %.3g", value.get<double>() / particles(found.back()));
  return method.name + " at " + with_commas(static_cast<long long>(particles(found.back()))) + ": " + line;
}

/// Growth of the process with the largest body of each method, for comparison with the sums by owner.
std::string process_growth(const Json& rows) {
  std::string line;
  for (const ClothMethod& method : cloth_methods()) {
    const std::vector<Json> found = rows_of(rows, method);
    if (found.empty() || found.back()["held_bytes"].is_null() || found.back()["peak_bytes"].is_null()) continue;
    const Json& row = found.back();
    line += (line.empty() ? "" : "; ") + method.name +
            formatted(" by %.4g, and by %.4g at most while it was set up", number(row, "held_bytes") / particles(row),
                      number(row, "peak_bytes") / particles(row));
  }
  return line.empty() ? "" : "With the most particles the process grew, bytes a particle: " + line + ".";
}

std::string or_dash(const Json& row, const char* key) {
  return row[key].is_null() ? "-" : formatted("%.4g", number(row, key) / particles(row));
}

}  // namespace

std::vector<Section> size_sections(const Json& rows) {
  const Number time = of_particle("step_s", 1e9), bytes = of_particle("bytes", 1), setup = of_particle("setup_s", 1e6);

  Section cost{"Time per particle", {}, {}, {}};
  cost.sentences = {"ns a particle and step of 1/60 s on one thread: " + ranges(rows, "%.3g", time) + "." +
                    left_out(rows)};
  cost.chart =
      chart(rows, "time", "A hanging cloth: time a particle, one thread (bars: least and most of five turns)",
            "ns a particle and step", time, {of_particle("step_least_s", 1e9), of_particle("step_most_s", 1e9)});
  cost.table.columns = {"method", "particles",     "ms a step",       "least",
                        "most",   "ns a particle", "ns a projection", "steps of 1/60 s in real time"};

  Section memory{"Memory per particle", {}, {}, {}};
  memory.sentences = {"Bytes a particle, summed over all owners: " + ranges(rows, "%.4g", bytes) + "."};
  if (const std::string line = process_growth(rows); !line.empty()) memory.sentences.push_back(line);
  for (const ClothMethod& method : cloth_methods())
    if (const std::string line = owners(rows, method); !line.empty()) memory.sentences.push_back(line + ".");
  memory.chart = chart(rows, "memory", "A hanging cloth: memory a particle", "bytes a particle", bytes);
  memory.table.columns = {"method",           "particles",           "MiB",
                          "bytes a particle", "the process grew by", "at most, in set-up"};

  Section start{"Set-up time per particle", {}, {}, {}};
  start.sentences = {"Microseconds a particle on one thread: " + ranges(rows, "%.3g", setup) + "."};
  start.chart =
      chart(rows, "setup", "A hanging cloth: set-up a particle, one thread", "microseconds a particle", setup);
  start.table.columns = {"method", "particles", "s", "microseconds a particle", "steps that take as long"};

  for (const Json& row : rows) {
    if (!row["left_out"].is_null()) continue;
    const std::string method = row["method"].get<std::string>();
    const std::string count = with_commas(row["particles"].get<long long>());
    const double step = number(row, "step_s"), projections = number(row, "projections_per_step");
    cost.table.rows.push_back(
        {method, count, formatted("%.4g", step * 1e3), formatted("%.4g", number(row, "step_least_s") * 1e3),
         formatted("%.4g", number(row, "step_most_s") * 1e3), formatted("%.3g", time(row)),
         projections > 0 ? formatted("%.3g", step * 1e9 / projections) : "-", formatted("%.3g", 1 / 60.0 / step)});
    memory.table.rows.push_back({method, count, formatted("%.4g", number(row, "bytes") / 1048576),
                                 formatted("%.4g", bytes(row)), or_dash(row, "held_bytes"),
                                 or_dash(row, "peak_bytes")});
    start.table.rows.push_back({method, count, formatted("%.3g", number(row, "setup_s")), formatted("%.3g", setup(row)),
                                formatted("%.3g", number(row, "setup_s") / step)});
  }
  return {cost, memory, start};
}

}  // namespace malha::study
