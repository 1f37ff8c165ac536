// SPDX-License-Identifier: Apache-2.0
#include "tools/arguments.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>

#include "host/base/build_info.h"
#include "host/base/spelling_suggestion.h"
#include "host/model/machine.h"
#include "host/run/run.h"
#include "malha/scene.h"
#include "malha/text.h"
#include "tools/completion.h"
#include "tools/measures.h"
#include "tools/validators.h"

namespace malha {

namespace {

const std::vector<std::string> kFirstWords{"run",  "view",  "picture", "page",   "plan", "check",    "materials",
                                           "tune", "bench", "study",   "--help", "-h",   "--version"};

/// Formats an option as its name and the type of its value; its help text says what it excludes.
struct Formatter : CLI::Formatter {
  std::string make_option_opts(const CLI::Option* option) const override {
    return option->get_type_name().empty() ? "" : " " + option->get_type_name();
  }
};

void add_executor(CLI::App& command, Arguments& arguments) {
  add_threads(command, arguments.threads,
              "Largest number of threads, the cores if not given; steps run on one while that is faster");
  add_backend(command, arguments.backend, arguments.machine);
}

void add_results(CLI::App& command, Arguments& arguments) {
  const auto most = std::int64_t(kMostSteps);
  add_checked(command, "--out", arguments.out, some_path(), "FOLDER",
              "Folder of the results; out/NAME-OF-THE-SCENE-FILE if not given");
  CLI::Option* steps = add_checked(command, "--steps", arguments.steps, whole_number(1, most), "N",
                                   "Stop at step N, instead of at the end of the scene's duration");
  add_checked(command, "--seconds", arguments.seconds, duration(), "S", "Stop after S simulated seconds instead")
      ->excludes(steps);
  add_checked(command, "--every", arguments.every, whole_number(0, most), "N", "A frame every N steps; 0 writes none");
  add_list(command, "--format", arguments.formats, one_of(kFrameFormats),
           "Frames as vtp (ParaView), pc2 (Blender, Maya), glb (glTF), usda (USD), ply, obj; several with commas");
  CLI::Option* picture =
      command.add_flag("--picture", arguments.picture, "Ray-traced pictures of the end and of six moments");
  picture->disable_flag_override();
  CLI::Option* picture_every = add_checked(command, "--picture-every", arguments.picture_every, whole_number(1, most),
                                           "N", "Also one every N steps");
  command.add_flag("--no-picture", arguments.no_picture, "No pictures, whatever the scene says")
      ->excludes(picture)
      ->excludes(picture_every);
  CLI::Option* page = command.add_flag("--page", arguments.page, "A page that replays the run in a browser: page.html");
  page->disable_flag_override();
  command.add_flag("--no-page", arguments.no_page, "No page, whatever the scene says")->excludes(page);
  add_checked(command, "--checkpoint", arguments.checkpoint_every, whole_number(0, most), "N",
              "A checkpoint every N steps, 0 none before the end; every 30 seconds of the clock if not given");
  command.add_flag("--resume", arguments.resume,
                   "Continue the run in the folder from its checkpoint, with the same bits");
  command.add_flag("--quiet", arguments.quiet, "Print errors and warnings only");
}

/// Returns the error message, a single line.
std::string complaint(const CLI::App& app, const CLI::Error& error) {
  std::string name = "malha";
  const CLI::App* last = &app;
  while (!last->get_subcommands().empty()) {
    last = last->get_subcommands().front();
    name += " " + last->get_name();
  }
  const CLI::App& command = *last;
  std::string what = error.what();
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error))
    for (const CLI::Option* option : command.get_options())
      if (option->get_items_expected_max() == 1 && option->count() > 1)
        what = option->get_name() + ": found " + std::to_string(option->count()) + " times; allowed: once";
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ExtrasError)) {
    std::vector<std::string> extras = command.remaining(), options;
    // CLI11 lists the unknown words in the order of its parsing; an option is reported first.
    const auto dashed = std::find_if(extras.begin(), extras.end(), [](const auto& word) { return word[0] == '-'; });
    const std::string word = dashed != extras.end() ? *dashed : extras.front();
    for (const CLI::Option* option : command.get_options())
      for (const std::string& known : option->get_lnames()) options.push_back("--" + known);
    what = "found " + malha::quoted(word) + did_you_mean(word, options) +
           "; allowed: " + (command.get_option_no_throw("SCENE") ? "one scene and " : "") + "the options of " + name;
  }
  return name + ": " + what + "; see " + name + " --help\n";
}

