#include "tools/study/scaling_sections.h"

#include <algorithm>

#include "host/base/shown.h"
#include "tools/bench/output.h"
#include "tools/study/cloth_methods.h"

namespace malha::study {

namespace {

using bench::formatted;

/// Shades a method, the darker the more particles.
const char* colour(const Json& row, std::size_t nth) {
  static constexpr const char* shades[][5] = {{"#9ecae1", "#6baed6", "#3182bd", "#08519c", "#08306b"},
                                              {"#a1d99b", "#74c476", "#31a354", "#006d2c", "#00441b"},
                                              {"#fdae6b", "#fd8d3c", "#d94801", "#a63603", "#7f2704"}};
  for (std::size_t k = 0; k < std::min(cloth_methods().size(), std::size(shades)); ++k)
    if (cloth_methods()[k].name == row["method"]) return shades[k][std::min<std::size_t>(nth, 4)];
  return "#000000";
}

double number(const Json& row, const std::string& key) { return row.at(key).get<double>(); }

std::string method_of(const Json& row) { return row["method"].get<std::string>(); }

/// Rows of a kind that were run, a group a method and side.
std::vector<std::vector<Json>> groups(const Json& rows, const std::string& kind) {
  std::vector<std::vector<Json>> all;
  for (const Json& row : rows) {
    if (row["kind"] != kind || !row["left_out"].is_null()) continue;
    if (all.empty() || all.back()[0]["method"] != row["method"] || all.back()[0]["side"] != row["side"])
      all.emplace_back();
    all.back().push_back(row);
  }
  return all;
}

std::string count_of(const Json& row) { return grouped(row["particles"].get<long long>()); }

std::string left_out(const Json& rows, const std::string& kind) {
  std::string line;
  for (const Json& row : rows)
    if (row["kind"] == kind && !row["left_out"].is_null())
      line += " " + method_of(row) + ", N = " + row["side"].dump() +
              ", is left out: " + row["left_out"].get<std::string>() + ".";
  return line;
}

Chart chart(const std::vector<std::vector<Json>>& all, const std::string& name, const std::string& title,
            const std::string& axis, const std::string& of, bool ideal) {
  Chart chart{name, "", {}};
  int most = 1;
  std::size_t nth = 0;
  std::string method;
  for (const auto& group : all) {
    nth = method == method_of(group[0]) ? nth + 1 : 0, method = method_of(group[0]);
    std::string points;
    for (const Json& row : group) {
      points += formatted("%d %.9g\n", row["threads"].get<int>(), number(row, of));
      most = std::max(most, row["threads"].get<int>());
    }
    chart.series.push_back({points,
                            std::string("with linespoints lw 2 ps 0.9 pt 7 lc rgb '") + colour(group[0], nth) + "'",
                            method_of(group[0]) + ", " + count_of(group[0])});
  }
  if (ideal)
    chart.series.push_back(
        {formatted("1 1\n%d %d\n", most, most), "with lines lw 1 dt 2 lc rgb '#000000'", "as many times"});
  std::string tics;
  for (int t = 1; t < most; t *= 2) tics += formatted("%d, ", t);
  chart.settings = "set logscale x\nset xtics (" + tics + std::to_string(most) +
                   formatted(")\nset xrange [0.9:%g]\nset yrange [0:*]\n", most * 1.1) +
                   (ideal && most > 8 ? "set logscale y\nset yrange [0.5:*]\n" : "") +
                   "set xlabel 'threads'\nset ylabel '" + axis + "'\nset title '" + title + "'\n";
  return chart;
}

/// "1.8 of 2 (PBD, 10 substeps, 289), ...": the lines on the most threads.
std::string on_most_threads(const std::vector<std::vector<Json>>& all, const std::string& of, const char* format,
                            double times = 1) {
  std::string line;
  for (const auto& group : all) {
    const Json& last = group.back();
    line += (line.empty() ? "" : ", ") + formatted(format, times * number(last, of)) + " (" + method_of(last) + ", " +
            count_of(last) + ")";
  }
  return line;
}

Section strong(const Json& rows, const std::string& pinning) {
  const auto all = groups(rows, "strong");
  Section section{"Strong scaling: the same cloth on more threads", {}, {}, {}};
  section.table.columns = {"method",
                           "particles",
                           "threads",
                           "ms a step",
                           "times as fast",
                           "by the least step",
                           "efficiency",
                           "serial share",
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
           formatted("%.0f %%", 100 * number(row, "efficiency")), formatted("%.2f", number(row, "serial_share")),
           formatted("%.1f", number(row, "gb_per_s")), formatted("%.1f", number(row, "triad_gb_per_s")),
           formatted("%.2f", number(row, "imbalance_by_patches")), formatted("%.3g", number(row, "setup_s"))});
    }
  double load = 0;
  for (const auto& group : all) load = std::max(load, number(group[0], "load_average"));
  section.sentences = {
      pinning +
          formatted("; the load average was %.1f at most before a case, this study's own threads among it.", load) +
          (load > 1.2 * most ? " Other programs had the cores too: medians are of their work as much as of this." : ""),
      formatted("Times as fast on %d threads as on one, the medians of turns: ", most) +
          on_most_threads(all, "times_as_fast", "%.2f") + "." + left_out(rows, "strong"),
      "Times as fast by the least step of each, the one least disturbed: " +
          on_most_threads(all, "undisturbed_times_as_fast", "%.2f") + ".",
      formatted(
          "The share that more threads do not speed up, fitted to all of them (of two numbers of threads: what the "
          "second one says): ") +
          on_most_threads(all, "serial_share", "%.2f") + ". Negative: faster than threads alone explain.",
      std::string("The states after the same steps are ") + (same ? "the same bits" : "NOT the same bits") +
          " on every number of threads."};
  section.chart = chart(all, "strong", "Strong scaling: the same cloth on more threads", "times as fast as one thread",
                        "times_as_fast", true);
  return section;
}

