// SPDX-License-Identifier: Apache-2.0
// The malha command: run, plan and check scenes, benchmarks and studies.
#include <atomic>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <map>
#include <new>

#include "host/base/memory_size.h"
#include "host/model/model.h"
#include "host/output/page.h"
#include "host/report/amplification.h"
#include "host/report/device_estimate.h"
#include "host/report/plan.h"
#include "host/report/warnings.h"
#include "host/report/whole_steps.h"
#include "host/run/redraw.h"
#include "host/run/run.h"
#include "host/run/summary.h"
#include "malha/fabrics.h"
#include "malha/text.h"
#include "tools/arguments.h"
#include "tools/measures.h"
#include "tools/progress.h"
#include "tools/streams.h"
#include "tools/tune/interrupted.h"

namespace {

using malha::Arguments;

std::atomic<bool> stop{false};
volatile std::sig_atomic_t stopped_by = 0;

void on_signal(int signal) {
  stop = true;
  stopped_by = signal;
  std::signal(signal, SIG_DFL);  // a second signal ends the run at once
}

/// Leaves a signal ignored if it was, as Ctrl-C is for background jobs of a shell.
void catch_signal(int signal) {
  if (std::signal(signal, on_signal) == SIG_IGN) std::signal(signal, SIG_IGN);
}

void catch_signals() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) catch_signal(signal);
}

malha::SimulationOptions simulation_options(const Arguments& arguments, malha::ProgressReporter& progress) {
  malha::SimulationOptions options;
  options.threads = arguments.threads, options.adaptive_threads = true;
  options.backend = malha::backend_named(arguments.backend);
  if (!arguments.machine.empty()) options.machine = arguments.machine;
  options.progress = [&progress](const char* what, double part) { progress.setup(what, part); };
  return options;
}

/// Loads the scene and applies the options of the command line.
malha::Scene load(const Arguments& arguments) {
  malha::Scene scene = malha::load_scene(arguments.scene);
  malha::OutputSpec& outputs = scene.outputs;
  if (!arguments.formats.empty()) {
    outputs.formats = arguments.formats;
    if (outputs.every == 0) outputs.every = 1;
  }
  if (arguments.every) {
    outputs.every = *arguments.every;
    if (outputs.formats.empty()) outputs.formats = {"vtp"};
  }
  if (arguments.checkpoint_every) outputs.checkpoint_every = *arguments.checkpoint_every;
  if (arguments.picture_every) outputs.picture_every = *arguments.picture_every;
  if ((arguments.picture || arguments.picture_every) && !outputs.picture) outputs.picture.emplace();
  if (arguments.no_picture) outputs.picture.reset();
  if (arguments.page && !outputs.page) outputs.page.emplace();
  if (arguments.no_page) outputs.page.reset();
  return scene;
}

std::optional<std::int64_t> last_step(const Arguments& arguments, const malha::Scene& scene) {
  if (!arguments.seconds) return arguments.steps;
  const double steps = *arguments.seconds / scene.solver.dt;
  if (steps > malha::kMostSteps)
    malha::refuse(
        "malha run", "--seconds", malha::shown(*arguments.seconds),
        "at most " + malha::shown(malha::kMostSteps * scene.solver.dt) + " s, which are 1e9 steps of this scene");
  return malha::whole_steps(*arguments.seconds, scene.solver.dt);
}

int run(const Arguments& arguments) {
  const malha::Scene scene = load(arguments);
  malha::RunOptions options;
  options.out = arguments.out.empty() ? "out/" + arguments.scene_name() : arguments.out;
  options.steps = last_step(arguments, scene);
  if (arguments.seconds) options.rounding = malha::rounding_of("--seconds", *arguments.seconds, scene.solver.dt);
  options.resume = arguments.resume;
  options.ready =
      catch_signals;  // before set-up is done there is nothing to save, and a signal ends the command at once
  malha::RunResult result;
  try {
    malha::ProgressReporter progress(arguments.quiet);
    options.warn = [&](const std::string& line) { progress.warn(arguments.scene_label(), line); };
    options.on_activity = [&progress](const char* what) { progress.show_activity(what); };
    result = malha::run(
        scene, simulation_options(arguments, progress), options, [&progress](const auto& now) { progress(now); }, stop);
  } catch (const malha::Diverged&) {
    if (!arguments.quiet) std::cout << malha::list_results(malha::Results(options.out));
    throw;
  }
  if (!arguments.quiet)
    std::cout << malha::printable_lines(result.summary) << malha::list_results(malha::Results(options.out));
  for (const std::string& line : result.failed_expectations)
    std::cerr << malha::printable(arguments.scene_label()) << ": not as expected: " << malha::printable(line) << "\n";
  if (result.interrupted) std::cerr << "interrupted; go on with: " << arguments.typed << " --resume\n";
  if (result.pictures_missing)
    std::cerr << "pictures are left out; draw them with: malha picture " << malha::shell_word(options.out) << "\n";
  if (result.interrupted || result.pictures_missing) return 128 + stopped_by;
  return result.failed_expectations.empty() ? malha::kDone : malha::kUnmet;
}

