// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/filter/chart.h"

#include <set>

#include "malha/text.h"
#include "tools/bench/gnuplot.h"
#include "tools/bench/output.h"

namespace malha::bench {

namespace {

/// How the rows of a kernel are drawn. Entries are in the order of the legend.
struct SeriesStyle {
  const char *kernel, *storage, *title, *colour;
};
constexpr SeriesStyle kStyles[] = {
    {"dense", "float", "dense, float", "#0072b2"},   {"dense", "int16", "dense, int16", "#56b4e9"},
    {"sparse", "float", "sparse, float", "#009e73"}, {"sgemm", "float", "OpenBLAS sgemm", "#d55e00"},
    {"ssymm", "float", "OpenBLAS ssymm", "#e69f00"}, {"ssymv", "float", "OpenBLAS 3 ssymv", "#000000"}};

}  // namespace

std::string draw_filter_chart(const std::vector<FilterRow>& rows, const std::filesystem::path& folder) {
  std::set<int> sizes, threads;
  std::set<double> times;
  for (const FilterRow& row : rows) {
    sizes.insert(row.n), threads.insert(row.threads);
    times.insert({row.ms_min(), row.ms_max()});
  }
  std::vector<Series> all;
  for (const SeriesStyle& style : kStyles)
    for (const int t : threads) {
      // The largest number of threads is a solid line, others are dashed.
      Series series{"",
                    formatted("with yerrorlines pt 7 ps 0.7 lw 2 dt %d lc rgb '%s'", t == *threads.rbegin() ? 1 : 2,
                              style.colour),
                    std::string(style.title) + ", " + counted(t, "thread")};
      for (const FilterRow& row : rows)
        if (row.kernel == style.kernel && row.storage == style.storage && row.threads == t)
          series.data += formatted("%d %.9g %.9g %.9g\n", row.n, row.ms(), row.ms_min(), row.ms_max());
      if (!series.data.empty()) all.push_back(series);
    }
  const std::string settings =
      "set logscale xy\nset xlabel 'unknowns'\nset ylabel 'ms per product'\n"
      "set title 'Filter times three right-hand sides: a hanging cloth'\nset format y '%g'\nset format x '%g'\n" +
      formatted("set xrange [%g:%g]\n", *sizes.begin() / 1.4, *sizes.rbegin() * 1.4) +
      formatted("set yrange [%g:%g]\n", *times.begin() / 1.4, *times.rbegin() * 1.4);
  return draw(settings, all, folder, "filter");
}

}  // namespace malha::bench
