// SPDX-License-Identifier: Apache-2.0
#include "tools/study/accuracy/sections.h"

#include <algorithm>

#include "tools/bench/output.h"
#include "tools/study/accuracy/words.h"

namespace malha::study {

namespace {

using bench::formatted;

constexpr double kMostDrawnError = 10;  // m; larger errors are not drawn

/// Colour and mark of a series: malha's methods by family, other integrators mostly in grey and black.
std::string style(const std::string& series) {
  struct MethodStyle {
    const char *start, *style;
  };
  static constexpr MethodStyle styles[] = {
      {"PBD, iterations, float", "lc rgb '#d55e00' pt 5"},
      {"PBD, iterations, double", "lc rgb '#d55e00' pt 4 ps 1.6 dt 2"},
      {"XPBD, substeps, float", "lc rgb '#0072b2' pt 7"},
      {"XPBD, substeps, double", "lc rgb '#0072b2' pt 6 dt 2"},
      {"XPBD, substeps and levels, float", "lc rgb '#cc79a7' pt 7"},
      {"XPBD, substeps, filtered", "lc rgb '#e69f00' pt 7"},
      {"XPBD, substeps and levels, filtered", "lc rgb '#882255' pt 5"},
      {"XPBD, iterations", "lc rgb '#56b4e9' pt 9"},
      {"Desbrun, substeps", "lc rgb '#009e73' pt 13"},
      {"Desbrun, gravity", "lc rgb '#000000' pt 12 dt 2"},
      {"Desbrun, refine, 1 ", "lc rgb '#8fbc5a' pt 11"},
      {"Desbrun, refine, 16 ", "lc rgb '#8fbc5a' pt 10 dt 2"},
      {"Desbrun, corrector inertia", "lc rgb '#0072b2' pt 6 ps 1.6"},
      {"Desbrun, corrector paper", "lc rgb '#d55e00' pt 5"},
      {"Desbrun, corrector off", "lc rgb '#555555' pt 4"},
      {"Desbrun, dense, float", "lc rgb '#56b4e9' pt 7"},
      {"Desbrun, dense, double", "lc rgb '#cc79a7' pt 6 ps 1.6"},
      {"Desbrun, dense, int16", "lc rgb '#e69f00' pt 9"},
      {"Desbrun, sparse, float", "lc rgb '#8fbc5a' pt 11"},
      {"explicit", "lc rgb '#e69f00' pt 1"},
      {"symplectic", "lc rgb '#555555' pt 4"},
      {"RK4", "lc rgb '#000000' pt 3"},
      {"backward", "lc rgb '#661100' pt 2"},
  };
  std::string found;
  for (const MethodStyle& entry : styles)
    if (series.starts_with(entry.start)) found = entry.style;
  return "with linespoints lw 2 " + found;
}

/// The chart of error over cost at the case's time number `time`.
Chart chart(const AccuracyCase& test_case, const Truth& truth, std::size_t time, const Points& points,
            double Point::*cost, const std::string& name, const std::string& axis) {
  Chart chart{test_case.name + "_" + name, ""};
  double least = 1e300, most = 0;
  for (const Point& point : points) {
    if (!(point.error > 0) || point.error > kMostDrawnError) continue;
    least = std::min(least, point.*cost), most = std::max(most, point.*cost);
    if (chart.series.empty() || chart.series.back().title != point.series)
      chart.series.push_back({"", style(point.series), point.series});
    chart.series.back().data += formatted("%.9g %.9g\n", point.*cost, point.error);
  }
  const double uncertainty = truth.uncertainty[time];
  if (uncertainty > 0 && name != "filters")
    chart.series.push_back({formatted("%.9g %.9g\n%.9g %.9g\n", least / 1.4, uncertainty, most * 1.4, uncertainty),
                            "with lines lw 1 dt 3 lc rgb '#444444'",
                            test_case.exact ? "equilibrium of the springs" : "how well the true motion is known"});
  chart.settings = "set logscale xy\nset format x '%g'\nset format y '10^{%T}'\nset xlabel '" + axis +
                   "'\nset ylabel 'RMS distance to the true " + (test_case.at_rest ? "equilibrium" : "motion") +
                   " (m)'\nset title '" + test_case.title + formatted(": after %g s'\n", test_case.times[time]) +
                   formatted("set xrange [%g:%g]\n", least / 1.5, most * 1.5);
  return chart;
}

std::string milliseconds(const Json& rows) {
  const bool on_device =
      std::any_of(rows.begin(), rows.end(), [](const Json& row) { return row.value("backend", "") == "cuda"; });
  return on_device ? "ms per simulated second: malha on the device, by the clock; others on one thread"
                   : "ms of processor time per simulated second, one thread";
}

Section cost_section(const AccuracyCase& test_case, const Truth& truth, const Points& points, const Points& last,
                     const std::string& axis) {
  Section cost{test_case.title + ": what accuracy costs",
               {test_case.what, truth_sentence(test_case, truth)},
               {},
               cheapest_table(points, truth.uncertainty[0])};
  cost.chart = chart(test_case, truth, 0, points, &Point::ms, "cost", axis);
  cost.sentences.push_back(
      formatted("Cheapest of all methods after %g s (ms a simulated second): ", test_case.times[0]) +
      cheapest_list(points, truth.uncertainty[0], &Point::ms, "ms", false) + ".");
  cost.sentences.push_back(
      "Of malha's methods: " + cheapest_list(points, truth.uncertainty[0], &Point::ms, "ms", true) + ".");
  const double uncertainty = 3 * truth.uncertainty.back();  // smaller errors are coincidence
  if (test_case.times.size() > 1 && uncertainty < 0.1)
    cost.sentences.push_back(formatted("After %g s, of malha's: ", test_case.times.back()) +
                             cheapest_list(last, uncertainty, &Point::ms, "ms", true) + ".");
  cost.sentences.push_back(best_sentence(points));
  if (const std::string line = float_sentence(points); !line.empty()) cost.sentences.push_back(line);
  return cost;
}

Section late_section(const AccuracyCase& test_case, const Truth& truth, const Points& last, const std::string& axis) {
  const double uncertainty = truth.uncertainty.back();
  Section late{
      test_case.title + formatted(": what accuracy costs after %g s", test_case.times.back()),
      {"Cheapest of all (ms a simulated second): " + cheapest_list(last, uncertainty, &Point::ms, "ms", false) + ".",
       "Of malha's methods: " + cheapest_list(last, uncertainty, &Point::ms, "ms", true) + ".", best_sentence(last)},
      {},
      cheapest_table(last, uncertainty)};
  late.chart = chart(test_case, truth, test_case.times.size() - 1, last, &Point::ms, "late", axis);
  return late;
}

Section work_section(const AccuracyCase& test_case, const Truth& truth, const Points& points, const Json& rows) {
  Section work{
      test_case.title + ": what accuracy takes in sweeps",
      {"Independent of the machine: a sweep is one projection of every constraint, one solve with Desbrun's filter, "
       "one evaluation of all forces, or one factorisation of Newton's method. PBD has stiffness 1, whatever the "
       "springs "
       "have.",
       "Fewest sweeps of malha's methods: " +
           cheapest_list(points, truth.uncertainty[0], &Point::sweeps, "sweeps a second", true) + "."},
      {},
      runs_table(test_case, rows)};
  for (const std::string& line :
       {orders_sentence(points), growth_sentence(points, test_case.times[0]), diverged_sentence(test_case, rows)})
    if (!line.empty()) work.sentences.push_back(line);
  work.chart =
      chart(test_case, truth, 0, points, &Point::sweeps, "work", "sweeps, solves or evaluations per simulated second");
  return work;
}

}  // namespace

std::vector<Section> accuracy_sections(const AccuracyCase& test_case, const Truth& truth, const Json& rows) {
  const bool is_free = !test_case.at_rest && test_case.scene.bodies[0].pins.empty();
  // The series that variants are compared with. On free bodies it is a variant itself, that with the corrector by
  // inertia.
  const std::string base = is_free ? "" : "Desbrun, substeps";
  const auto at = [&](double time, bool variants) {
    Points points = points_at(rows, test_case.name, time);
    std::erase_if(points, [&](const Point& p) { return variants ? !p.variant && p.series != base : p.variant; });
    return points;
  };
  const Points points = at(test_case.times[0], false), last = at(test_case.times.back(), false);
  const std::string axis = milliseconds(rows);
  std::vector<Section> sections{cost_section(test_case, truth, points, last, axis),
                                work_section(test_case, truth, points, rows)};
  if (is_free) sections[0].sentences.push_back(momenta_sentence(last, test_case.times.back()));
  if (test_case.times.size() > 1 && truth.uncertainty.back() <= kChaotic)
    sections.push_back(late_section(test_case, truth, last, axis));
  if (const Points variants = at(test_case.times[0], true); variants.size() > 0 && variants.back().variant) {
    Section filters{test_case.title + ": variants of Desbrun's filter",
                    {"Unless their names say otherwise, they are sparse, in double, and with the corrector by inertia "
                     "on free bodies.",
                     best_sentence(variants)},
                    {},
                    cheapest_table(variants, truth.uncertainty[0])};
    filters.sentences.push_back("Cheapest: " + cheapest_list(variants, truth.uncertainty[0], &Point::ms, "ms", true) +
                                ".");
    if (is_free)
      filters.sentences.push_back(momenta_sentence(at(test_case.times.back(), true), test_case.times.back()));
    filters.chart = chart(test_case, truth, 0, variants, &Point::ms, "filters", axis);
    sections.push_back(filters);
  }
  return sections;
}

}  // namespace malha::study
