// SPDX-License-Identifier: Apache-2.0
#include "tools/study/stability/lines.h"

#include <array>
#include <cmath>
#include <set>
#include <stdexcept>

#include "malha/error.h"
#include "tools/bench/output.h"
#include "tools/study/rows.h"
#include "tools/study/stability/map.h"

namespace malha::study {

double Line::at(double x) const {
  for (const auto& [a, b] : points)
    if (a == x) return b;
  throw std::out_of_range(title + " has no " + short_number(x));
}

void Line::add(double x, Cells& from, const std::string& key, const std::function<double()>& run) {
  const Json cell = from(key, [&]() -> Json {
    try {
      return {{"y", run()}};
    } catch (const Diverged&) {
      return {{"y", nullptr}};
    }
  });
  const Json y = cell.is_object() ? cell["y"] : Json();
  points.push_back({x, y.is_null() ? NAN : y.get<double>()}), cells.push_back(cell);
}

Line line_over(Cells& cells, const LineChart& line_chart, const std::string& title, const std::vector<double>& settings,
               double scale, const std::function<double(double)>& run) {
  Line line{title, {}};
  for (const double setting : settings)
    line.add(scale * setting, cells, line_chart.name + ", " + title + bench::formatted(", %g", setting),
             [&] { return run(setting); });
  return line;
}

Section lines_section(const LineChart& line_chart, Json& rows) {
  Section section{line_chart.title, {}, {}, {{line_chart.x}, {}}};
  Chart chart{line_chart.name,
              "set logscale xy\nset format '10^{%T}'\nset xlabel '" + line_chart.x + "'\nset ylabel '" + line_chart.y +
                  "'\nset title '" + line_chart.title + "'\n",
              {}};
  constexpr std::array styles{"lc rgb '#d55e00' pt 5",     "lc rgb '#0072b2' pt 7",  "lc rgb '#009e73' pt 9",
                              "lc rgb '#e69f00' pt 13",    "lc rgb '#cc79a7' pt 11", "lc rgb '#444444' pt 4 dt 2",
                              "lc rgb '#56b4e9' pt 6 dt 2"};
  std::set<double> all;
  for (const Line& line : line_chart.lines) {
    bench::Series series{"", std::string("with linespoints lw 2 ") + styles[chart.series.size() % styles.size()],
                         line.title};
    for (std::size_t k = 0; k < line.points.size(); ++k) {
      const auto& [x, y] = line.points[k];
      rows.push_back({{"map", line_chart.name},
                      {"panel", line.title},
                      {"x_name", line_chart.x},
                      {"x", x},
                      {"y_name", line_chart.y},
                      {"y", y}});
      copy_machine(rows.back(), line.cells[k]);
      all.insert(x);
      if (y > 0) series.data += bench::formatted("%.6g %.6g\n", x, y);
    }
    if (!series.data.empty()) chart.series.push_back(series);
    section.table.columns.push_back(line.title);
  }
  for (const double x : all) {
    std::vector<std::string> row{short_number(x)};
    for (const Line& line : line_chart.lines) {
      row.emplace_back();
      for (const auto& [a, b] : line.points)
        if (a == x) row.back() = std::isfinite(b) ? bench::formatted("%.2g", b) : "not finite";
    }
    section.table.rows.push_back(row);
  }
  chart.settings += bench::label_series_ends(chart.series);
  section.chart = chart;
  return section;
}

}  // namespace malha::study
