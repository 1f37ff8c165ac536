#include "tools/study/accuracy_sections.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "host/base/shown.h"
#include "tools/bench/output.h"
#include "tools/study/accuracy_points.h"

namespace malha::study {

namespace {

using bench::formatted;

constexpr double kDrawn = 10;  // m: what is farther off is off the chart

/// Colour and mark of a series: malha's methods by family, the integrators that are not malha's in greys.
std::string style(const std::string& series) {
  struct Look {
    const char *start, *style;
  };
  static constexpr Look looks[] = {
      {"PBD", "lc rgb '#d62728' pt 5"},
      {"XPBD, substeps, float", "lc rgb '#1f4e9c' pt 7"},
      {"XPBD, substeps, double", "lc rgb '#1f4e9c' pt 6 dt 2"},
      {"XPBD, iterations", "lc rgb '#74a9cf' pt 9"},
      {"Desbrun, substeps", "lc rgb '#1b7837' pt 13"},
      {"Desbrun, gravity", "lc rgb '#1b7837' pt 12 dt 2"},
      {"Desbrun, refine, 1 ", "lc rgb '#7fbf3f' pt 11"},
      {"Desbrun, refine, 16 ", "lc rgb '#7fbf3f' pt 10 dt 2"},
      {"Desbrun", "lc rgb '#e69f00' pt 8 dt 2"},
      {"symplectic", "lc rgb '#999999' pt 4"},
      {"RK4", "lc rgb '#000000' pt 3"},
      {"backward", "lc rgb '#8856a7' pt 2"},
  };
  for (const Look& look : looks)
    if (series.starts_with(look.start)) return std::string("with linespoints lw 2 ps 0.9 ") + look.style;
  return "with linespoints lw 1";
}

Chart chart(const AccuracyCase& of, const Truth& truth, const std::vector<Point>& points, double Point::*cost,
            const std::string& name, const std::string& axis) {
  Chart chart{of.name + "_" + name, "", {}};
  double least = 1e300, most = 0;
  for (const Point& point : points) {
    least = std::min(least, point.*cost), most = std::max(most, point.*cost);
    if (!(point.error > 0) || point.error > kDrawn) continue;
    const auto known = std::find_if(chart.series.begin(), chart.series.end(),
                                    [&](const bench::Series& series) { return series.title == point.series; });
    const auto line = formatted("%.9g %.9g\n", point.*cost, point.error);
    if (known != chart.series.end())
      known->data += line;
    else
      chart.series.push_back({line, style(point.series), point.series});
  }
  if (truth.off[0] > 0)
    chart.series.push_back({formatted("%.9g %.9g\n%.9g %.9g\n", least / 2, truth.off[0], most * 2, truth.off[0]),
                            "with lines lw 1 dt 3 lc rgb '#444444'", "the reference, step halved"});
  chart.settings = "set logscale xy\nset format '%g'\nset format y '10^{%T}'\nset xlabel '" + axis +
                   "'\nset ylabel 'RMS distance to the true motion (m)'\nset title '" + of.title +
                   formatted(": after %g s'\n", of.times[0]) +
                   formatted("set xrange [%g:%g]\n", least / 1.5, most * 1.5);
  return chart;
}

/// "1e-3"
std::string power(int exponent) { return "1e" + std::to_string(exponent); }

std::string truth_sentence(const AccuracyCase& of, const Truth& truth) {
  const std::string frequency = formatted("The largest frequency is %.4g rad/s.", truth.omega);
  if (of.exact) return "The true motion is known in closed form. " + frequency;
  std::string line = formatted(
      "The true motion is that of the same springs by RK4 with a step of %.3g s (omega_max h = "
      "%.2g); with twice that step it is",
      kFrame / of.reference, truth.omega * kFrame / of.reference);
  for (std::size_t k = 0; k < of.times.size(); ++k)
    line += formatted("%s %.1e m away after %g s", k == 0 ? "" : " and", truth.off[k], of.times[k]);
  return line + ". " + frequency;
}

/// A row for each power of ten between the worst and the best.
Table cheapest_table(const std::vector<Point>& points) {
  Table table{{"error at most, m", "cheapest", "settings", "ms per s", "cheapest of malha's", "settings", "ms per s",
               "fewest sweeps of malha's", "settings", "sweeps per s"},
              {}};
  for (int exponent = 0; exponent >= -12; --exponent) {
    const double error = std::pow(10, exponent);
    const Point* any = cheapest(points, error, &Point::ms, false);
    const Point* ours = cheapest(points, error, &Point::ms, true);
    const Point* least = cheapest(points, error, &Point::sweeps, true);
    if (any == nullptr) break;
    std::vector<std::string> row{power(exponent), any->series, any->settings, formatted("%.3g", any->ms)};
    for (const auto& [point, cost] : {std::pair(ours, &Point::ms), std::pair(least, &Point::sweeps)}) {
      row.push_back(point ? point->series : "none");
      row.push_back(point ? point->settings : "");
      row.push_back(point ? formatted("%.3g", point->*cost) : "");
    }
    table.rows.push_back(row);
  }
  return table;
}

/// "1e-2 m: A (2x1, 0.3 ms a simulated second); ...", each with the least error for which it is the cheapest.
std::string cheapest_sentence(const std::vector<Point>& points, double Point::*cost, const char* unit, bool ours) {
  std::string line;
  const auto best = [&](int exponent) { return cheapest(points, std::pow(10, exponent), cost, ours); };
  for (int exponent = -1; exponent >= -12 && best(exponent) != nullptr; --exponent) {
    const Point& point = *best(exponent);
    if (best(exponent - 1) == &point) continue;
    line += (line.empty() ? "" : "; ") + power(exponent) + " m: " + point.series + " (" + point.settings +
            formatted(", %.3g %s)", point.*cost, unit);
  }
  return line.empty() ? "none reaches 1e-1 m" : line;
}

std::string orders_sentence(const std::vector<Point>& points) {
  std::string line;
  std::set<std::string> seen;
  for (const Point& point : points) {
    if (!seen.insert(point.series).second) continue;
    if (const double order = order_of(points, point.series); order > 0)
      line += (line.empty() ? "" : "; ") + point.series + formatted(" %.1f", order);
  }
  return line.empty() ? "" : "The error falls with the sweeps to the power of: " + line + ".";
}

std::string best_sentence(const std::vector<Point>& points) {
  std::string line;
  std::set<std::string> seen;
  for (const Point& point : points) {
    if (!seen.insert(point.series).second) continue;
    const Point* best = nullptr;
    for (const Point& other : points)
      if (other.series == point.series && (best == nullptr || other.error < best->error)) best = &other;
    line += (line.empty() ? "" : "; ") + point.series + formatted(" %.1e m", best->error) + " (" + best->settings +
            formatted(", energy %+.2g %%)", 100 * best->energy);
  }
  return "The best of each: " + line + ".";
}

std::string diverged_sentence(const AccuracyCase& of, const Json& rows) {
  std::string line;
  for (const Json& row : rows)
    if (row["case"] == of.name && row["time_s"] == of.times.back() && row["status"] == "diverged")
      line += (line.empty() ? "" : "; ") + row["series"].get<std::string>() + " " + row["settings"].get<std::string>();
  return line.empty() ? "" : "Diverged: " + line + ".";
}

}  // namespace

std::vector<Section> accuracy_sections(const AccuracyCase& of, const Truth& truth, const Json& rows) {
  const double first = of.times[0];
  const std::vector<Point> points = points_at(rows, of.name, first);
  Section cost{of.title + ": what accuracy costs", {truth_sentence(of, truth)}, {}, cheapest_table(points)};
  cost.chart = chart(of, truth, points, &Point::ms, "cost", "ms per simulated second, one thread");
  cost.sentences.push_back(formatted("Cheapest here after %g s, of all: ", first) +
                           cheapest_sentence(points, &Point::ms, "ms a simulated second", false) + ".");
  cost.sentences.push_back("Of malha's methods: " + cheapest_sentence(points, &Point::ms, "ms", true) + ".");
  if (of.times.size() > 1)
    cost.sentences.push_back(formatted("After %g s, of malha's: ", of.times.back()) +
                             cheapest_sentence(points_at(rows, of.name, of.times.back()), &Point::ms, "ms", true) +
                             ".");
  for (const std::string& line : {best_sentence(points), diverged_sentence(of, rows)})
    if (!line.empty()) cost.sentences.push_back(line);

  Section work{of.title + ": what accuracy takes in sweeps",
               {"Independent of the machine: a sweep is one projection of every constraint, one solve with Desbrun's "
                "filter, one evaluation of all forces, or one factorisation of Newton's.",
                "Fewest of malha's: " + cheapest_sentence(points, &Point::sweeps, "sweeps a second", true) + "."},
               {},
               {}};
  if (const std::string orders = orders_sentence(points); !orders.empty()) work.sentences.push_back(orders);
  work.chart = chart(of, truth, points, &Point::sweeps, "work", "sweeps, solves or evaluations per simulated second");
  return {cost, work};
}

}  // namespace malha::study
