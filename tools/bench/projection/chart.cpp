// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/projection/chart.h"

#include <cstdio>
#include <map>
#include <set>
#include <sstream>

#include "malha/text.h"
#include "tools/bench/gnuplot.h"

namespace malha::bench {

namespace {

bool is_drawn(const Row& row) { return row.library == "bullet" || row.schedule.substeps == 10; }

std::string colour(const Row& row) {
  if (row.library == "bullet") return "#d55e00";
  if (row.schedule.levels) return row.threads == 1 ? "#aa3377" : "#cc79a7";
  return row.threads == 1 ? "#0072b2" : "#009e73";
}

std::string name(const Row& row) {
  return (row.library == "bullet" ? "Bullet, " : row.schedule.levels ? "with levels, " : "malha, ") + executor_of(row);
}

/// A line through the grids, and open marks for the irregular mesh, per library and number of threads.
std::vector<Series> series(const std::vector<Row>& rows) {
  std::map<std::string, Series> blocks;  // by a key in the order of the legend
  const auto add = [&blocks](const std::string& key, const Series& how, const std::string& data) {
    blocks.try_emplace(key, how).first->second.data += data;
  };
  for (const Row& row : rows) {
    if (!is_drawn(row)) continue;
    const bool grid = row.case_name == "grid";
    char key[64], data[160], floor[80];
    std::snprintf(key, sizeof key, "%d %04d %s", row.library == "bullet" ? 2 : row.schedule.levels, row.threads,
                  grid ? "grid" : "irregular");
    std::snprintf(data, sizeof data, "%.9g %.9g %.9g %.9g\n", row.side, row.ns_per_projection(), row.ns_min(),
                  row.ns_max());
    const std::string lines = "lw 2 lc rgb '" + colour(row) + "'";
    add(key,
        {"", grid ? "with yerrorlines pt 7 ps 0.9 " + lines : "with yerrorbars pt 6 ps 1.4 " + lines,
         name(row) + (grid ? "" : ", irregular")},
        data);
    if (row.library == "bullet" || row.schedule.levels) continue;
    std::snprintf(floor, sizeof floor, "%.9g %.9g\n", row.side, row.floor_ns());
    add("3" + std::string(key),
        {"", grid ? "with linespoints dt 2 pt 7 ps 0.4 " + lines : "with points pt 2 " + lines,
         "floor, " + name(row).substr(7) + (grid ? "" : ", irregular")},
        floor);
  }
  std::vector<Series> all;
  for (auto& [key, drawn] : blocks) all.push_back(std::move(drawn));
  return all;
}

}  // namespace

std::string draw_chart(const std::vector<Row>& rows, const std::filesystem::path& folder) {
  std::set<int> sides;
  for (const Row& row : rows) sides.insert(static_cast<int>(row.side));
  std::ostringstream text;
  text << "set logscale xy\nset xlabel 'particles a side (irregular mesh: square root of their number)'\nset ylabel "
          "'ns per projection (whole step)'\n"
       << "set title 'A hanging cloth in float: malha with 10 substeps of 1 iteration, Bullet with 10 iterations'\n"
       << "set xrange [" << *sides.begin() / 1.4 << ":" << *sides.rbegin() * 1.4 << "]\n"
       << "set format y '%g'\nset xtics (";
  for (const int side : sides) text << (side == *sides.begin() ? "" : ", ") << side;
  text << ")\n";
  return draw(text.str(), series(rows), folder, "projection");
}

}  // namespace malha::bench
