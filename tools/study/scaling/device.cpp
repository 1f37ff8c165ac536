#include "host/base/text.h"
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
                           "phases",   "GB/s that must move", "a copy's GB/s", "share",
                           "set-up, s"};
  Chart chart{"device",
              "set logscale xy\nset xlabel 'particles'\nset ylabel 'ms a step'\n"
              "set title 'What a step takes on the device'\n"};
  for (const auto& group : all) {
    const Json& row = group.front();
    const double ms = number(row, "step_ms"), particles = number(row, "particles");
    section.table.rows.push_back({method_of(row), count_of(row), formatted("%.4g", ms),
                                  formatted("%.3g", 1e6 * ms / particles), row["phases"].dump(),
                                  formatted("%.1f", number(row, "gb_per_s")),
                                  formatted("%.1f", number(row, "triad_gb_per_s")),
                                  formatted("%.0f %%", 100 * number(row, "gb_per_s") / number(row, "triad_gb_per_s")),
                                  formatted("%.3g", number(row, "setup_s"))});
    if (chart.series.empty() || chart.series.back().title != method_of(row))
      for (const ClothMethod& method : cloth_methods())
        if (method.name == method_of(row)) chart.series.push_back({"", method.style(), method.name});
    chart.series.back().data += formatted("%.9g %.9g\n", particles, ms);
  }
  std::string left_out;
  for (const Json& row : rows)
    if (!row["left_out"].is_null())
      add_to(left_out, method_of(row) + ", N = " + row["side"].dump() + ": " + row["left_out"].get<std::string>(),
             "; ");
  section.sentences = {
      "On " + (all.empty() ? "no device" : all[0][0].value("device", "")) +
          ". Every pass is waited for, to time it, which steps of a run are not.",
      "PBD must read x, w and v and write x and v of every particle in every substep, 52 bytes; Desbrun's pass through "
      "the filter reads a sparse factor twice, a dense one once."};
  if (!left_out.empty()) section.sentences.push_back("Left out: " + left_out + ".");
  section.chart = chart;
  return section;
}

}  // namespace malha::study
