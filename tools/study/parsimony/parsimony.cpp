// SPDX-License-Identifier: Apache-2.0
#include "tools/study/parsimony/parsimony.h"

#include "tools/study/parsimony/cell.h"
#include "tools/study/parsimony/scenes.h"
#include "tools/study/parsimony/sections.h"
#include "tools/study/rows.h"

namespace malha::study {

namespace {

double sum(const Json& numbers) {
  double all = 0;
  for (const auto& item : numbers.items()) all += item.value().get<double>();
  return all;
}

/// Launches of `a` beyond those of `b`: "Predict<float> 10, UpdateState<float> 10".
std::string added_launches(const Json& a, const Json& b) {
  return listed(a, [&](const Json& launch) {
    auto launches = launch["launches"].get<std::int64_t>();
    for (const Json& other : b)
      if (other["kernel"] == launch["kernel"]) launches -= other["launches"].get<std::int64_t>();
    return launches > 0 ? launch["kernel"].get<std::string>() + " " + std::to_string(launches) : "";
  });
}

Json launches(const Json& list) {
  std::int64_t all = 0;
  for (const Json& launch : list) all += launch["launches"].get<std::int64_t>();
  return all;
}

Json row(const char* kind, const FeatureCase& feature_case, const Json& without, const Json& with) {
  Json row{{"kind", kind},
           {"feature", feature_case.feature},
           {"base", feature_case.base},
           {"particles", with["particles"]},
           {"ms_a_step", with["ms_a_step"]},
           {"ms_a_step_without", without["ms_a_step"]},
           {"added_ms", with["added_ms"]},
           {"added_percent", 100 * with["added_ms"].get<double>() / without["ms_a_step"].get<double>()},
           {"bytes", sum(with["bytes"])},
           {"added_bytes", sum(with["bytes"]) - sum(without["bytes"])},
           {"launches_a_step", launches(with["launches"])},
           {"launches_a_step_without", launches(without["launches"])},
           {"kernels", added_launches(with["launches"], Json::array())},
           {"kernels_added", added_launches(with["launches"], without["launches"])},
           {"kernels_gone", added_launches(without["launches"], with["launches"])}};
  for (const auto& [pass, ms] : with["passes_ms"].items()) row["pass_" + pass + "_ms"] = ms;
  for (const auto& [owner, count] : with["bytes"].items()) row[owner + "_bytes"] = count;
  for (const auto& [owner, count] : with["bytes"].items())
    row[owner + "_bytes_added"] = count.get<double>() - without["bytes"][owner].get<double>();
  copy_machine(row, with);
  return row;
}

}  // namespace

Findings run_parsimony(Cells& cells) {
  const std::vector<FeatureCase> single = single_features(cells.quick()), ladder = feature_ladder(cells.quick());
  cells.plan(static_cast<int>(single.size()) + 1);
  Findings findings;
  const std::vector<Json> pairs = cells.measure_all(
      single, [](const FeatureCase& feature_case) { return feature_case.base + ", " + feature_case.feature; },
      [&](const FeatureCase& feature_case) {
        return parsimony_cell({feature_case.without, feature_case.with}, cells);
      });
  const Json rungs = cells("ladder", [&] {
    std::vector<Scene> scenes{ladder.front().without};
    for (const FeatureCase& feature_case : ladder) scenes.push_back(feature_case.with);
    return parsimony_cell(scenes, cells);
  });
  if (cells.is_partial()) return findings;
  for (std::size_t k = 0; k < single.size(); ++k)
    findings.rows.push_back(row("single", single[k], pairs[k][0], pairs[k][1]));
  for (std::size_t k = 0; k < ladder.size(); ++k)
    findings.rows.push_back(row("ladder", ladder[k], rungs[k], rungs[k + 1]));
  findings.sections = parsimony_sections(findings.rows);
  return findings;
}

}  // namespace malha::study
