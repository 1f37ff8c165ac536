// SPDX-License-Identifier: Apache-2.0
#include "tools/study/page.h"

#include <sstream>

#include "host/base/file.h"
#include "tools/study/results.h"

namespace malha::study {

namespace {

constexpr const char* kStyle = R"(
body { font: 16px/1.5 sans-serif; max-width: 70rem; margin: 2rem auto; padding: 0 1rem; color: #222; }
table { border-collapse: collapse; font-size: 0.85rem; display: block; overflow-x: auto; }
th, td { padding: 0.15rem 0.6rem; border-bottom: 1px solid #ddd; text-align: right; white-space: nowrap; }
th:first-child, td:first-child { text-align: left; }
svg { width: 100%; height: auto; }
.made { color: #666; font-size: 0.85rem; }
@media print { section { break-inside: avoid; } details > * { display: block; } }
)";

std::string escaped(const std::string& text) {
  std::string html;
  for (const char letter : text)
    html += letter == '&'   ? "&amp;"
            : letter == '<' ? "&lt;"
            : letter == '>' ? "&gt;"
            : letter == '"' ? "&quot;"
                            : std::string(1, letter);
  return html;
}

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
}

std::string table(const Json& section) {
  if (section["rows"].empty()) return "";
  std::ostringstream html;
  html << "<details" << (section["rows"].size() <= 12 ? " open" : "")
       << "><summary>The numbers</summary>\n<table>\n<tr>";
  for (const auto& column : section["columns"]) html << "<th>" << escaped(column.get<std::string>()) << "</th>";
  html << "</tr>\n";
  for (const auto& row : section["rows"]) {
    html << "<tr>";
    for (const auto& field : row) html << "<td>" << escaped(field.get<std::string>()) << "</td>";
    html << "</tr>\n";
  }
  html << "</table></details>\n";
  return html.str();
}

/// Links to the replays that exist.
std::string links(const std::filesystem::path& folder, const Json& section) {
  std::string html;
  for (const Json& replay : section.value("replays", Json::array())) {
    const std::string file = replay["file"].get<std::string>();
    if (!std::filesystem::exists(folder / file)) continue;
    html += "<li><a href=\"" + file + "\">" + escaped(replay["words"].get<std::string>()) + "</a></li>\n";
  }
  return html.empty() ? "" : "<p>Replays, which play in the browser:</p>\n<ul>\n" + html + "</ul>\n";
}

void add_study(const std::filesystem::path& folder, const Json& json, std::ostringstream& html) {
  const std::string name = json["study"].get<std::string>();
  html << "<h2 id=\"" << name << "\">" << name << "</h2>\n<p>" << escaped(json["what"].get<std::string>())
       << ".</p>\n<p class=\"made\">" << escaped(caption(json)) << ". Rows: " << name << ".csv, " << name
       << ".json.</p>\n";
  for (const Json& section : json["sections"]) {
    html << "<section>\n<h3>" << escaped(section["title"].get<std::string>()) << "</h3>\n";
    if (!section["sentences"].empty()) {
      html << "<p>";
      for (const auto& sentence : section["sentences"]) html << escaped(sentence.get<std::string>()) << "\n";
      html << "</p>\n";
    }
    const std::string chart = section["chart"].get<std::string>();
    if (const auto file = folder / (chart + ".svg"); !chart.empty() && std::filesystem::exists(file))
      html << inline_svg(read_whole(file), chart) << "\n";
    html << links(folder, section) << table(section) << "</section>\n";
  }
}

/// True if to_json() wrote the file for this study; false for another file of that name.
bool is_of(const Json& json, const Study& study) {
  return json.is_object() && json.value("study", "") == study.name && json.contains("what") && json.contains("quick") &&
         json.contains("build") && json.contains("command") && json.contains("sections");
}

}  // namespace

std::string inline_svg(const std::string& file, const std::string& name) {
  std::string svg = file.substr(std::min(file.size(), file.find("<svg")));
  for (const char* quote : {"\"", "'"}) {
    replace_all(svg, std::string(" id=") + quote, std::string(" id=") + quote + name + "_");
    replace_all(svg, std::string("href=") + quote + "#", std::string("href=") + quote + "#" + name + "_");
  }
  replace_all(svg, "url(#", "url(#" + name + "_");
  // gnuplot's charts have a viewBox; without width and height the style decides the size.
  const std::size_t end = svg.find('>');
  for (const char* size : {" width=\"", " height=\""})
    if (const std::size_t at = svg.find(size); at < end)
      svg.erase(at, svg.find('"', at + std::string(size).size()) + 1 - at);
  return svg;
}

std::string page(const std::filesystem::path& folder) {
  std::ostringstream contents, body;
  for (const Study& study : studies()) {
    const auto file = folder / (study.name + ".json");
    if (!std::filesystem::exists(file)) continue;
    const Json json = Json::parse(read_whole(file), nullptr, false);
    if (!is_of(json, study)) continue;
    contents << "<li><a href=\"#" << study.name << "\">" << study.name << "</a>: " << escaped(study.what)
             << (json["quick"].get<bool>() ? " (quick version)" : "") << "</li>\n";
    add_study(folder, json, body);
  }
  return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>malha: studies</title><style>" +
         std::string(kStyle) + "</style></head><body>\n<h1>malha: studies</h1>\n<ul>\n" + contents.str() + "</ul>\n" +
         body.str() + "</body></html>\n";
}

}  // namespace malha::study
