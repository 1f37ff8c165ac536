#include "tools/study/results.h"

#include <algorithm>
#include <sstream>

#include "host/base/file.h"
#include "host/base/text.h"
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

Json to_json(const Study& study, const Findings& findings, bool quick, const std::string& command, const Json& build) {
  Json json{{"study", study.name}, {"what", study.what}, {"quick", quick}, {"command", command}, {"build", build}};
  json["sections"] = Json::array();
  for (const Section& section : findings.sections) {
    Json replays = Json::array();
    for (const Replay& replay : section.replays)
      replays.push_back({{"file", replay_file(study, replay)}, {"words", replay.words}});
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

std::string caption(const Json& build, const std::string& command) {
  const auto fact = [&build](const char* key) { return build.at(key).get<std::string>(); };
  std::string flags, flag;  // those that a reader asks for; NAME.json has all
  for (std::istringstream words(fact("flags")); words >> flag;)
    if (flag.starts_with("-O") || flag.starts_with("-march") || flag.starts_with("-fsan")) flags += " " + flag;
  return "malha " + fact("malha_version") + ", " + fact("compiler") + flags + ", " + fact("instructions") + "; " +
         fact("cpu") + ", " + counted(build.at("cores").get<int>(), "core") + "; " + command;
}

std::string write_results(const std::filesystem::path& folder, const Study& study, const Findings& findings, Json json,
                          const std::string& caption) {
  std::string no_chart;
  for (std::size_t k = 0; k < findings.sections.size(); ++k) {
    const Section& section = findings.sections[k];
    if (!section.chart) continue;
    const std::string name = chart_name(study, section);
    const std::string why = bench::draw(section.chart->settings, section.chart->series, folder, name, caption);
    if (why.empty()) continue;
    no_chart = why;
    json["sections"][k]["chart"] = "";
  }
  write_whole(folder / (study.name + ".csv"), csv(findings.rows));
  write_whole(folder / (study.name + ".json"), json.dump(1) + "\n");
  return no_chart;
}

}  // namespace malha::study
