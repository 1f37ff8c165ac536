// SPDX-License-Identifier: Apache-2.0
#include "tools/study/parsimony/charts.h"

#include "tools/bench/output.h"

namespace malha::study {

namespace {

using bench::formatted;

std::string quoted(const std::string& name) { return "'" + name + "'"; }

/// A horizontal bar at row k, as data of gnuplot's boxxyerror.
std::string bar(std::size_t k, double x, double from, double to) {
  return formatted("%g %zu %g %g %g %g\n", x, k, from, to, static_cast<double>(k) - 0.35,
                   static_cast<double>(k) + 0.35);
}
std::string filled(const std::string& colour) {
  return "with boxxyerror fs solid 0.8 noborder lc rgb '" + colour + "'";
}

/// A group of passes that is drawn as one bar.
struct Layer {
  const char* title;
  std::vector<const char*> passes;
  const char* colour;
};

const std::vector<Layer>& layers() {
  static const std::vector<Layer> all{
      {"prediction, projection, state", {"fused_solve", "prediction", "projection", "state"}, "#0072b2"},
      {"air", {"air"}, "#56b4e9"},
      {"damping", {"damping"}, "#e69f00"},
      {"reach, pins, attachments, sleep", {"long_range", "pins", "attachments", "sleep"}, "#009e73"},
      {"environment", {"collision", "contact"}, "#d55e00"}};
  return all;
}

}  // namespace

std::string feature_tics(const Json& rows) {
  std::string tics;
  for (std::size_t k = 0; k < rows.size(); ++k)
    tics += (k == 0 ? "" : ", ") + quoted(text(rows[k], "feature")) + " " + std::to_string(k);
  return "set ytics (" + tics + ") noenhanced\n" +
         formatted("set yrange [%g:-0.7]\n", static_cast<double>(rows.size()) - 0.3);
}

bench::Series feature_bars(const Json& rows, const std::string& key, double scale, double from,
                           const std::string& colour, const std::string& title) {
  std::string data;
  for (std::size_t k = 0; k < rows.size(); ++k)
    if (const double value = number(rows[k], key) * scale; value > from) data += bar(k, value, from, value);
  return {data, filled(colour), title};
}

Chart ladder_chart(const Json& ladder) {
  Json rungs = ladder;
  const Json last = rungs.back();
  rungs.erase(rungs.size() - 1);
  std::vector<double> from(rungs.size(), 0);
  Chart chart{"ladder", feature_tics(rungs) +
                            "set xlabel 'ms a step'\nset title 'A cloth with more and more features (" +
                            text(last, "feature") +
                            formatted(": %.3g ms, off the chart)'\n", number(last, "ms_a_step")) + "set xrange [0:]\n"};
  for (const Layer& layer : layers()) {
    std::string data;
    for (std::size_t k = 0; k < rungs.size(); ++k) {
      double ms = 0;
      for (const char* pass : layer.passes) ms += number(rungs[k], std::string("pass_") + pass + "_ms");
      if (ms > 0) data += bar(k, from[k], from[k], from[k] + ms);
      from[k] += ms;
    }
    if (!data.empty()) chart.series.push_back({data, filled(layer.colour), layer.title});
  }
  return chart;
}

}  // namespace malha::study
