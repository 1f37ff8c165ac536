// SPDX-License-Identifier: Apache-2.0
#include "tools/measures/arguments_bench.h"

#include "tools/measures.h"
#include "tools/validators.h"

namespace malha {

namespace {

const std::vector<std::string> kBenchmarks{"projection", "filter", "constraints", "self", "contact", "--help", "-h"};
const std::vector<std::string> kCases{"grid", "irregular"};
const std::vector<std::string> kKernels{"dense", "sparse", "step"};

constexpr int kLeastSide = 3, kMostSide = 4000;  // particles
constexpr int kMostFilterSide = 2000;

/// Checks --n, whose meaning and range depend on --case.
void check_sizes(const bench::ProjectionOptions& options) {
  const bool irregular = options.only == "irregular";
  const int low = irregular ? kLeastSide * kLeastSide : kLeastSide;
  const int high = irregular ? kMostSide * kMostSide : kMostSide;
  for (const int n : options.n)
    if (n < low || n > high)
      throw CLI::ValidationError("--n", found(std::to_string(n), "a whole number from " + std::to_string(low) + " to " +
                                                                     std::to_string(high)));
}

/// Adds the options that all benchmarks share, and the function that runs it. `check` throws for options that exclude
/// each other.
template <class Options>
void add_measuring(CLI::App& command, BenchArguments& arguments, Options& options, void (*run)(const Options&),
                   void (*check)(const Options&) = nullptr) {
  command.callback([=, &arguments, &options] {
    if (check) check(options);
    arguments.run = [=, &options] { options.on.require_device(), run(options); };
  });
  add_backend(command, options.on.backend, options.on.machine);
  add_list(command, "--threads", options.threads, whole_number(1, 1024),
           "Numbers of threads; 1 and all cores if not given");
  add_checked(command, "--repeats", options.repeats, whole_number(1, 1000), "N",
              "Times that each line is measured; " + std::to_string(options.repeats) + " if not given");
  add_checked(command, "--seconds", options.seconds, duration(), "S",
              "Seconds of each of them, at least; " + shown(options.seconds) + " if not given");
  add_checked(command, "--json", options.json, some_path(), "FILE", "Write the rows here too");
  add_checked(command, "--out", options.out, some_path(), "FOLDER",
              "Folder of the results; out/bench_" + command.get_name() + " if not given");
  command.group("Benchmarks");
  command.set_help_flag("-h,--help", "Print this help");
}

void add_projection(CLI::App& bench, BenchArguments& arguments) {
  bench::ProjectionOptions& options = arguments.of_projection;
  CLI::App* projection = bench.add_subcommand("projection", "What the projection of a constraint costs");
  add_list(*projection, "--n", options.n, whole_number(kLeastSide, kMostSide * kMostSide),
           "Particles a side of the grid; 17,46,100,316,1000 if not given.\n"
           "With --case irregular: about how many particles; 100000");
  add_checked(*projection, "--case", options.only, one_of(kCases), "NAME",
              "grid or irregular; both if not given, but the grid alone if --n is given");
  add_measuring(*projection, arguments, options, bench::run_projection, check_sizes);
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

void add_filter(CLI::App& bench, BenchArguments& arguments) {
  bench::FilterOptions& options = arguments.of_filter;
  CLI::App* filter = bench.add_subcommand("filter", "What a product of Desbrun's filter costs");
  add_list(*filter, "--n", options.n, whole_number(kLeastSide, kMostFilterSide),
           "Particles a side of the grid: N gives N (N - 1) unknowns;\n17,24,32,46,71,100,141,316,1000 if not given");
  add_list(*filter, "--kernel", options.kernels, one_of(kKernels),
           "dense, sparse, step; all if not given, but no step if --n is given");
  add_measuring(*filter, arguments, options, bench::run_filter);
  filter->footer(
      "A cloth of 2 m and 1 kg hangs by one row: a grid with springs of 1e4 N/m along its edges and diagonals,\n"
      "dt = 1/60 s. dense: S = (M - dt^2 H)^-1 as a symmetric matrix in float, double and int16, up to 25,000 "
      "unknowns,\n"
      "beside OpenBLAS's sgemm, ssymm and three ssymv, each in its fastest layout. sparse: S as a factor. All that "
      "run\n"
      "on as many threads take turns with reading, and a STREAM triad of, as many bytes, so that ratios hold on a "
      "busy\n"
      "machine. A sparse product reads each number twice: GB/s counts both. step: the most particles of which the\n"
      "whole step takes at most 16.6 ms, searched for; up to the largest --n, if given.\n"
      "The folder gets the table, the rows (filter.json), facts about the machine (filter_machine.json), and the\n"
      "chart, if gnuplot is installed. Do not set OMP_PROC_BIND: it keeps OpenBLAS's threads on one core.\n\n"
      "Examples:\n"
      "  malha bench filter                              everything; many minutes, and 6 GiB of memory\n"
      "  malha bench filter --n 46,100 --threads 2 --kernel dense --json rows.json\n"
      "  malha bench filter --kernel step                real time alone\n"
      "  malha bench filter --n 17,46 --repeats 3 --seconds 0.02    a quick look");
}

void add_self(CLI::App& bench, BenchArguments& arguments) {
  bench::SelfOptions& options = arguments.of_self;
  CLI::App* self = bench.add_subcommand("self", "What self-collision costs a particle");
  add_list(*self, "--n", options.n, whole_number(16, 10'000'000), "Particles, about; those of each case if not given");
  add_list(*self, "--case", options.cases, one_of(bench::self_case_names()),
           join(bench::self_case_names()) + "; all if not given, but stack alone if --n is given");
  add_measuring(*self, arguments, options, bench::run_self);
  self->footer(
      "Layers that slide, a heap, a cloth over a ball, a twisted one, a crumpled one, and two balls.\n"
      "Those on each number of threads take turns. A motion is measured from its start to its end.\n"
      "The folder gets the table, the rows (self.json) and facts about the machine (self_machine.json).\n\n"
      "Examples:\n"
      "  malha bench self                                        everything; half an hour, and 4 GiB of memory\n"
      "  malha bench self --case heap --n 1364                   the cloth of 2006\n"
      "  malha bench self --n 10000 --repeats 3 --seconds 0.2    a quick look");
}

void add_contact(CLI::App& bench, BenchArguments& arguments) {
  bench::ContactOptions& options = arguments.of_contact;
  CLI::App* contact = bench.add_subcommand("contact", "What contact with the environment costs a particle");
  add_list(*contact, "--case", options.cases, one_of(bench::contact_cases()),
           join(bench::contact_cases()) + "; all if not given");
  add_checked(*contact, "--bullet", options.bullet_frames, whole_number(0, 1000), "N",
              "Frames of each cloth on a scan by Bullet too, some seconds each; 0 if not given");
  add_checked(*contact, "--scenes", options.scenes, some_path(), "FOLDER",
              "Folder of the shipped scenes and meshes; scenes if not given");
  add_measuring(*contact, arguments, options, bench::run_contact);
  contact->footer(
      "Shipped scenes, from the moment when many particles are in contact, and cloths of 40,000 and 100,000 particles\n"
      "on scans that turn at 450 degrees/s. by list: closest-point queries a step that a mesh's lists of near "
      "triangles\n"
      "answer; queries: those of the whole mesh, by Embree. far B, near B: cached bytes of a far and a near particle;\n"
      "lists MiB: size of the meshes' lists. All numbers of threads run in turns. Bullet ms: a frame of its soft body\n"
      "on the same meshes, from malha's state at the first measurement.\n"
      "The folder gets the table, the rows (contact.json) and facts about the machine.\n\n"
      "Examples:\n"
      "  malha bench contact\n"
      "  malha bench contact --case drape_bunny,armadillo --threads 1 --repeats 3 --seconds 0.5    a quick look");
}

void add_constraints(CLI::App& bench, BenchArguments& arguments) {
  bench::ConstraintOptions& options = arguments.of_constraints;
  CLI::App* constraints = bench.add_subcommand("constraints", "What each kind of constraint costs");
  add_checked(*constraints, "--n", options.n, whole_number(16, 4'000'000), "N",
              "Particles of each body, about; 100000 if not given");
  add_measuring(*constraints, arguments, options, bench::run_constraints);
  constraints->footer(
      "Every kind alone on a body of its own: a sheet hung by a row, or where it needs one a closed ball. What is\n"
      "batched is timed as whole steps, the rest as its own pass. Numbers of threads take turns.\n"
      "The folder gets the table, the rows (constraints.json), and facts about the machine.\n\n"
      "Examples:\n"
      "  malha bench constraints\n"
      "  malha bench constraints --n 10000 --threads 2 --repeats 3 --seconds 0.1    a quick look");
}

}  // namespace

std::string refused_benchmark(const char* word) { return refused_word("malha bench", word, "benchmark", kBenchmarks); }

void add_bench(CLI::App& app, BenchArguments& arguments) {
  CLI::App* bench = app.add_subcommand("bench", kBenchHelp);
  bench->require_subcommand(1);
  bench->footer(
      "Examples:\n  malha bench projection --n 46,100\n  malha bench filter --n 46,100\n  malha bench constraints");
  add_projection(*bench, arguments);
  add_filter(*bench, arguments);
  add_constraints(*bench, arguments);
  add_self(*bench, arguments);
  add_contact(*bench, arguments);
}

}  // namespace malha
