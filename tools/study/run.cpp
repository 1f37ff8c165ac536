// SPDX-License-Identifier: Apache-2.0
#include "tools/study/run.h"

#include <algorithm>
#include <iostream>

#include "host/base/file.h"
#include "host/base/hash.h"
#include "malha/error.h"
#include "malha/text.h"
#include "tools/bench/facts.h"
#include "tools/study/page.h"
#include "tools/study/progress.h"
#include "tools/study/replays.h"
#include "tools/study/results.h"

namespace malha::study {

namespace {

/// A hash of the executable, which distinguishes builds of the same version.
std::string hash_of_this_program() {
  const std::string bytes = read_whole("/proc/self/exe");
  return hex(hash_bytes(bytes.data(), bytes.size()));
}

/// The hash of the program that wrote a journal; null if there is none.
Json program_of(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) return nullptr;
  const std::string bytes = read_whole(file);
  const Json head = Json::parse(bytes.substr(0, bytes.find('\n')), nullptr, false);
  return head.is_object() && head.contains("program") ? head["program"] : Json();
}

void print(const Study& study, const Findings& findings, const std::filesystem::path& out,
           const std::string& no_chart) {
  std::cout << study.name << ": " << study.what << "\n";
  for (const Section& section : findings.sections) {
    std::cout << "  " << section.title << "\n";
    for (const std::string& sentence : section.sentences) std::cout << "    " << sentence << "\n";
  }
  const std::string base = (out / study.name).string();
  std::cout << "rows        " << base << ".csv, " << base << ".json\n";
  if (no_chart.empty())
    std::cout << "charts      " << base << "_*.svg, .png\n";
  else
    std::cerr << "malha study: no chart: " << no_chart << "\n";
  for (const Section& section : findings.sections)
    for (const Replay& replay : section.replays)
      std::cout << "replay      " << (out / replay_file(study, replay)).string() << "\n";
}

/// Writes the results of a study and prints them.
void report(const Study& study, const Findings& findings, const std::filesystem::path& out, const Json& json,
            ProgressLine& progress, const std::atomic<bool>& stop) {
  write_replays(
      out, study, findings, [&](const std::string& what) { progress(study.name + " " + what, 1); }, stop);
  progress.clear();
  const std::string no_chart = write_results(out, study, findings, json);
  write_whole(out / "index.html", page(out));
  print(study, findings, out, no_chart);
}

/// The command of a study: "malha study accuracy --quick".
std::string command_of(const Study& study, const Options& options) {
  return "malha study " + study.name + (options.quick ? " --quick" : "") + options.on.command_options();
}

/// Measures the cells that the journal does not have; of a share only its own cells.
void measure(const Study& study, const Options& options, const std::filesystem::path& out, const Json& build,
             const std::atomic<bool>& stop) {
  const auto file = out / journal_name(study.name, options.quick, options.share);
  const Json kept = options.keep ? program_of(file) : Json();
  const Json program = kept.is_null() ? Json(hash_of_this_program()) : kept;
  const std::string name = study.name + (options.share ? " " + options.share->text() : "");
  ProgressLine progress(10);
  const auto show = [&](const std::string& cell, int done, int planned) {
    progress(name + " " + std::to_string(done) + "/" + std::to_string(planned) + " " + cell,
             planned > 0 ? static_cast<double>(done) / planned : 0);
  };
  Cells cells(file, journal_head(study.name, options.quick, build, program, options.share, options.on), options.quick,
              stop, show, options.share, options.on);
  const Findings findings = study.run(cells);
  if (!options.share)
    return report(study, findings, out,
                  to_json(study, findings, options.quick, command_of(study, options), std::vector<Json>(1, build)),
                  progress, stop);
  progress.clear();
  std::cout << "share       " << options.share->text() << " of " << study.name << ": "
            << counted(cells.kept() + cells.made(), "cell") << " in " << file.string() << "\n";
}

/// Prints the cells that no share has measured.
void print_missing(const Study& study, const Options& options, const Merged& merged, const Cells& cells) {
  constexpr std::size_t shown = 20;
  for (const auto& [number, keys] : cells.missing()) {
    const std::string share = Share{number, merged.shares}.text();
    std::cerr << "malha study: " << study.name << ": share " << share
              << (merged.given.contains(number) ? " lacks " : ", which has no journal, lacks ")
              << counted(keys.size(), "cell") << ": "
              << printable(listed(std::vector(keys.begin(), keys.begin() + std::min(keys.size(), shown)),
                                  [](const std::string& key) { return "\"" + key + "\""; }))
              << (keys.size() > shown ? " and others" : "") << "; to measure: " << command_of(study, options)
              << " --share " << share << "\n";
  }
}

/// Merges shares; measures nothing. Everything is checked before anything is written.
bool merge(const std::vector<const Study*>& chosen, const Options& options, const std::filesystem::path& out,
           const Json& build, const std::atomic<bool>& stop) {
  const std::string program = hash_of_this_program();
  struct Whole {
    Findings findings;
    Json json;
  };
  std::vector<Whole> all;
  bool lacking = false;
  for (const Study* study : chosen) {
    const Merged merged = merged_shares(
        options.merge, journal_head(study->name, options.quick, build, program, {}, options.on), options.keep);
    Cells cells(merged, options.quick, stop, options.on);
    const Findings findings = study->run(cells);
    print_missing(*study, options, merged, cells);
    lacking = lacking || !cells.missing().empty();
    const std::string command = command_of(*study, options) + " --merge, " + counted(merged.shares, "share");
    if (!lacking) all.push_back({findings, to_json(*study, findings, options.quick, command, merged.builds)});
  }
  if (lacking) return false;
  make_folder(out);
  check_writable(out / "index.html");
  ProgressLine progress(10);
  for (std::size_t k = 0; k < chosen.size(); ++k) report(*chosen[k], all[k].findings, out, all[k].json, progress, stop);
  return true;
}

}  // namespace

bool run(const Options& options, const std::atomic<bool>& stop) {
  const std::filesystem::path out = !options.out.empty() ? options.out
                                    : options.quick      ? "out/study_quick"
                                                         : "out/study";
  std::vector<const Study*> chosen;
  for (const Study& study : studies())
    if (study.run && std::find(options.names.begin(), options.names.end(), study.name) != options.names.end())
      chosen.push_back(&study);
  if (chosen.empty()) return true;
  for (const Study* study : chosen)
    if (!study->any_backend && !options.on.command_options().empty())
      malha::refuse("malha study " + study->name, "", "\"" + options.on.command_options().substr(1) + "\"",
                    "accuracy and scaling, which run on any backend; the others run on the host");
  if (options.merge.empty()) options.on.require_device();
  const Json build = bench::build_facts();
  if (!options.merge.empty()) {
    if (!merge(chosen, options, out, build, stop)) return false;
  } else {
    make_folder(out);
    if (!options.share) check_writable(out / "index.html");
    for (const Study* study : chosen) measure(*study, options, out, build, stop);
  }
  if (!options.share) std::cout << "page        " << (out / "index.html").string() << "\n";
  return true;
}

}  // namespace malha::study
