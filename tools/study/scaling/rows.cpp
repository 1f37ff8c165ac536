// SPDX-License-Identifier: Apache-2.0
#include "tools/study/scaling/rows.h"

#include "malha/text.h"
#include "tools/bench/output.h"
#include "tools/study/cloth_methods.h"

namespace malha::study {

using bench::formatted;

std::string method_of(const Json& row) { return row["method"].get<std::string>(); }

std::vector<std::vector<Json>> scaling_groups(const Json& rows, const std::string& kind) {
  std::vector<std::vector<Json>> all;
  for (const Json& row : rows) {
    if (row["kind"] != kind || !row["left_out"].is_null()) continue;
    if (all.empty() || all.back()[0]["method"] != row["method"] || all.back()[0]["side"] != row["side"])
      all.emplace_back();
    all.back().push_back(row);
  }
  return all;
}

std::string count_of(const Json& row) { return with_commas(row["particles"].get<long long>()); }

std::string scaling_left_out(const Json& rows, const std::string& kind) {
  std::string line;
  for (const Json& row : rows)
    if (row["kind"] == kind && !row["left_out"].is_null())
      line += " " + method_of(row) + ", N = " + row["side"].dump() +
              ", is left out: " + row["left_out"].get<std::string>() + ".";
  return line;
}

std::vector<std::string> bandwidth_cells(const Json& row) {
  const double moved = number(row, "gb_per_s"), memory = number(row, "triad_gb_per_s");
  return {formatted("%.1f", moved), formatted("%.1f", memory), formatted("%.0f %%", 100 * moved / memory)};
}

Section scaling_bandwidth(const Json& rows) {
  Section section{"Bandwidth: what must move, beside the triad"};
  std::vector<std::vector<Json>> large;  // bodies larger than any cache
  for (const auto& group : scaling_groups(rows, "strong"))
    if (number(group[0], "particles") >= 1e6 || scaling_groups(rows, "strong").size() < 6) large.push_back(group);
  section.table.columns = {"method", "particles", "threads", "GB/s that must move", "triad of as many bytes, GB/s",
                           "share"};
  std::string summary;
  for (const auto& group : scaling_groups(rows, "strong"))
    for (const Json& row : group) {
      std::vector<std::string> line = bandwidth_cells(row);
      line.insert(line.begin(), {method_of(row), count_of(row), row["threads"].dump()});
      section.table.rows.push_back(line);
    }
  for (const auto& group : large)
    for (const Json* row : {&group.front(), &group.back()})
      append(summary,
             formatted("%.1f of %.1f GB/s (", number(*row, "gb_per_s"), number(*row, "triad_gb_per_s")) +
                 method_of(*row) + ", " + count_of(*row) + ", " + counted(row->at("threads").get<int>(), "thread") +
                 ")",
             "; ");
  section.sentences = {
      std::string(kRequiredBytes) +
          " Constraints, forces and repeated reads are not included. The triad is over as many "
          "bytes as one substep or product reads and writes, so that for small bodies it is that of caches.",
      "Bandwidth of the largest bodies, and that of the triad: " + summary + "."};
  return section;
}

Section scaling_passes(const Json& rows) {
  Section section{"Strong scaling, pass by pass"};
  section.table.columns = {"method",  "particles", "pass",         "ms on one thread", "share of the step",
                           "threads", "ms",        "times as fast"};
  std::string least;
  double worst = 1e300;
  for (const auto& group : scaling_groups(rows, "strong")) {
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
      "PBD's prediction, projection and velocity update are one pass here, \"fused_solve\", a whole step in one "
      "parallel "
      "region. Passes over up to 32,768 particles, other than patch solves, run on one thread by design."};
  if (!least.empty())
    section.sentences.push_back(
        "The pass with the smallest speed-up, of those with 5 % of a step or more from 10,000 particles on: " + least +
        ".");
  return section;
}

Section scaling_launches(const Json& rows) {
  Section section{"Time to start threads and to wait at barriers"};
  section.table.columns = {"threads", "fork and join, microseconds", "median", "a barrier, microseconds"};
  std::string summary;
  for (const Json& row : rows) {
    if (row["kind"] != "launch") continue;
    const double fork = number(row, "fork_join_us"), barrier = number(row, "barrier_us");
    section.table.rows.push_back({row["threads"].dump(), formatted("%.3g", fork),
                                  formatted("%.3g", number(row, "fork_join_median_us")), formatted("%.3g", barrier)});
    if (row["threads"] != 1)
      append(summary,
             formatted("%.3g and %.3g microseconds on ", fork, barrier) + counted(row["threads"].get<int>(), "thread"),
             "; ");
  }
  section.sentences = {"An empty parallel region, and one more launch within it: " + summary +
                       ", at best (if other programs use the cores, the times are those of the scheduler)."};
  std::string share;
  for (const auto& group : scaling_groups(rows, "strong")) {
    const Json& last = group.back();
    if (!last.contains("fused_solve_ms") || number(last, "patch_colors") == 0) continue;
    for (const Json& row : rows)
      if (row["kind"] == "launch" && row["threads"] == last["threads"]) {
        const double waits =
            number(row, "fork_join_us") + 10 * number(last, "patch_colors") * number(row, "barrier_us");
        append(share, formatted("%.2g %% (", waits / 10 / number(last, "step_ms")) + count_of(last) + ")");
      }
  }
  if (!share.empty())
    section.sentences.push_back(
        "A step of PBD is one region with 10 substeps, each with a barrier per colour of patches. Their share of a "
        "step on "
        "the most threads, by particles: " +
        share + ".");
  return section;
}

}  // namespace malha::study
