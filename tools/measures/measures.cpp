// What malha_measures has and the command has not.
#include "tools/measures.h"

#include <iostream>

#include "tools/measures/arguments_bench.h"
#include "tools/measures/arguments_study.h"
#include "tools/measures/arguments_tune.h"
#include "tools/measures/tune.h"
#include "tools/validators.h"

namespace malha {

std::optional<int> hand_over_or_refuse(int argc, char** argv) {
  const std::string first = argv[1], second = argc > 2 ? argv[2] : "";
  const std::string answer = first == "bench"   ? refused_benchmark(second)
                             : first == "study" ? refused_study(second)
                                                : "";
  if (answer.empty()) return std::nullopt;
  std::cerr << answer << "\n";
  return kBadInput;
}

void add_measures(CLI::App& app, Arguments& arguments) {
  CLI::App* tune = add_tune(app, arguments.tune);
  add_scene(*tune, arguments);
  tune->add_option("--out", arguments.out, "The tuned scene; out/NAME-OF-THE-SCENE-FILE_tuned.json if not given")
      ->check(some_path())
      ->type_name("FILE");
  tune->add_option("--threads", arguments.threads, "Threads; as many as there are cores if not given")
      ->check(whole_number(1, 1024))
      ->type_name("N");
  add_bench(app, arguments.bench);
  add_study(app, arguments.study);
}

int measure(const Arguments& arguments, const std::atomic<bool>& stop) {
  if (arguments.command == Command::Tune) return tune(arguments, stop);
  if (arguments.command == Command::Bench)
    arguments.bench.run();
  else
    study::run(arguments.study, stop);
  return kDone;
}

}  // namespace malha