Section bandwidth(const Json& rows) {
  Section section{"Bandwidth: what must move, beside the triad", {}, {}, {}};
  std::vector<std::vector<Json>> large;  // what no cache holds
  for (const auto& group : groups(rows, "strong"))
    if (number(group[0], "particles") >= 1e6 || groups(rows, "strong").size() < 6) large.push_back(group);
  section.table.columns = {"method", "particles", "threads", "GB/s that must move", "triad of as many bytes, GB/s",
                           "share"};
  std::string said;
  for (const auto& group : groups(rows, "strong"))
    for (const Json& row : group)
      section.table.rows.push_back(
          {method_of(row), count_of(row), row["threads"].dump(), formatted("%.1f", number(row, "gb_per_s")),
           formatted("%.1f", number(row, "triad_gb_per_s")),
           formatted("%.0f %%", 100 * number(row, "gb_per_s") / number(row, "triad_gb_per_s"))});
  for (const auto& group : large)
    for (const Json* row : {&group.front(), &group.back()})
      said += formatted("%s%.1f of %.1f GB/s (", said.empty() ? "" : "; ", number(*row, "gb_per_s"),
                        number(*row, "triad_gb_per_s")) +
              method_of(*row) + ", " + count_of(*row) + ", " + counted(row->at("threads").get<int>(), "thread") + ")";
  section.sentences = {
      "PBD must read x, w and v and write x and v of every particle in every substep, 52 bytes; Desbrun's pass through "
      "the "
      "filter reads a sparse factor twice, a dense one once. Constraints, forces and what is read again come on top. "
      "The "
      "triad is over as many bytes as one substep or product walks through, so that small ones are those of caches.",
      "Reached, of the triad, by the largest: " + said + "."};
  return section;
}

