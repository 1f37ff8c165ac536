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
              "Error to reach (m): RMS distance of the particles to where they truly are, at the worst of four\n"
              "moments in the simulated time")
      ->required();
  add_checked(*command, "--seconds", tune.seconds, duration(), "S",
              "Simulated time; the scene's duration, at most 1 s, if not given");
  add_checked(*command, "--json", tune.json, some_path(), "FILE", "All that was tried, with all numbers, as JSON too");
  add_scene(*command, arguments);
  add_checked(*command, "--out", arguments.out, some_path(), "FILE",
              "The tuned scene; out/NAME-OF-THE-SCENE-FILE_tuned.json if not given");
  add_threads(*command, arguments.threads);
  command->footer(
      "Where the particles truly are is said by the scene's own method in double, at twice the substeps again and\n"
      "again, extrapolated to no step at all, until that is known to E / 8. What is written is within E less what is\n"
      "not known. Motion that never converges (chaos) cannot be tuned to such an error, nor motion that is too fast\n"
      "for all of those steps: its energy is missed. Where damping, wind, contact, limits, attachments or keyframes\n"
      "take or give energy, that is not seen.\n"
      "Tried are PBD or XPBD with 1 to 8 iterations, and Desbrun's method where the scene has springs, refined or "
      "not,\n"
      "with either filter, in float and double, each with as few substeps as reach E. All else stays as the scene\n"
      "says; where a constraint has no compliance, the methods are not the same material, and the error tells.\n"
      "Times are those of this machine and this number of threads.\n\n"
      "Exit status: 0 the tuned scene is written; 1 nothing reaches E, or the motion does not converge or is too fast: "
      "nothing is\n"
      "written.\n\n"
      "Examples:\n"
      "  malha tune scenes/cantilever.json --error 0.002          writes out/cantilever_tuned.json\n"
      "  malha tune my_scene.json --error 0.0002 --seconds 0.5 --threads 1 --out my_tuned.json");
}

}  // namespace malha
