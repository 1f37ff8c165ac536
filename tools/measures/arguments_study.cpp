// SPDX-License-Identifier: Apache-2.0
#include "tools/measures/arguments_study.h"

#include <regex>

#include "tools/measures.h"
#include "tools/validators.h"

namespace malha {

namespace {

std::vector<std::string> names_and_all() {
  std::vector<std::string> words;
  for (const Study& study : studies()) words.push_back(study.name);
  words.push_back("all");
  return words;
}

CLI::Validator a_share() {
  return {[](const std::string& text) {
            static const std::regex form(R"((\d{1,6})/(\d{1,6}))");
            std::smatch parts;
            const bool valid = std::regex_match(text, parts, form) && std::stoi(parts[1]) >= 1 &&
                               std::stoi(parts[1]) <= std::stoi(parts[2]) && std::stoi(parts[2]) <= kMostShares;
            return valid ? "" : found(text, "I/N, such as 2/3, with 1 <= I <= N <= " + std::to_string(kMostShares));
          },
          ""};
}

/// Returns a line for each study.
std::string list() {
  std::string lines;
  for (const Study& study : studies())
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

void add_study(CLI::App& app, StudyOptions& options) {
  CLI::App* study = app.add_subcommand("study", kStudyHelp);
  add_checked(*study, "NAME", options.name, one_of(names_and_all()), "", "One of the studies below, or all")
      ->required();
  study->add_flag("--quick", options.quick,
                  "Measure smaller cases and fewer points, which takes seconds instead of minutes");
  add_checked(*study, "--out", options.out, some_path(), "FOLDER",
              "Folder of the results; out/study, or out/study_quick, if not given");
  add_backend(*study, options.backend, options.machine);
  study->add_flag("--keep", options.keep,
                  "Also use measurements that another build of malha or of the script left in the folder");
  add_checked(*study, "--share", options.share, a_share(), "I/N", "Measure only one of N shares, for --merge (below)");
  add_checked(*study, "--merge", options.merge, some_path(), "DIR...",
              "Combine the shares that these folders hold; nothing is measured");
  study->callback([&options] {
    if (!options.share.empty() && !options.merge.empty())
      throw CLI::ValidationError("--merge", "found --share beside it; allowed: one of them");
  });
  study->footer(
      "Studies:\n" + list() +
      "\nResults. A study leaves NAME.csv, NAME.json and charts NAME_*.svg and .png. index.html shows all studies of "
      "the\n"
      "folder on one page, results.html what they have found in one look.\n\n"
      "Python. A study is a script, study/NAME.py beside this program or share/malha/study/NAME.py of an "
      "installation. It\n"
      "needs malha's module, numpy, scipy and matplotlib (tools/setup python). MALHA_PYTHON names the Python that "
      "runs it,\n"
      "if it is not the one for which the module was built. Copy a script and change it to make a study of your "
      "own.\n\n"
      "Interrupted studies. A study consists of single measurements, its cells. Each is appended to NAME.cells.jsonl\n"
      "(NAME.quick.cells.jsonl with --quick) as soon as it is finished. If the study is stopped, by Ctrl-C or by a\n"
      "crash, the same command continues it. Cells of another build, script or machine are moved to\n"
      "NAME.cells.jsonl.old and measured again. To measure everything again, remove the file.\n\n"
      "Shares. --share 2/3 measures the cells 2, 5, 8 and so on, and writes them to NAME.2of3.cells.jsonl only. Cells\n"
      "that depend on each other count as one. Shares may run at the same time, on this machine or on others. On one\n"
      "machine they slow each other down, which falsifies the times of scaling, size and parsimony, and the costs of\n"
      "accuracy and published.\n"
      "--merge writes the results that one process would have written; rows name the machine if there are several. If\n"
      "no share has measured some of the cells, it names them, writes nothing, and ends with status 1; all goes on "
      "with\n"
      "the other studies first.\n\n"
      "Backends. accuracy and scaling run on any --backend, the others on the host. On a device, scaling measures\n"
      "bodies of several sizes instead of numbers of threads, and accuracy measures costs by the clock.\n\n"
      "Examples:\n"
      "  malha study all --quick                 all studies in short; two minutes\n"
      "  malha study accuracy                    the charts of tools/study/README.md; many minutes\n"
      "  malha study accuracy --out /tmp/study\n"
      "  malha study results --out /tmp/study    results.html, of what that folder has\n"
      "  malha study accuracy --share 2/3        the second of three shares\n"
      "  malha study accuracy --merge a b c      the folders that hold the three shares");
}

}  // namespace malha
