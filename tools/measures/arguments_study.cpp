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

std::vector<std::string> names_and_all() {
  std::vector<std::string> words = names();
  words.push_back("all");
  return words;
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
  std::vector<std::string> words = names_and_all();
  words.insert(words.end(), {"--help", "-h"});
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
      ->check(one_of(names_and_all()))
      ->type_name("");
  study->add_flag("--quick", options.quick,
                  "Measure smaller cases and fewer points, which takes seconds instead of minutes");
  add_checked(*study, "--out", options.out, some_path(), "FOLDER",
              "Folder of the results; out/study, or out/study_quick, if not given");
  add_backend(*study, options.on.backend, options.on.machine);
  study->add_flag("--keep", options.keep, "Also use measurements that another build of malha left in the folder");
  study
      ->add_option_function<std::string>(
          "--share", [&options](const std::string& text) { options.share = study::share_of(text); },
          "Measure only one of N shares, for --merge (below)")
      ->check(a_share())
      ->type_name("I/N");
  add_checked(*study, "--merge", options.merge, some_path(), "DIR...",
              "Combine the shares that these folders hold; nothing is measured");
  study->callback([&options] {
    if (options.share && !options.merge.empty())
      throw CLI::ValidationError("--merge", "found --share beside it; allowed: one of them");
  });
  study->footer(
      "Studies:\n" + list() +
      "\nResults. A study leaves NAME.csv, NAME.json and, if gnuplot is installed, charts NAME_*.svg and .png.\n"
      "index.html shows all studies of the folder on one page.\n\n"
      "Python. validation is a script in Python, which needs numpy, scipy and matplotlib (tools/setup python). "
      "MALHA_PYTHON\n"
      "names the Python that runs it, if it is not the one for which malha's module was built. It takes no shares.\n\n"
      "Interrupted studies. A study consists of single measurements, its cells. Each is appended to NAME.cells.jsonl\n"
      "(NAME.quick.cells.jsonl with --quick) as soon as it is finished. If the study is stopped, by Ctrl-C or by a\n"
      "crash, the same command continues it. Cells of another build or machine are moved to NAME.cells.jsonl.old\n"
      "and measured again. To measure everything again, remove the file.\n\n"
      "Shares. --share 2/3 measures the cells 2, 5, 8 and so on, and writes them to NAME.2of3.cells.jsonl only. Cells\n"
      "that depend on each other count as one. Shares may run at the same time, on this machine or on others. On one\n"
      "machine they slow each other down, which falsifies the times of scaling, size and parsimony, and the costs of\n"
      "accuracy and published.\n"
      "--merge writes the results that one process would have written; rows name the machine if there are several. If\n"
      "no share has measured some of the cells, it names them, writes nothing, and ends with status 1.\n\n"
      "Backends. accuracy and scaling run on any --backend, the others on the host. On a device, scaling measures\n"
      "bodies of several sizes instead of numbers of threads, and accuracy measures costs by the clock.\n\n"
      "Examples:\n"
      "  malha study all --quick                 all studies in short; half a minute\n"
      "  malha study accuracy                    the charts of tools/study/README.md; many minutes\n"
      "  malha study accuracy --out /tmp/study\n"
      "  malha study accuracy --share 2/3        the second of three shares\n"
      "  malha study accuracy --merge a b c      the folders that hold the three shares");
}

}  // namespace malha