/// Returns the command line as typed, without --resume, which is added to continue the run.
std::string typed(int argc, char** argv) {
  std::string line = "malha";
  for (int i = 1; i < argc; ++i)
    if (const std::string word = argv[i]; word != "--resume") line += " " + shell_word(word);
  return line;
}

void add_run(CLI::App& app, Arguments& arguments) {
  CLI::App* run = app.add_subcommand("run", "Run a scene; report, frames and pictures go to a folder");
  add_scene(*run, arguments);
  add_results(*run, arguments);
  add_executor(*run, arguments);
  run->footer(
      "Options override the scene. Results have the same bits on any number of threads and on any backend.\n"
      "A run replaces the results of an earlier one in its folder; one that another run is writing to is refused.\n"
      "Ctrl-C stops it after the step: report and checkpoint are written, --resume goes on, and malha picture draws\n"
      "the pictures that are missing. A second Ctrl-C ends it at once. SCENE may be - for standard input.\n\n"
      "Examples:\n"
      "  malha run scenes/drape_bunny.json\n"
      "  malha run scenes/balloon.json --out /tmp/balloon --seconds 1 --format vtp,pc2 --every 2\n"
      "  malha run scenes/balloon.json --steps 100 --every 0 --no-picture      the report alone\n"
      "  malha run scenes/balloon.json --resume --seconds 10                   goes on to 10 s");
}

void add_picture(CLI::App& app, Arguments& arguments) {
  CLI::App* picture = app.add_subcommand("picture", "Draw the pictures of a run that was stopped, or had none");
  add_checked(*picture, "OUT", arguments.out, some_path(), "", "Folder of the results of malha run")->required();
  add_threads(*picture, arguments.threads);
  picture->footer(
      "Writes picture.png, of the state in the folder's checkpoint, and storyboard.png, of its frames for ParaView,\n"
      "if there are any. The scene is read from report.json; its meshes must be where they were.\n\n"
      "Example:\n  malha picture out/drape_bunny");
}

void add_page(CLI::App& app, Arguments& arguments) {
  CLI::App* page = app.add_subcommand("page", "Two runs side by side, in one page for the browser");
  add_checked(*page, "OUT", arguments.runs, some_path(), "", "Two folders of results of malha run --page")
      ->required()
      ->expected(2);
  add_checked(*page, "--out", arguments.out, some_path(), "FILE",
              "The file that is written; compare.html if not given");
  page->footer(
      "The runs play in step, with one camera and the distance between their particles.\n\n"
      "Example:\n"
      "  malha run scenes/balloon.json --page --out out/a\n"
      "  malha run scenes/my_balloon.json --page --out out/b\n"
      "  malha page out/a out/b --out compare.html");
}

void add_plan(CLI::App& app, Arguments& arguments) {
  CLI::App* plan = app.add_subcommand(
      "plan", "Print what would run: sizes, colours, passes of a step, memory, and the launches of one step");
  add_scene(*plan, arguments);
  add_executor(*plan, arguments);
  plan->add_flag("--json", arguments.json, "All of it as JSON")->disable_flag_override();
  plan->footer(
      "With --for it also estimates a step on that machine: groups a colour, fast memory, launches, bytes moved,\n"
      "and the time that its memory alone would take. Runs --for the same machine have the same bits on every "
      "backend.\n\n"
      "Examples:\n"
      "  malha plan scenes/balloon.json --threads 4\n"
      "  malha plan scenes/drape_bunny.json --for h200");
}