Section passes(const Json& rows) {
  Section section{"Strong scaling, pass by pass", {}, {}, {}};
  section.table.columns = {"method",  "particles", "pass",         "ms on one thread", "share of the step",
                           "threads", "ms",        "times as fast"};
  std::string least;
  double worst = 1e300;
  for (const auto& group : groups(rows, "strong")) {
    const Json &one = group.front(), &last = group.back();
    for (const auto& [key, value] : one.items()) {
      if (!key.ends_with("_ms") || key == "step_ms") continue;
      const std::string pass = key.substr(0, key.size() - 3);
      if (!last.contains(key)) continue;
      const double share = value.get<double>() / number(one, "step_ms"), faster = number(last, pass + "_times_as_fast");
      section.table.rows.push_back({method_of(one), count_of(one), pass, formatted("%.4g", value.get<double>()),
                                    formatted("%.0f %%", 100 * share), last["threads"].dump(),
                                    formatted("%.4g", number(last, key)), formatted("%.2f", faster)});
      if (share > 0.05 && number(one, "particles") > 9000 && faster < worst)
        worst = faster, least = pass + " of " + method_of(one) + " with " + count_of(one) + " particles, " +
                                formatted("%.2f times on ", faster) + counted(last["threads"].get<int>(), "thread");
    }
  }
  section.sentences = {
      "PBD's prediction, projection and state are one pass here, \"visits\", a whole step in one parallel "
      "region. Passes of up to 32,768 particles that are no visits run on one thread by design."};
  if (!least.empty())
    section.sentences.push_back(
        "Of passes with 5 % of a step or more, from 10,000 particles on, the one that gains least: " + least + ".");
  return section;
}

Section launches(const Json& rows) {
  Section section{"What it costs to start threads and to wait for them", {}, {}, {}};
  section.table.columns = {"threads", "fork and join, microseconds", "median", "a barrier, microseconds"};
  std::string said;
  for (const Json& row : rows) {
    if (row["kind"] != "launch") continue;
    const double fork = number(row, "fork_join_us"), barrier = number(row, "barrier_us");
    section.table.rows.push_back({row["threads"].dump(), formatted("%.3g", fork),
                                  formatted("%.3g", number(row, "fork_join_median_us")), formatted("%.3g", barrier)});
    if (row["threads"] != 1)
      said += formatted("%s%.3g and %.3g microseconds on %s", said.empty() ? "" : "; ", fork, barrier,
                        counted(row["threads"].get<int>(), "thread").c_str());
  }
  section.sentences = {"An empty parallel region, and one more launch within it: " + said +
                       ", at best (where other programs have the cores it is the scheduler's time)."};
  std::string share;
  for (const auto& group : groups(rows, "strong")) {
    const Json& last = group.back();
    if (!last.contains("visits_ms") || number(last, "phases") == 0) continue;
    for (const Json& row : rows)
      if (row["kind"] == "launch" && row["threads"] == last["threads"]) {
        const double waits = number(row, "fork_join_us") + 10 * number(last, "phases") * number(row, "barrier_us");
        share += formatted("%s%.2g %% (%s)", share.empty() ? "" : ", ", waits / 10 / number(last, "step_ms"),
                           count_of(last).c_str());
      }
  }
  if (!share.empty())
    section.sentences.push_back(
        "A step of PBD is one region with 10 substeps of as many barriers as its patches have phases; "
        "that makes, of a step on the most threads by particles: " +
        share + ".");
  return section;
}

Section weak(const Json& rows) {
  const auto all = groups(rows, "weak");
  Section section{"Weak scaling: a cloth that grows with the threads", {}, {}, {}};
  section.table.columns = {"method", "particles", "threads", "ms a step", "efficiency"};
  for (const auto& group : all)
    for (const Json& row : group)
      section.table.rows.push_back({method_of(row), count_of(row), row["threads"].dump(),
                                    formatted("%.4g", number(row, "step_ms")),
                                    formatted("%.0f %%", 100 * number(row, "efficiency"))});
  section.sentences = {
      "Efficiency is the time of one thread over that of all, each with as many particles a thread: " +
      on_most_threads(all, "efficiency", "%.0f %%", 100) + "." + left_out(rows, "weak") +
      " A sparse factor's work grows a little faster than its particles, which counts against it here."};
  section.chart = chart(all, "weak", "Weak scaling: as many particles a thread (of one thread in the legend)",
                        "efficiency", "efficiency", false);
  return section;
}

}  // namespace

std::vector<Section> scaling_sections(const Json& rows, const std::string& pinning) {
  return {strong(rows, pinning), passes(rows), bandwidth(rows), launches(rows), weak(rows)};
}

}  // namespace malha::study
