// SPDX-License-Identifier: Apache-2.0
#include "tools/study/scaling/sections.h"

#include <algorithm>

#include "malha/text.h"
#include "tools/bench/output.h"
#include "tools/study/cloth_methods.h"
#include "tools/study/scaling/rows.h"

namespace malha::study {

namespace {

using bench::formatted;

/// The colour of a line: a shade of the method's, darker for more particles.
const char* colour(const Json& row, std::size_t nth) {
  static constexpr const char* shades[][5] = {{"#9ecae1", "#6baed6", "#3182bd", "#08519c", "#08306b"},
                                              {"#a1d99b", "#74c476", "#31a354", "#006d2c", "#00441b"},
                                              {"#fdae6b", "#fd8d3c", "#d94801", "#a63603", "#7f2704"}};
  for (std::size_t k = 0; k < std::min(cloth_methods().size(), std::size(shades)); ++k)
    if (row["method"] == cloth_methods()[k].name) return shades[k][std::min<std::size_t>(nth, 4)];
  return "#000000";
}

Chart chart(const std::vector<std::vector<Json>>& all, const std::string& name, const std::string& title,
            const std::string& axis, const std::string& of, bool ideal) {
  Chart chart{name, ""};
  int most = 1;
  std::size_t nth = 0;
  std::string method;
  for (const auto& group : all) {
    nth = method == method_of(group[0]) ? nth + 1 : 0, method = method_of(group[0]);
    std::string points;
    for (const Json& row : group) {
      points += formatted("%d %.9g %.9g %.9g\n", row["threads"].get<int>(), number(row, of),
                          number(row, "least_times_as_fast"), number(row, "most_times_as_fast"));
      most = std::max(most, row["threads"].get<int>());
    }
    chart.series.push_back({points,
                            std::string("with yerrorlines lw 2 ps 0.9 pt 7 lc rgb '") + colour(group[0], nth) + "'",
                            method_of(group[0]) + ", " + count_of(group[0])});
  }
  if (ideal)
    chart.series.push_back(
        {formatted("1 1\n%d %d\n", most, most), "with lines lw 1 dt 2 lc rgb '#000000'", "as many times"});
  std::string tics;
  for (int t = 1; t < most; t *= 2) tics += formatted("%d, ", t);
  chart.settings =
      "set logscale x\nset xtics (" + tics + std::to_string(most) + formatted(")\nset xrange [0.9:%g]\n", most * 1.1) +
      (ideal && most > 8 ? "set logscale y\nset yrange [0.5:*]\n" : bench::label_series_ends(chart.series, false)) +
      "set xlabel 'threads'\nset ylabel '" + axis + "'\nset title '" + title + "'\n";
  return chart;
}

/// The serial fraction: "0.12" or "not fitted".
std::string share_of(const Json& row) {
  return row["serial_share"].is_null() ? "not fitted" : formatted("%.2f", number(row, "serial_share"));
}

/// Descriptions of each line's row on the most threads: "1.8 (PBD, 10 substeps, 289), ...".
template <class Said>
std::string on_most_threads(const std::vector<std::vector<Json>>& all, const Said& summary) {
  return listed(all, [&](const std::vector<Json>& group) {
    const Json& last = group.back();
    return summary(last) + " (" + method_of(last) + ", " + count_of(last) + ")";
  });
}
std::string on_most_threads(const std::vector<std::vector<Json>>& all, const std::string& of, const char* format,
                            double times = 1) {
  return on_most_threads(all, [&](const Json& row) { return formatted(format, times * number(row, of)); });
}

Section strong(const Json& rows, const std::string& pinning) {
  const auto all = scaling_groups(rows, "strong");
  Section section{"Strong scaling: the same cloth on more threads"};
  section.table.columns = {"method",
                           "particles",
                           "threads",
                           "ms a step",
                           "times as fast",
                           "by the least step",
                           "efficiency",
                           "serial fraction",
                           "GB/s that must move",
                           "triad, GB/s",
                           "imbalance by patches",
                           "set-up, s"};
  int most = 1;
  bool same = true;
  for (const auto& group : all)
    for (const Json& row : group) {
      most = std::max(most, row["threads"].get<int>());
      same = same && row["hash"] == group[0]["hash"];
      section.table.rows.push_back(
          {method_of(row), count_of(row), row["threads"].dump(), formatted("%.4g", number(row, "step_ms")),
           formatted("%.2f", number(row, "times_as_fast")), formatted("%.2f", number(row, "undisturbed_times_as_fast")),
           formatted("%.0f %%", 100 * number(row, "efficiency")), share_of(row),
           formatted("%.1f", number(row, "gb_per_s")), formatted("%.1f", number(row, "triad_gb_per_s")),
           row["imbalance_by_patches"].is_null() ? "" : formatted("%.2f", number(row, "imbalance_by_patches")),
           formatted("%.3g", number(row, "setup_s"))});
    }
  double load = 0;
  for (const auto& group : all) load = std::max(load, number(group[0], "load_average"));
  section.sentences = {
      pinning + formatted("; the load average before a case was at most %.1f, including this study's threads.", load) +
          (load > 1.2 * most ? " Other programs used the cores too, and affect the medians." : ""),
      formatted("Times as fast on %d threads as on one, medians of the turns: ", most) +
          on_most_threads(all, "times_as_fast", "%.2f") + "." + scaling_left_out(rows, "strong"),
      "Times as fast by the shortest step of each, which other programs disturb least: " +
          on_most_threads(all, "undisturbed_times_as_fast", "%.2f") + ".",
      formatted(
          "The serial fraction, fitted to all numbers of threads (if there are two, computed from the second): ") +
          on_most_threads(all, share_of) +
          ". Not fitted: the best fraction is not between 0 and 1, because speed-ups are larger than the number of "
          "threads, "
          "or more threads are slower than one.",
      std::string("The states after the same steps are ") + (same ? "the same bits" : "NOT the same bits") +
          " on every number of threads."};
  section.chart =
      chart(all, "strong", "Strong scaling: the same cloth on more threads (bars: least and most of the turns)",
            "times as fast as one thread", "times_as_fast", true);
  return section;
}

Section weak(const Json& rows) {
  const auto all = scaling_groups(rows, "weak");
  Section section{"Weak scaling: a cloth that grows with the threads"};
  section.table.columns = {"method", "particles", "threads", "ms a step", "efficiency"};
  for (const auto& group : all)
    for (const Json& row : group)
      section.table.rows.push_back({method_of(row), count_of(row), row["threads"].dump(),
                                    formatted("%.4g", number(row, "step_ms")),
                                    formatted("%.0f %%", 100 * number(row, "efficiency"))});
  section.sentences = {
      "Efficiency is the time of one thread over that of all threads, with as many particles per thread: " +
      on_most_threads(all, "efficiency", "%.0f %%", 100) + "." + scaling_left_out(rows, "weak") +
      " The work of a sparse factor grows a little faster than its particles, which lowers its efficiency here."};
  section.chart =
      chart(all, "weak",
            "Weak scaling: as many particles a thread (in names: of one thread; bars: least and most of the turns)",
            "efficiency", "efficiency", false);
  return section;
}

}  // namespace

std::vector<Section> scaling_sections(const Json& rows, const std::string& pinning) {
  return {strong(rows, pinning), scaling_passes(rows), scaling_bandwidth(rows), scaling_launches(rows), weak(rows)};
}

}  // namespace malha::study
