// SPDX-License-Identifier: Apache-2.0
#include "tools/measures/arguments_tune.h"

#include "tools/arguments.h"
#include "tools/measures.h"
#include "tools/validators.h"

namespace malha {

void add_tune(CLI::App& app, Arguments& arguments) {
  TuneArguments& tune = arguments.tune;
  CLI::App* command = app.add_subcommand("tune", kTuneHelp);
  add_checked(*command, "--error", tune.error, above_zero("m"), "E",
              "Largest error that is allowed, in metres: the RMS distance of the particles to their true\n"
              "positions (below), at the worst of four moments of the simulated time")
      ->required();
  add_checked(*command, "--seconds", tune.seconds, duration(), "S",
              "Simulated time over which the error is measured, in seconds; the scene's duration, but at most\n"
              "1 s, if not given");
  add_checked(*command, "--json", tune.json, some_path(), "FILE",
              "Also write every setting that was tried, with its time and error, to this file as JSON");
  add_scene(*command, arguments);
  add_checked(*command, "--out", arguments.out, some_path(), "FILE",
              "File of the tuned scene; out/NAME-OF-THE-SCENE-FILE_tuned.json if not given");
  add_threads(*command, arguments.threads);
  command->footer(
      "tune writes a scene with the cheapest method and settings whose error is at most E on this machine.\n\n"
      "True positions. The scene's own method computes them in double with ever more substeps, doubled each time,\n"
      "and extrapolates to steps of length zero, until the error of this reference is known to be below E / 8. A\n"
      "setting is accepted if its distance to the reference is at most E less that bound. There is no reference for\n"
      "chaotic motion, nor for oscillations too fast for all of these steps, which are noticed by the energy that\n"
      "the scene loses. They are not noticed where damping, wind, contact, limits, attachments or keyframes take or\n"
      "give energy.\n\n"
      "What is tried. PBD or XPBD with 1 to 8 iterations, with and without levels, and with bending filtered and\n"
      "projected; and Desbrun's method where the scene has springs, with and without refinement iterations and with\n"
      "either filter. Each is tried in float and double, with as few substeps as keep the error below E. All other\n"
      "settings stay as the scene has them. Where a constraint has no compliance, the methods simulate different\n"
      "materials, which counts as error.\n\n"
      "Times hold for this machine and this number of threads.\n\n"
      "Exit status: 0 the tuned scene was written; 1 nothing was written, because no setting reaches E, or because\n"
      "the motion has no reference.\n\n"
      "Examples:\n"
      "  malha tune scenes/cantilever.json --error 0.002          writes out/cantilever_tuned.json\n"
      "  malha tune my_scene.json --error 0.0002 --seconds 0.5 --threads 1 --out my_tuned.json");
}

}  // namespace malha
