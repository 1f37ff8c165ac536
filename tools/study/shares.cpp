// SPDX-License-Identifier: Apache-2.0
#include "tools/study/shares.h"

#include <algorithm>
#include <charconv>
#include <regex>
#include <sstream>

#include "host/base/file.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha::study {

namespace {

namespace fs = std::filesystem;

constexpr const char* kEnding = ".cells.jsonl";
constexpr const char* kHead = "the head of a share's journal";

std::string text_of(const Json& head, const char* key) {
  const Json& text = head.at(key);
  return text.is_string() ? text.get<std::string>() : text.dump();
}

std::string name_of(const Json& head) {
  return (head.at("quick").get<bool>() ? "the quick " : "") + text_of(head, "study");
}

/// The journals of shares in a folder, sorted by the number of the share.
std::vector<fs::path> journals_of(const fs::path& folder, const Json& expected) {
  const std::string study = text_of(expected, "study");
  const std::regex form(study + R"(\.(\d{1,6})of\d{1,6})" + (expected.at("quick").get<bool>() ? R"(\.quick)" : "") +
                        R"(\.cells\.jsonl)");
  std::vector<std::pair<int, fs::path>> found;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (std::smatch parts; std::regex_match(name, parts, form)) found.push_back({std::stoi(parts[1]), entry.path()});
  }
  if (found.empty())
    refuse(folder.string(), "", error ? error.message() : "no journal of a share of " + name_of(expected),
           "a folder in which malha study " + study + " --share leaves its " +
               journal_name(study, expected.at("quick").get<bool>(), Share{1, 2}));
  std::sort(found.begin(), found.end());
  std::vector<fs::path> paths;
  for (auto& [number, path] : found) paths.push_back(std::move(path));
  return paths;
}

/// Reads a journal line by line, with line numbers for messages.
class Reader {
 public:
  Reader(const fs::path& file, const Json& expected)
      : file_(file.string()), text_(read_input(file, "a file that can be read")), expected_(expected) {}

  /// The next line; empty at the end.
  std::optional<Json> next() {
    if (at_ == text_.size()) return {};
    ++line_;
    const std::size_t end = text_.find('\n', at_);
    Json json = end == std::string::npos ? Json(Json::value_t::discarded)
                                         : Json::parse(text_.substr(at_, end - at_), nullptr, false);
    if (json.is_discarded())
      refuse("a torn line",
             "complete lines of JSON; its command resumes the share there, or starts anew without this file");
    at_ = end + 1;
    return json;
  }

  /// The first line. Refuses a journal whose cells are not comparable with those of `expected`.
  Json head(bool keep) {
    const std::optional<Json> line = next();
    const Json head = line ? *line : Json();
    for (const char* key : {"study", "quick", "build", "program", "share"})
      if (!head.is_object() || !head.contains(key)) refuse(line ? "no " + malha::quoted(key) : "nothing", kHead);
    for (const auto& fact : expected_.at("build").items())
      if (!head["build"].contains(fact.key())) refuse("no " + malha::quoted(fact.key()), kHead);
    for (const char* key : {"study", "quick"}) same(key, head.at(key), expected_.at(key), "");
    same("on", head.value("on", ""), expected_.value("on", ""), "");
    same("malha", head.at("build").at("malha_version"), expected_.at("build").at("malha_version"), ", as this program");
    if (!keep)
      same("program", head.at("program"), expected_.at("program"), ", this one; or --keep, which takes other builds");
    return head;
  }

  [[noreturn]] void refuse(const std::string& found, const std::string& allowed) const {
    malha::refuse(file_, place(), found, allowed);
  }
  std::string place() const { return "line " + std::to_string(line_); }

 private:
  void same(const char* key, const Json& found, const Json& allowed, const std::string& text) const {
    if (found != allowed) refuse(std::string(key) + " " + found.dump(), allowed.dump() + text);
  }

  std::string file_, text_;
  const Json& expected_;
  std::size_t at_ = 0;
  int line_ = 0;
};

/// Stores the machine that measured a cell in the cell, or in each of its parts.
void name_machine(Json& cell, const std::string& machine) {
  if (cell.is_object()) cell["machine"] = machine;
  if (cell.is_array())
    for (Json& part : cell)
      if (part.is_object()) part["machine"] = machine;
}

}  // namespace

