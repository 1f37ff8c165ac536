// SPDX-License-Identifier: Apache-2.0
// The program malha_view, which the command executes for malha view, so that the command itself needs no libraries of a
// display.
#include <CLI/CLI.hpp>
#include <iostream>

#include "host/base/build_info.h"
#include "malha/error.h"
#include "malha/text.h"
#include "tools/completion.h"
#include "tools/exit_status.h"
#include "tools/streams.h"
#include "tools/validators.h"
#include "tools/view/window.h"

namespace {

int show(int argc, char** argv) {
  CLI::App app{"Open a scene in a window: run it, pull particles, change settings, compare two.", "malha view"};
  malha::view::WindowOptions options;
  std::string out = "out/view";
  // The first argument is the subcommand.
  if (argc > 1 && std::string(argv[1]) == "view") --argc, ++argv;
  app.add_option("SCENE", options.scenes, "Scene files: none, one, or two to compare")->expected(0, 2)->type_name("");
  malha::add_threads(app, options.simulation.threads, "Largest number of threads; the cores if not given");
  malha::add_checked(app, "--out", out, malha::some_path(), "FOLDER",
                     "Folder of saved pictures and scenes; out/view if not given");
  malha::add_checked(app, "--width", options.width, malha::whole_number(320, 16384), "N",
                     "Of the window, pixels; 1280 if not given");
  malha::add_checked(app, "--height", options.height, malha::whole_number(240, 16384), "N", "800 if not given");
  app.footer(
      "F1 lists keys and mouse. A scene or a mesh can be dropped on the window.\n\n"
      "Examples:\n"
      "  malha view scenes/drape_bunny.json\n"
      "  malha view scenes/sheet_shear.json scenes/desbrun_sheet.json");
  if (argc > 2 && std::string(argv[1]) == malha::kCompleteWord) {  // and "view"
    malha::print_completions(app, {argv + 3, argv + argc});
    return malha::kDone;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::cerr << "malha view: " << malha::printable(error.what()) << "; see malha view --help\n";
    return malha::kBadInput;
  }
  options.out = out, options.simulation.adaptive_threads = true;
  malha::view::show_window(options);
  return malha::kDone;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const int status = show(argc, argv);
    malha::require_written();
    return status;
  } catch (const malha::InputError& error) {
    std::cerr << error.what() << "\n";
    return malha::kBadInput;
  } catch (const std::exception& error) {
    std::cerr << malha::printable(error.what()) << "\n";
    return malha::kFailed;
  }
}
