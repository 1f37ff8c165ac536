#include "tools/arguments_bench.h"

#include "tools/validators.h"

namespace malha {

namespace {

const std::vector<std::string> kBenchmarks{"projection", "--help", "-h"};
const std::vector<std::string> kCases{"grid", "irregular"};

constexpr int kLeastSide = 3, kMostSide = 4000;  // particles

void add_list(CLI::App& command, const std::string& name, std::vector<int>& values, int low, int high,
              const std::string& help) {
  command.add_option(name, values, help)
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(whole_number(low, high))
      ->type_name("LIST");
}

/// What --n counts, and so how large it may be, hangs on --case.
void check_sizes(const bench::ProjectionOptions& options) {
  const bool irregular = options.only == "irregular";
  const int low = irregular ? kLeastSide * kLeastSide : kLeastSide;
  const int high = irregular ? kMostSide * kMostSide : kMostSide;
  for (const int n : options.n)
    if (n < low || n > high)
      throw CLI::ValidationError("--n", found(std::to_string(n), "a whole number from " + std::to_string(low) + " to " +
                                                                     std::to_string(high)));
}

}  // namespace

std::string refused_benchmark(const std::string& word) {
  if (std::find(kBenchmarks.begin(), kBenchmarks.end(), word) != kBenchmarks.end()) return "";
  const std::string shown = word.empty() ? "no benchmark" : malha::quoted(word) + did_you_mean(word, kBenchmarks);
  return "malha bench: found " + shown + "; allowed: " + join(kBenchmarks);
}

void add_bench(CLI::App& app, bench::ProjectionOptions& options) {
  CLI::App* bench = app.add_subcommand("bench", "Time malha beside Bullet and the machine's limits");
  bench->require_subcommand(1);
  bench->footer("Example:\n  malha bench projection --n 46,100");
  CLI::App* projection = bench->add_subcommand("projection", "What the projection of a constraint costs");
  add_list(*projection, "--n", options.n, kLeastSide, kMostSide * kMostSide,
           "Particles a side of the grid; 17,46,100,316,1000 if not given.\n"
           "With --case irregular: about how many particles; 100000");
  add_list(*projection, "--threads", options.threads, 1, 1024, "Numbers of threads; 1 and all cores if not given");
  projection
      ->add_option("--case", options.only, "grid or irregular; both if not given, but the grid alone if --n is given")
      ->check(one_of(kCases))
      ->type_name("NAME");
  projection->add_option("--repeats", options.repeats, "Times that each line is measured; 5 if not given")
      ->check(whole_number(1, 1000))
      ->type_name("N");
  projection->add_option("--seconds", options.seconds, "Seconds of each of them, at least; 1 if not given")
      ->check(duration())
      ->type_name("S");
  projection->add_option("--json", options.json, "Write the rows here too")->type_name("FILE");
  projection->add_option("--out", options.out, "Folder of the results; out/bench_projection if not given")
      ->type_name("FOLDER");
  projection->group("Benchmarks");
  projection->set_help_flag("-h,--help", "Print this help");
  projection->callback([&options] { check_sizes(options); });
  projection->footer(
      "A cloth of 2 m and 1 kg hangs by one side: a grid with both diagonals of its cells, or an irregular triangle\n"
      "mesh with shuffled indices. Each line runs 60 steps before it is measured: 10 substeps of 1 iteration (10x1)\n"
      "and 1 substep of 10 iterations (1x10), on each number of threads, and Bullet's soft body. They take turns, so\n"
      "that ratios hold on a busy machine. The time is that of whole steps, by constraints x substeps x iterations.\n"
      "Strain and state hash show what the time bought; the floor is what memory and arithmetic allow.\n"
      "The folder gets the table, the rows (projection.json), facts about the machine (projection_machine.json), and\n"
      "the chart, if gnuplot is installed.\n\n"
      "Examples:\n"
      "  malha bench projection                              everything; some minutes\n"
      "  malha bench projection --n 46 --threads 1,2 --json rows.json\n"
      "  malha bench projection --case irregular\n"
      "  malha bench projection --n 17,100 --repeats 3 --seconds 0.2    a quick look");
}

}  // namespace malha