int picture(const Arguments& arguments) {
  const std::string missing = malha::redraw(arguments.out, arguments.threads);
  std::cout << malha::list_results(malha::Results(arguments.out)) << (missing.empty() ? "" : missing + "\n");
  return malha::kDone;
}

int page(const Arguments& arguments) {
  const std::string path = arguments.out.empty() ? "compare.html" : arguments.out;
  malha::write_comparison(arguments.runs[0], arguments.runs[1], path);
  std::cout << "replay      " << malha::printable(path) << " (open it in a browser)\n";
  return malha::kDone;
}

int plan(const Arguments& arguments) {
  std::optional<malha::Simulation> simulation;
  {
    malha::ProgressReporter progress(arguments.quiet);
    simulation.emplace(load(arguments), simulation_options(arguments, progress));
    for (const std::string& line : malha::warnings(simulation->model())) progress.warn(arguments.scene_label(), line);
  }
  simulation->step();
  const malha::Model& model = simulation->model();
  const auto amplifications =
      malha::measure_amplifications(model, malha::amplification_steps_of_plan(model), simulation->threads());
  for (const std::string& line : malha::growth_warnings(model, amplifications))
    malha::ProgressReporter(arguments.quiet).warn(arguments.scene_label(), line);
  std::optional<malha::DeviceEstimate> estimate;
  if (!arguments.machine.empty())
    estimate = malha::estimate_device(*simulation, malha::machine_named(arguments.machine));
  const malha::DeviceEstimate* on_machine = estimate ? &*estimate : nullptr;
  std::cout << (arguments.json ? malha::plan_json(*simulation, on_machine, &amplifications)
                               : malha::printable_lines(malha::plan(*simulation, on_machine, &amplifications)));
  return malha::kDone;
}

int check(const Arguments& arguments) {
  // It does all that run and plan do before the first step, so that it refuses the same scenes.
  const malha::Simulation simulation(malha::load_scene(arguments.scene));
  malha::check_frames(simulation,
                      malha::whole_steps(simulation.model().scene.duration, simulation.model().scene.solver.dt));
  const malha::Model& model = simulation.model();
  std::cout << malha::printable(arguments.scene_label()) << ": ok: " << malha::counted(model.count(), "particle")
            << " in " << malha::counted(model.scene.bodies.size(), "body", "bodies");
  if (model.zero_area_faces > 0)
    std::cout << "; left out: " << malha::counted(model.zero_area_faces, "face") << " without area";
  std::cout << "\n";
  for (const std::string& note : malha::warnings(model))
    std::cout << malha::printable(arguments.scene_label() + ": " + note) << "\n";
  return malha::kDone;
}

int materials(const Arguments&) {
  std::cout << malha::fabric_table();
  return malha::kDone;
}

/// tune, bench and study.
int measure(const Arguments& arguments) {
  if (arguments.command == "tune") catch_signals();
  try {
    return malha::measure(arguments, stop);
  } catch (const malha::tuning::Interrupted&) {
    std::cerr << "interrupted; nothing was written\n";
    return 128 + stopped_by;
  }
}

int dispatch(const Arguments& arguments) {
  static const std::map<std::string, int (*)(const Arguments&)> commands{
      {"run", run},      {"picture", picture}, {"page", page},     {"plan", plan},          {"check", check},
      {"tune", measure}, {"bench", measure},   {"study", measure}, {"materials", materials}};
  return commands.at(arguments.command)(arguments);
}

}  // namespace

int main(int argc, char** argv) {
  malha::ignore_closed_streams();
  Arguments arguments;
  std::string scene = "malha";
  const auto say = [](const std::string& line) { std::cerr << malha::printable(line) << "\n"; };
  try {
    std::optional<int> status = malha::parse_arguments(argc, argv, arguments);
    if (!arguments.scene.empty()) scene = arguments.scene_label();
    if (!status) status = dispatch(arguments);
    malha::require_written();
    return *status;
  } catch (const malha::OutOfMemory& error) {
    say(error.what());
    return malha::kOutOfMemory;
  } catch (const malha::InputError& error) {
    std::cerr << malha::printable_lines(error.what()) << "\n";  // one line for each error
    return malha::kBadInput;
  } catch (const malha::Diverged& error) {
    say(scene + ": diverged at " + error.what());
    return malha::kDiverged;
  } catch (const std::bad_alloc&) {
    try {
      say(scene + ": found no more memory, of which " + malha::in_gib(double(malha::available_memory())) +
          " are free now; allowed: what fits into it");
    } catch (const std::bad_alloc&) {
      std::fputs("malha: found no more memory, not even for a message; allowed: what fits into it\n", stderr);
    }
    return malha::kOutOfMemory;
  } catch (const std::exception& error) {
    say(std::string("malha: ") + error.what());
    return malha::kFailed;
  }
}
