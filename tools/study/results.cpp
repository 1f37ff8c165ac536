// SPDX-License-Identifier: Apache-2.0
#include "tools/study/results.h"

#include <algorithm>
#include <sstream>

#include "host/base/file.h"
#include "malha/text.h"
#include "tools/study/replays.h"

namespace malha::study {

namespace {

std::string csv_field(const Json& value) {
  if (value.is_null()) return "";
  const std::string text = value.is_string() ? value.get<std::string>() : value.dump();
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string field = "\"";
  for (const char letter : text) field += letter == '"' ? "\"\"" : std::string(1, letter);
  return field + "\"";
}

std::string chart_name(const Study& study, const Section& section) {
  return section.chart ? study.name + "_" + section.chart->name : "";
}

}  // namespace

std::string csv(const Json& rows) {
  std::vector<std::string> columns;
  for (const Json& row : rows)
    for (const auto& [key, value] : row.items())
      if (std::find(columns.begin(), columns.end(), key) == columns.end()) columns.push_back(key);
  std::ostringstream text;
  for (const std::string& column : columns) text << (&column == &columns[0] ? "" : ",") << csv_field(column);
  text << "\n";
  for (const Json& row : rows) {
    for (const std::string& column : columns)
      text << (&column == &columns[0] ? "" : ",") << (row.contains(column) ? csv_field(row[column]) : "");
    text << "\n";
  }
  return text.str();
}

Json to_json(const Study& study, const Findings& findings, bool quick, const std::string& command,
             const std::vector<Json>& builds) {
  Json json{{"study", study.name}, {"what", study.what}, {"quick", quick}, {"command", command}, {"build", builds[0]}};
  if (builds.size() > 1) json["machines"] = builds;
  json["sections"] = Json::array();
  for (const Section& section : findings.sections) {
    Json replays = Json::array();
    for (const Replay& replay : section.replays)
      replays.push_back({{"file", replay_file(study, replay)}, {"words", replay.description}});
    json["sections"].push_back({{"title", section.title},
                                {"sentences", section.sentences},
                                {"chart", chart_name(study, section)},
                                {"columns", section.table.columns},
                                {"rows", section.table.rows},
                                {"replays", replays}});
  }
  json["rows"] = findings.rows;
  return json;
}

std::string caption(const Json& json) {
  const Json& build = json.at("build");
  std::string made = maker(build);
  if (json.contains("machines")) {
    std::vector<std::string> machines;
    for (const Json& one : json["machines"])
      if (std::find(machines.begin(), machines.end(), machine(one)) == machines.end()) machines.push_back(machine(one));
    if (machines.size() > 3) machines[3] = "and others", machines.resize(4);  // as many as fit into a line
    made = "malha " + build.at("malha_version").get<std::string>() + "; " +
           counted(json["machines"].size(), "build or machine", "builds or machines") + ", which the rows name";
    for (const std::string& words : machines) made += "; " + words;
  }
  return made + "; " + json.at("command").get<std::string>();
}

std::string write_results(const std::filesystem::path& folder, const Study& study, const Findings& findings,
                          Json json) {
  std::string no_chart;
  for (std::size_t k = 0; k < findings.sections.size(); ++k) {
    const Section& section = findings.sections[k];
    if (!section.chart) continue;
    const std::string name = chart_name(study, section);
    const std::string why = bench::draw(section.chart->settings, section.chart->series, folder, name, caption(json));
    if (why.empty()) continue;
    no_chart = why;
    json["sections"][k]["chart"] = "";
  }
  write_whole(folder / (study.name + ".csv"), csv(findings.rows));
  write_whole(folder / (study.name + ".json"), json.dump(1) + "\n");
  return no_chart;
}

}  // namespace malha::study
