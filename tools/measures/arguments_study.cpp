// SPDX-License-Identifier: Apache-2.0
#include "tools/measures/arguments_study.h"

#include "tools/measures.h"
#include "tools/study/study.h"
#include "tools/validators.h"

namespace malha {

namespace {

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const study::Study& study : study::studies()) all.push_back(study.name);
  return all;
}

CLI::Validator a_share() {
  return {[](const std::string& text) {
            return study::share_of(text)
                       ? ""
                       : found(text, "I/N, such as 2/3, with 1 <= I <= N <= " + std::to_string(study::kMostShares));
          },
          ""};
}

/// Returns a line for each study.
std::string list() {
  std::string lines;
  for (const study::Study& study : study::studies())
    lines +=
        "  " + study.name + std::string(14 - std::min<std::size_t>(study.name.size(), 12), ' ') + study.what + "\n";
  return lines;
}

}  // namespace

std::string refused_study(const char* word) {
  std::vector<std::string> words = names();
  words.insert(words.end(), {"all", "--help", "-h"});
  return refused_word("malha study", word, "study", words);
}

void add_study(CLI::App& app, study::Options& options) {
  CLI::App* study = app.add_subcommand("study", kStudyHelp);
  study
      ->add_option_function<std::string>(
          "NAME",
          [&options](const std::string& name) {
            options.names = name == "all" ? names() : std::vector<std::string>{name};
          },
          "One of the studies below, or all")
      ->required()
      ->type_name("");
  study->add_flag("--quick", options.quick, "Smaller cases and fewer points: the facts, in seconds");
  add_checked(*study, "--out", options.out, some_path(), "FOLDER",
              "Folder of the results; out/study, or out/study_quick, if not given");
  add_backend(*study, options.on.backend, options.on.machine);
  study->add_flag("--keep", options.keep, "Take cells that another build of malha has finished, too");
  study
      ->add_option_function<std::string>(
          "--share", [&options](const std::string& text) { options.share = study::share_of(text); },
          "Measure only the cells I, I + N, ..., for --merge")
      ->check(a_share())
      ->type_name("I/N");
  add_checked(*study, "--merge", options.merge, some_path(), "DIR...",
              "Put together what shares have left in these folders; measures nothing");
  study->callback([&options] {
    if (options.share && !options.merge.empty())
      throw CLI::ValidationError("--merge", "found --share beside it; allowed: one of them");
  });
  study->footer(
      "Studies:\n" + list() +
      "\nEach leaves NAME.csv, NAME.json, charts NAME_*.svg and .png (if gnuplot is installed), and index.html, which\n"
      "gathers all studies of the folder on one page. Every measurement that is finished is kept in NAME.cells.jsonl:\n"
      "a study that was stopped (Ctrl-C, a crash) goes on there with the same command. Cells of another build\n"
      "or machine become NAME.cells.jsonl.old; those of quick versions are NAME.quick.cells.jsonl. A study is started\n"
      "anew by removing that file.\n\n"
      "--share 2/3 measures only the cells 2, 5, 8 and so on, and writes only NAME.2of3.cells.jsonl; cells that\n"
      "depend on each other count as one. Shares run side by side, here or on other machines. Side by side on one\n"
      "machine they disturb each other's times: scaling, size, parsimony, and the costs of accuracy and published\n"
      "want it alone.\n"
      "--merge writes what the study by one process would; rows name the machine where there are several. Cells that\n"
      "no share has measured it names, writes nothing, and ends with status 1.\n\n"
      "accuracy and scaling run on any --backend. On a device scaling is one of size alone, and the costs of accuracy\n"
      "are times by the clock.\n\n"
      "Examples:\n"
      "  malha study all --quick                 everything in short; half a minute\n"
      "  malha study accuracy                    the charts of tools/study/README.md; many minutes\n"
      "  malha study accuracy --out /tmp/study\n"
      "  malha study accuracy --share 2/3        the second of three shares\n"
      "  malha study accuracy --merge a b c      folders that hold the three shares");
}

}  // namespace malha