void add_check(CLI::App& app, Arguments& arguments) {
  CLI::App* check = app.add_subcommand("check", "Check a scene and its meshes; run nothing, write nothing");
  add_scene(*check, arguments);
  check->footer("Example:\n  malha check my_scene.json && malha run my_scene.json");
}

void add_materials(CLI::App& app) {
  CLI::App* materials = app.add_subcommand("materials", "Print the fabrics that a scene may name, with their moduli");
  materials->footer(
      "A body with \"material\": NAME has the density, the membrane and the plate of that fabric, unless it says them\n"
      "itself. scenes/README.md, Fabrics by name, says where the numbers come from.");
}

void add_everything(CLI::App& app, Arguments& arguments) {
  app.set_version_flag("--version", std::string("malha ") + version(), "Print the version");
  app.set_help_flag("-h,--help", "Print this help; malha COMMAND --help says more");
  app.require_subcommand(1);
  app.formatter(std::make_shared<Formatter>());
  app.get_formatter()->column_width(26);
  app.get_formatter()->label("SUBCOMMAND", "COMMAND");
  app.footer(
      "Examples:\n"
      "  malha run scenes/sheet_shear.json       results in out/sheet_shear/\n"
      "  malha view scenes/sheet_shear.json      in a window\n"
      "  malha plan scenes/balloon.json          what would run, before it runs\n"
      "  malha check my_scene.json               whether the scene and its meshes are sound\n"
      "  malha tune my_scene.json --error 0.001  the cheapest settings that are right to 1 mm\n"
      "  malha bench projection                  what a projection costs here; malha bench filter: a filter\n"
      "  malha study accuracy --quick            error against cost of every method, with charts\n\n"
      "Exit status: 0 done; 1 done, but not as the scene expects; 2 bad input, nothing was written; 3 the run\n"
      "diverged; 4 results could not be written; 5 not enough memory; 130 interrupted with Ctrl-C (malha run\n"
      "--resume goes on).");
  add_run(app, arguments);
  app.add_subcommand("view", "Open a scene in a window: run it, pull particles, change settings, compare two");
  add_picture(app, arguments);
  add_page(app, arguments);
  add_plan(app, arguments);
  add_check(app, arguments);
  add_materials(app);
  add_measures(app, arguments);
  for (CLI::App* command : app.get_subcommands({})) {
    command->group("Commands");
    command->set_help_flag("-h,--help", "Print this help");
  }
}

}  // namespace

std::string shell_word(const std::string& word) {
  const bool plain = !word.empty() && word.find_first_of(" \t\n'\"\\$&|;<>()*?[]{}~#!`") == std::string::npos;
  if (plain) return malha::printable(word);
  std::string quoted_word = "'";
  for (const char letter : malha::printable(word)) quoted_word += letter == '\'' ? "'\\''" : std::string(1, letter);
  return quoted_word + "'";
}

void add_scene(CLI::App& command, Arguments& arguments) {
  command.add_option("SCENE", arguments.scene, "Scene file (JSON; scenes/schema.json says what it may hold)")
      ->required()
      ->type_name("");
}

std::optional<int> parse_arguments(int argc, char** argv, Arguments& arguments) {
  const char* first = argc > 1 ? argv[1] : nullptr;
  const bool completes = first && std::string(first) == kCompleteWord;
  if (const std::string line = refused_word("malha", first, "command", kFirstWords); !line.empty() && !completes) {
    std::cerr << line << "\n";
    return kBadInput;
  }
  if (const std::optional<int> status = exec_or_refuse(argc, argv)) return status;
  CLI::App app{"Deformable bodies: cloth, balloons and soft solids in data-parallel batches.", "malha"};
  add_everything(app, arguments);
  if (completes) {
    print_completions(app, {argv + 2, argv + argc});
    return kDone;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::cerr << complaint(app, error);
    return kBadInput;
  }
  arguments.typed = typed(argc, argv);
  arguments.command = first;
  return std::nullopt;
}

}  // namespace malha
