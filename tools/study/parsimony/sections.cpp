// SPDX-License-Identifier: Apache-2.0
#include "tools/study/parsimony/sections.h"

#include <algorithm>
#include <cmath>

#include "host/solver/solver.h"
#include "tools/bench/output.h"
#include "tools/study/parsimony/charts.h"

namespace malha::study {

namespace {

using bench::formatted;

Json of_kind(const Json& rows, const char* kind) {
  Json some = Json::array();
  for (const Json& row : rows)
    if (row["kind"] == kind) some.push_back(row);
  return some;
}

std::string or_none(const std::string& list) { return list.empty() ? "none" : list; }

/// Difference of the times of the same scene in percent, from the feature that adds nothing.
double noise(const Json& single) { return std::abs(number(single[0], "added_percent")); }

Section time_section(const Json& single) {
  Section section{"What each feature adds to a step"};
  const double whole = number(single[0], "ms_a_step_without");
  section.sentences.push_back(
      formatted("A cloth of %.0f particles with distances along its edges takes %.3g ms a step (10 substeps of 1 "
                "iteration, one thread, processor time); two simulations of this scene, in turns, differ by %.2g %%.",
                number(single[0], "particles"), whole, noise(single)));
  std::vector<Json> sorted(single.begin(), single.end());
  std::stable_sort(sorted.begin(), sorted.end(), [](const Json& a, const Json& b) {
    return number(a, "added_percent") < number(b, "added_percent");
  });
  const auto list = [&](bool cheap) {
    return or_none(listed(sorted, [&](const Json& row) {
      const double percent = number(row, "added_percent");
      const bool summary = row["feature"] != "nothing" && (cheap ? percent < 10 : percent > 200);
      return summary ? text(row, "feature") + formatted(" %+.0f %%", percent) : "";
    }));
  };
  section.sentences.push_back("Features that add less than a tenth of the scene's time: " + list(true) + ".");
  section.sentences.push_back("Features that add more than twice the scene's time: " + list(false) + ".");
  section.chart =
      Chart{"time",
            feature_tics(single) + "set logscale x\nset format x '%g'\nset xlabel 'added ms a step'\n" +
                "set title 'Each feature alone: time added to a step'\n" + formatted("set xrange [%g:]\n", whole / 100),
            {feature_bars(single, "added_ms", 1, whole / 100, "#0072b2", "added"),
             {formatted("%g %g\n%g %g\n", whole, -0.7, whole, static_cast<double>(single.size()) - 0.3),
              "with lines lw 2 dt 2 lc rgb '#d55e00'", "the whole step of the cloth"}}};
  section.table.columns = {"feature", "added to", "particles", "ms without", "ms with", "added ms", "added %"};
  for (const Json& row : single)
    section.table.rows.push_back(
        {text(row, "feature"), text(row, "base"), formatted("%.0f", number(row, "particles")),
         formatted("%.4g", number(row, "ms_a_step_without")), formatted("%.4g", number(row, "ms_a_step")),
         formatted("%+.3g", number(row, "added_ms")), formatted("%+.1f", number(row, "added_percent"))});
  return section;
}

constexpr const char* kOwners[] = {"particles", "constraints", "air",   "patches", "springs",
                                   "filter",    "collision",   "model", "levels"};

Section memory_section(const Json& single) {
  Section section{"What each feature adds to memory"};
  const double particles = number(single[0], "particles");
  const std::string line = listed(kOwners, [&](const char* owner) {
    const double bytes = number(single[0], std::string(owner) + "_bytes");
    return bytes > 0 ? owner + formatted(" %.3g", bytes / particles) : "";
  });
  section.sentences.push_back("Bytes a particle of the cloth with distance constraints only: " + line +
                              ". Memory that Embree allocates is not counted.");
  Json scaled = single;
  for (Json& row : scaled) row["added_a_particle"] = number(row, "added_bytes") / number(row, "particles");
  const std::string nothing = listed(single, [](const Json& row) {
    return number(row, "added_bytes") == 0 && row["feature"] != "nothing" ? text(row, "feature") : "";
  });
  section.sentences.push_back("Features that add no memory: " + or_none(nothing) + ".");
  section.chart =
      Chart{"memory",
            feature_tics(single) + "set logscale x\nset format x '%g'\nset xlabel 'added bytes a particle'\n" +
                "set title 'Each feature alone: memory added'\nset xrange [0.01:]\n",
            {feature_bars(scaled, "added_a_particle", 1, 0.01, "#009e73", "")}};
  section.table.columns = {"feature", "added to", "added bytes a particle", "of them"};
  for (const Json& row : scaled) {
    const std::string owners = listed(kOwners, [&](const char* owner) {
      const double bytes = number(row, std::string(owner) + "_bytes_added");
      return bytes != 0 ? owner + formatted(" %+.3g", bytes / number(row, "particles")) : "";
    });
    section.table.rows.push_back(
        {text(row, "feature"), text(row, "base"), formatted("%+.4g", number(row, "added_a_particle")), owners});
  }
  return section;
}

Section launch_section(const Json& single) {
  Section section{"What each feature launches"};
  section.sentences.push_back("The cloth with distance constraints only launches in a step: " +
                              text(single[0], "kernels") + ", and nothing else.");
  const auto list = [&](bool (*says)(const std::string& added)) {
    return or_none(listed(single, [&](const Json& row) {
      return row["feature"] != "nothing" && says(text(row, "kernels_added")) ? text(row, "feature") : "";
    }));
  };
  const auto same = [](const std::string& added) { return added.empty(); };
  const auto split = [](const std::string& added) { return (", " + added).find(", Predict<") != std::string::npos; };
  section.sentences.push_back("Features that add no launch: " + list(same) + ".");
  section.sentences.push_back(
      "Features that work between prediction and velocity update, which therefore run as separate launches instead of "
      "within the patch solve: " +
      list(split) + ".");
  section.table.columns = {"feature", "added to", "launches without", "with", "kernels added", "kernels gone"};
  for (const Json& row : single)
    section.table.rows.push_back(
        {text(row, "feature"), text(row, "base"), formatted("%.0f", number(row, "launches_a_step_without")),
         formatted("%.0f", number(row, "launches_a_step")), text(row, "kernels_added"), text(row, "kernels_gone")});
  return section;
}

Section ladder_section(const Json& ladder) {
  Section section{"A cloth with more and more features"};
  const Json &first = ladder[0], &last = ladder.back(), &before = ladder[ladder.size() - 2];
  section.sentences.push_back(
      formatted("From %.3g ms a step with distance constraints only to %.3g ms with everything but self-collision, and "
                "%.3g ms with self-collision too;",
                number(first, "ms_a_step"), number(before, "ms_a_step"), number(last, "ms_a_step")) +
      formatted(" from %.3g to %.3g and %.3g bytes a particle;", number(first, "bytes") / number(first, "particles"),
                number(before, "bytes") / number(before, "particles"),
                number(last, "bytes") / number(last, "particles")) +
      formatted(" from %.0f to %.0f and %.0f launches a step.", number(first, "launches_a_step"),
                number(before, "launches_a_step"), number(last, "launches_a_step")));
  section.chart = ladder_chart(ladder);
  section.table.columns = {"scene", "ms a step", "bytes a particle", "launches a step", "ms by pass"};
  for (const Json& row : ladder) {
    const std::string passes = listed(kPassNames, [&](const char* pass) {
      const double ms = number(row, std::string("pass_") + pass + "_ms");
      return ms > 0 ? pass + formatted(" %.3g", ms) : "";
    });
    section.table.rows.push_back({text(row, "feature"), formatted("%.4g", number(row, "ms_a_step")),
                                  formatted("%.4g", number(row, "bytes") / number(row, "particles")),
                                  formatted("%.0f", number(row, "launches_a_step")), passes});
  }
  return section;
}

}  // namespace

std::vector<Section> parsimony_sections(const Json& rows) {
  const Json single = of_kind(rows, "single"), ladder = of_kind(rows, "ladder");
  return {time_section(single), memory_section(single), launch_section(single), ladder_section(ladder)};
}

}  // namespace malha::study
