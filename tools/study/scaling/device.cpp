// SPDX-License-Identifier: Apache-2.0
#include "malha/text.h"
#include "tools/bench/output.h"
#include "tools/study/cloth_methods.h"
#include "tools/study/scaling/rows.h"
#include "tools/study/scaling/sections.h"

namespace malha::study {

using bench::formatted;

Section scaling_on_device(const Json& rows) {
  const auto all = scaling_groups(rows, "strong");
  Section section{"What a step takes on the device, by size"};
  section.table.columns = {"method",   "particles",           "ms a step",     "ns a particle and step",
                           "colours",  "GB/s that must move", "a copy's GB/s", "share",
                           "set-up, s"};
  Chart chart{"device",
              "set logscale xy\nset xlabel 'particles'\nset ylabel 'ms a step'\n"
              "set title 'What a step takes on the device'\n"};
  for (const ClothMethod& method : cloth_methods()) {
    bench::Series series{"", method.style(), method.name};
    for (const auto& group : all) {
      const Json& row = group.front();
      if (method_of(row) != method.name) continue;
      const double ms = number(row, "step_ms"), particles = number(row, "particles");
      std::vector<std::string> line = bandwidth_cells(row);
      line.insert(line.begin(), {method.name, count_of(row), formatted("%.4g", ms),
                                 formatted("%.3g", 1e6 * ms / particles), row["patch_colors"].dump()});
      line.push_back(formatted("%.3g", number(row, "setup_s")));
      section.table.rows.push_back(line);
      series.data += formatted("%.9g %.9g\n", particles, ms);
    }
    if (!series.data.empty()) chart.series.push_back(series);
  }
  section.sentences = {"On " + (all.empty() ? "no device" : all[0][0].value("device", "")) +
                           ". The host waits for every pass, to time it, which it does not in a run." +
                           scaling_left_out(rows, "strong"),
                       kRequiredBytes};
  section.chart = chart;
  return section;
}

}  // namespace malha::study
