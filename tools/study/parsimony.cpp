#include "tools/study/parsimony.h"

#include "tools/study/parsimony_cell.h"
#include "tools/study/parsimony_sections.h"

namespace malha::study {

namespace {

double sum(const Json& numbers) {
  double all = 0;
  for (const auto& item : numbers.items()) all += item.value().get<double>();
  return all;
}

/// "Predict<float> 10, UpdateState<float> 10": of `a` what goes beyond `b`.
std::string beyond(const Json& a, const Json& b) {
  std::string list;
  for (const Json& of : a) {
    auto launches = of["launches"].get<std::int64_t>();
    for (const Json& other : b)
      if (other["kernel"] == of["kernel"]) launches -= other["launches"].get<std::int64_t>();
    if (launches > 0)
      list += (list.empty() ? "" : ", ") + of["kernel"].get<std::string>() + " " + std::to_string(launches);
  }
  return list;
}

Json launches(const Json& list) {
  std::int64_t all = 0;
  for (const Json& of : list) all += of["launches"].get<std::int64_t>();
  return all;
}

Json row(const char* kind, const Demand& of, const Json& cell) {
  const Json &with = cell["with"], &without = cell["without"];
  Json row{{"kind", kind},
           {"feature", of.feature},
           {"base", of.base},
           {"particles", cell["particles"]},
           {"ms_a_step", with["ms_a_step"]},
           {"ms_a_step_without", without["ms_a_step"]},
           {"added_ms", cell["added_ms"]},
           {"added_percent", cell["added_percent"]},
           {"bytes", sum(with["bytes"])},
           {"added_bytes", sum(with["bytes"]) - sum(without["bytes"])},
           {"launches_a_step", launches(with["launches"])},
           {"launches_a_step_without", launches(without["launches"])},
           {"kernels", beyond(with["launches"], Json::array())},
           {"kernels_added", beyond(with["launches"], without["launches"])},
           {"kernels_gone", beyond(without["launches"], with["launches"])}};
  for (const auto& [pass, ms] : with["passes_ms"].items()) row["pass_" + pass + "_ms"] = ms;
  for (const auto& [owner, count] : with["bytes"].items()) row[owner + "_bytes"] = count;
  for (const auto& [owner, count] : with["bytes"].items())
    row[owner + "_bytes_added"] = count.get<double>() - without["bytes"][owner].get<double>();
  return row;
}

}  // namespace

Findings run_parsimony(Cells& cells) {
  const std::vector<Demand> single = single_demands(cells.quick()), ladder = ladder_of_demands(cells.quick());
  cells.plan(static_cast<int>(single.size() + ladder.size()));
  Findings findings;
  for (const Demand& of : single)
    findings.rows.push_back(
        row("single", of, cells(of.base + ", " + of.feature, [&] { return parsimony_cell(of, cells); })));
  for (const Demand& of : ladder)
    findings.rows.push_back(
        row("ladder", of, cells("ladder, " + of.feature, [&] { return parsimony_cell(of, cells); })));
  findings.sections = parsimony_sections(findings.rows);
  return findings;
}

}  // namespace malha::study
