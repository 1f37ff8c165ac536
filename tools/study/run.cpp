#include "tools/study/run.h"

#include <algorithm>
#include <iostream>

#include "host/base/file.h"
#include "host/base/hash.h"
#include "host/base/text.h"
#include "tools/bench/facts.h"
#include "tools/study/page.h"
#include "tools/study/progress.h"
#include "tools/study/replays.h"
#include "tools/study/results.h"

namespace malha::study {

namespace {

/// Tells builds of the same version apart.
std::string hash_of_this_program() {
  const std::string bytes = read_whole("/proc/self/exe");
  return hex(hash_bytes(bytes.data(), bytes.size()));
}

/// The program that made the cells of a file; null where there is none.
Json program_of(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) return nullptr;
  const std::string bytes = read_whole(file);
  const Json head = Json::parse(bytes.substr(0, bytes.find('\n')), nullptr, false);
  return head.is_object() && head.contains("program") ? head["program"] : Json();
}

/// What makes the cells of one run comparable with those of another.
Json head_of(const std::filesystem::path& file, const Study& study, const Options& options, const Json& build) {
  const Json kept = options.keep ? program_of(file) : Json();
  return {{"study", study.name},
          {"quick", options.quick},
          {"build", build},
          {"program", kept.is_null() ? Json(hash_of_this_program()) : kept}};
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

}  // namespace

void run(const Options& options, const std::atomic<bool>& stop) {
  const std::filesystem::path out = !options.out.empty() ? options.out
                                    : options.quick      ? "out/study_quick"
                                                         : "out/study";
  make_folder(out);
  check_writable(out / "index.html");
  const Json build = bench::build_facts();
  for (const Study& study : studies()) {
    if (std::find(options.names.begin(), options.names.end(), study.name) == options.names.end()) continue;
    const auto file = out / (study.name + (options.quick ? ".quick" : "") + ".cells.jsonl");
    ProgressLine progress(10);
    const auto show = [&](const std::string& cell, int done, int planned) {
      progress(study.name + " " + std::to_string(done) + "/" + std::to_string(planned) + " " + cell,
               planned > 0 ? static_cast<double>(done) / planned : 0);
    };
    Cells cells(file, head_of(file, study, options, build), options.quick, stop, show);
    const Findings findings = study.run(cells);
    write_replays(
        out, study, findings, [&](const std::string& what) { progress(study.name + " " + what, 1); }, stop);
    progress.clear();
    const std::string command = "malha study " + study.name + (options.quick ? " --quick" : "");
    const std::string no_chart = write_results(
        out, study, findings, to_json(study, findings, options.quick, command, build), caption(build, command));
    write_whole(out / "index.html", page(out));
    print(study, findings, out, no_chart);
  }
  std::cout << "page        " << (out / "index.html").string() << "\n";
}

}  // namespace malha::study
