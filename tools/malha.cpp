// The malha command: run, plan and check scenes.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <iostream>

#include "host/build_info.h"
#include "host/model.h"
#include "host/plan.h"
#include "host/run.h"
#include "tools/progress.h"

namespace {

// What the command's exit status says.
enum Status { kDone = 0, kUnmet = 1, kBadInput = 2, kDiverged = 3, kFailed = 4, kInterrupted = 130 };

std::atomic<bool> stop{false};
void on_interrupt(int) {
  stop = true;
  std::signal(SIGINT, SIG_DFL);  // a second Ctrl-C ends at once
}

struct Arguments {
  std::string scene, out, backend = "openmp";
  int threads = 0, every = 0, picture = -1;
  std::int64_t steps = 0;
  double seconds = 0;
  std::vector<std::string> formats;
  bool quiet = false, resume = false;
};

malha::SimulationOptions simulation_options(const Arguments& arguments) {
  return {arguments.threads, arguments.backend == "serial" ? malha::Backend::Serial : malha::Backend::OpenMP};
}

/// The scene with what the command line says instead.
malha::Scene load(const Arguments& arguments) {
  malha::Scene scene = malha::load_scene(arguments.scene);
  if (arguments.seconds > 0) scene.duration = arguments.seconds;
  malha::OutputSpec& outputs = scene.outputs;
  if (!arguments.formats.empty()) {
    outputs.formats = arguments.formats;
    if (outputs.every == 0) outputs.every = 1;
  }
  if (arguments.every > 0) {
    outputs.every = arguments.every;
    if (outputs.formats.empty()) outputs.formats = {"vtp"};
  }
  if (arguments.picture >= 0) {
    if (!outputs.picture) outputs.picture.emplace();
    outputs.picture_every = arguments.picture;
  }
  return scene;
}

int run(const Arguments& arguments) {
  const malha::Scene scene = load(arguments);
  malha::RunOptions options;
  options.out = arguments.out.empty() ? "out/" + std::filesystem::path(arguments.scene).stem().string() : arguments.out;
  if (arguments.steps > 0) options.steps = arguments.steps;
  options.resume = arguments.resume;
  std::signal(SIGINT, on_interrupt);
  std::signal(SIGTERM, on_interrupt);
  const malha::RunResult result =
      malha::run(scene, simulation_options(arguments), options, malha::ProgressReporter(arguments.quiet), stop);
  if (!arguments.quiet) std::cout << "results in " << options.out << "\n";
  for (const std::string& line : result.unmet) std::cerr << arguments.scene << ": not as expected: " << line << "\n";
  if (result.interrupted && stop) {
    std::cerr << "interrupted; go on with: malha run " << arguments.scene << " --out " << options.out << " --resume\n";
    return kInterrupted;
  }
  return result.unmet.empty() ? kDone : kUnmet;
}

int plan(const Arguments& arguments) {
  std::cout << malha::plan(malha::Simulation(load(arguments), simulation_options(arguments)));
  return kDone;
}

int check(const Arguments& arguments) {
  const malha::Model model = malha::build_model(malha::load_scene(arguments.scene));
  std::cout << arguments.scene << ": ok, " << model.count() << " particles\n";
  return kDone;
}

void add_run_options(CLI::App& command, Arguments& arguments) {
  command.add_option("--out", arguments.out, "Folder of the results (default: out/SCENE)");
  command.add_option("--steps", arguments.steps, "Stop at this step instead of after the scene's duration")
      ->check(CLI::PositiveNumber);
  command.add_option("--seconds", arguments.seconds, "Duration in simulated seconds instead of the scene's")
      ->check(CLI::PositiveNumber);
  command.add_option("--every", arguments.every, "Steps between frames")->check(CLI::PositiveNumber);
  command.add_option("--format", arguments.formats, "Frames as vtp, pc2, ply, obj; several with commas")
      ->delimiter(',')
      ->check(CLI::IsMember({"vtp", "pc2", "ply", "obj"}));
  command
      .add_option("--picture", arguments.picture,
                  "Ray-traced pictures: of the end and a storyboard; with a number also one every so many steps")
      ->expected(0, 1)
      ->default_str("0")
      ->check(CLI::NonNegativeNumber);
  command.add_flag("--resume", arguments.resume, "Continue from the checkpoint in the folder, with the very same bits");
  command.add_flag("--quiet", arguments.quiet, "No progress");
}

void add_common_options(CLI::App& command, Arguments& arguments) {
  command.add_option("scene", arguments.scene, "Scene file (JSON, see scenes/schema.json)")->required();
  command.add_option("--threads", arguments.threads, "Threads (default: as many as OpenMP offers); same bits on any")
      ->check(CLI::Range(1, 1024));
  command.add_option("--backend", arguments.backend, "openmp or serial; same bits on both")
      ->check(CLI::IsMember({"openmp", "serial"}));
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"malha: deformable bodies in real time. Position Based Dynamics in coloured, data-parallel batches."};
  app.set_version_flag("--version", std::string("malha ") + malha::version());
  app.require_subcommand(1);
  app.footer(
      "Exit status: 0 done, 1 done but not as the scene expects, 2 bad input, 3 diverged, 4 failed (disk),\n"
      "130 interrupted (a checkpoint is left; see run --resume).");
  Arguments arguments;
  CLI::App* run_command = app.add_subcommand("run", "Run a scene; report, frames and pictures go to a folder");
  add_common_options(*run_command, arguments);
  add_run_options(*run_command, arguments);
  CLI::App* plan_command = app.add_subcommand("plan", "Say what would run: sizes, colours, passes, memory");
  add_common_options(*plan_command, arguments);
  CLI::App* check_command = app.add_subcommand("check", "Validate a scene and its meshes, run nothing");
  check_command->add_option("scene", arguments.scene, "Scene file")->required();

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kBadInput;
  }
  try {
    if (*run_command) return run(arguments);
    return *plan_command ? plan(arguments) : check(arguments);
  } catch (const malha::InputError& error) {
    std::cerr << error.what() << "\n";
    return kBadInput;
  } catch (const malha::Diverged& error) {
    std::cerr << arguments.scene << ": diverged at " << error.what() << "\n";
    return kDiverged;
  } catch (const std::exception& error) {
    std::cerr << "malha: " << error.what() << "\n";
    return kFailed;
  }
}
