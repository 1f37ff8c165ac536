// SPDX-License-Identifier: Apache-2.0
// The program malha_measures' implementation of tools/measures.h: tune, bench and study.
#include "tools/measures.h"

#include <filesystem>
#include <functional>
#include <iostream>

#include "host/base/file.h"
#include "kernels/parallel/compute.h"
#include "malha/error.h"
#include "malha/scene.h"
#include "malha/text.h"
#include "tools/arguments.h"
#include "tools/bench/output.h"
#include "tools/tune/progress_line.h"
#include "tools/tune/report.h"

namespace malha {

namespace {

namespace fs = std::filesystem;

/// Prints the trials and writes the tuned scene; returns the exit status. If it throws, nothing is written.
int tune(const Arguments& arguments, const std::atomic<bool>& stop) {
  const Scene scene = load_scene(arguments.scene);
  tuning::check_tunable(scene);
  const fs::path out = !arguments.out.empty() ? arguments.out : "out/" + arguments.scene_name() + "_tuned.json";
  const fs::path json = arguments.tune.json;
  if (json.lexically_normal() == out.lexically_normal())
    refuse("malha tune", "--json", "'" + json.string() + "', which is to be the tuned scene", "another file");
  bench::require_writable(out);
  if (!json.empty()) bench::require_writable(json);
  const tuning::TuneOptions options{arguments.tune.error, arguments.tune.seconds,
                                    arguments.threads > 0 ? arguments.threads : available_threads()};
  tuning::ProgressLine progress(5);
  const tuning::TuneResult tuned = tuning::tune(scene, options, std::ref(progress), stop);
  progress.clear();
  std::cout << tuning::tune_table(tuned, options);
  if (!tuned.best) {
    std::cerr << printable(arguments.scene_label()) << ": " << tuning::why_not_tuned(tuned, options) << "\n";
    return kUnmet;
  }
  write_whole(out, to_json(tuned.trials[*tuned.best].scene));
  std::cout << "scene       " << printable(out.string()) << "\n";
  if (json.empty()) return kDone;
  write_whole(json, tuning::tune_json(tuned, options).dump(2) + "\n");
  std::cout << "trials      " << printable(json.string()) << "\n";
  return kDone;
}

}  // namespace

std::optional<int> exec_or_refuse(int argc, char** argv) {
  const std::string first = argv[1];
  const char* second = argc > 2 && *argv[2] ? argv[2] : nullptr;
  const std::string answer = first == "bench"   ? refused_benchmark(second)
                             : first == "study" ? refused_study(second)
                                                : "";
  if (answer.empty()) return std::nullopt;
  std::cerr << answer << "\n";
  return kBadInput;
}

void add_measures(CLI::App& app, Arguments& arguments) {
  add_tune(app, arguments);
  add_bench(app, arguments.bench);
  add_study(app, arguments.study);
}

int measure(const Arguments& arguments, const std::atomic<bool>& stop) {
  if (arguments.command == "tune") return tune(arguments, stop);
  if (arguments.command == "bench") {
    arguments.bench.run();
    return kDone;
  }
  return exec_study(arguments.study);
}

}  // namespace malha
