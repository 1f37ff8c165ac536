// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/self/chart.h"

#include <set>

#include "malha/text.h"
#include "tools/bench/gnuplot.h"
#include "tools/bench/output.h"

namespace malha::bench {

namespace {

// Chen, Hsu, Liu, Macklin, Yang, Yuksel: Offset Geometric Contact (2025): 50 layers that fall over a cylinder, on a CPU
// of many cores; seconds a step.
constexpr int kPublishedParticles = 246'000;
constexpr double kPublishedMean = 0.21, kPublishedLargest = 0.55;

Series points(const std::string& data, int type, const char* colour, int dash, const std::string& title) {
  return {data, formatted("with linespoints pt %d ps 1.2 lw 2 dt %d lc rgb '%s'", type, dash, colour), title};
}

}  // namespace

bool has_layers_chart(const nlohmann::ordered_json& rows) {
  std::set<int> sizes;
  for (const auto& row : rows)
    if (row["case"] == "layers") sizes.insert(row["particles"].get<int>());
  return sizes.size() > 1;
}

std::string draw_layers_chart(const nlohmann::ordered_json& rows, const std::filesystem::path& folder) {
  std::set<int> threads;
  for (const auto& row : rows)
    if (row["case"] == "layers") threads.insert(row["threads"].get<int>());
  std::vector<Series> all;
  const char* const colours[] = {"#0072b2", "#009e73", "#d55e00", "#cc79a7"};
  for (int number = 0; const int t : threads) {
    std::string mean, largest;
    for (const auto& row : rows)
      if (row["case"] == "layers" && row["threads"] == t) {
        const int particles = row["particles"].get<int>();
        mean += formatted("%d %.9g\n", particles, row["step_ms"].get<double>() / 1000);
        largest += formatted("%d %.9g\n", particles, row["step_ms_largest"].get<double>() / 1000);
      }
    const char* const colour = colours[number++ % std::size(colours)];
    all.push_back(points(mean, 7, colour, 1, counted(t, "thread") + ", mean"));
    all.push_back(points(largest, 6, colour, 2, counted(t, "thread") + ", largest"));
  }
  const std::string other = "OGC (2025) as printed, many cores, ";
  all.push_back(points(formatted("%d %g\n", kPublishedParticles, kPublishedMean), 9, "#000000", 1, other + "mean"));
  all.push_back(
      points(formatted("%d %g\n", kPublishedParticles, kPublishedLargest), 8, "#000000", 1, other + "largest"));
  return draw(
      "set logscale xy\nset xlabel 'particles'\nset ylabel 's per step of 1/60 s'\n"
      "set title 'Fifty layers fall over a ball; nothing crosses after any step'\n"
      "set format x '%g'\nset format y '%g'\n",
      all, folder, "self");
}

}  // namespace malha::bench