std::optional<Share> share_of(const std::string& text) {
  Share share;
  const char* const end = text.data() + text.size();
  const auto [slash, first] = std::from_chars(text.data(), end, share.i);
  if (first != std::errc{} || slash == end || *slash != '/') return {};
  const auto [rest, second] = std::from_chars(slash + 1, end, share.n);
  if (second != std::errc{} || rest != end || share.i < 1 || share.i > share.n || share.n > kMostShares) return {};
  return share;
}

std::string journal_name(const std::string& study, bool quick, const std::optional<Share>& share) {
  return study + (share ? "." + std::to_string(share->i) + "of" + std::to_string(share->n) : "") +
         (quick ? ".quick" : "") + kEnding;
}

Json journal_head(const std::string& study, bool quick, const Json& build, const Json& program,
                  const std::optional<Share>& share, const bench::RunsOn& on) {
  Json head{{"study", study}, {"quick", quick}, {"build", build}, {"program", program}};
  if (const std::string text = on.command_options(); !text.empty()) head["on"] = text;
  if (share) head["share"] = share->text();
  return head;
}

Merged merged_shares(const std::vector<fs::path>& folders, const Json& expected, bool keep) {
  std::set<fs::path> known;
  for (const fs::path& folder : folders)
    if (!known.insert(fs::weakly_canonical(folder)).second)
      refuse("malha study", "--merge", "'" + folder.string() + "' twice", "each folder once");
  Merged merged;
  struct CellSource {
    std::string text;
    std::size_t machine;
  };
  std::map<std::string, CellSource> sources;
  for (const fs::path& folder : folders)
    for (const fs::path& file : journals_of(folder, expected)) {
      Reader reader(file, expected);
      const Json head = reader.head(keep);
      const std::optional<Share> share = share_of(text_of(head, "share"));
      if (!share) reader.refuse("the share " + head["share"].dump(), "such as 1/3");
      if (merged.given.empty()) merged.shares = share->n;
      if (share->n != merged.shares)
        reader.refuse("share " + share->text(),
                      "shares of " + std::to_string(merged.shares) + ", as in " + merged.found_in[0]);
      merged.given.insert(share->i);
      Json build = head["build"];
      build["program"] = head["program"];
      const auto at = std::find(merged.builds.begin(), merged.builds.end(), build);
      const auto machine = static_cast<std::size_t>(at - merged.builds.begin());
      if (at == merged.builds.end()) merged.builds.push_back(build), merged.found_in.push_back(file.string());
      while (const std::optional<Json> line = reader.next()) {
        if (!line->is_object() || !line->contains("key") || !line->contains("value"))
          reader.refuse("no cell", "a key and its value");
        const std::string key = text_of(*line, "key");
        const auto [before, fresh] = sources.insert({key, {file.string() + ", " + reader.place(), machine}});
        if (fresh)
          merged.cells[key] = line->at("value");  // the first of equal ones
        else if (merged.cells[key] != line->at("value"))
          reader.refuse(malha::quoted(key) + ", measured again with another result than in " + before->second.text,
                        "one journal of each share");
      }
    }
  if (merged.builds.size() > 1)
    for (auto& [key, cell] : merged.cells) {
      const Json& build = merged.builds[sources.at(key).machine];
      name_machine(cell, maker(build) + "; program " + text_of(build, "program"));
    }
  return merged;
}

int Merged::cores() const {
  const int cores = builds[0].at("cores").get<int>();
  for (std::size_t k = 1; k < builds.size(); ++k)
    if (builds[k].at("cores").get<int>() != cores)
      refuse(found_in[k], "line 1", counted(builds[k].at("cores").get<int>(), "core"),
             std::to_string(cores) + ", as in " + found_in[0] + ": this study measures by the number of cores");
  return cores;
}

std::string maker(const Json& build) {
  std::string flags, flag;  // the relevant ones; NAME.json has all
  for (std::istringstream text(text_of(build, "flags")); text >> flag;)
    if (flag.starts_with("-O") || flag.starts_with("-march") || flag.starts_with("-fsan")) flags += " " + flag;
  return "malha " + text_of(build, "malha_version") + ", " + text_of(build, "compiler") + flags + ", " +
         text_of(build, "instructions") + "; " + machine(build);
}

std::string machine(const Json& build) {
  return text_of(build, "cpu") + ", " + counted(build.at("cores").get<int>(), "core");
}

}  // namespace malha::study
