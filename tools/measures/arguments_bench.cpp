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
           "Numbers of threads to measure with, such as 1,2,4; 1 and the number of cores if not given");
  add_checked(command, "--repeats", options.repeats, whole_number(1, 1000), "N",
              "How often each line is measured, for the median; " + std::to_string(options.repeats) + " if not given");
  add_checked(command, "--seconds", options.seconds, duration(), "S",
              "Least duration of each measurement, in seconds; " + shown(options.seconds) + " if not given");
  add_checked(command, "--json", options.json, some_path(), "FILE",
              "Also write the rows of the table to this file, as JSON");
  add_checked(command, "--out", options.out, some_path(), "FOLDER",
              "Folder of the results; out/bench_" + command.get_name() + " if not given");
  command.group("Benchmarks");
  command.set_help_flag("-h,--help", "Print this help");
}

void add_projection(CLI::App& bench, BenchArguments& arguments) {
  bench::ProjectionOptions& options = arguments.of_projection;
  CLI::App* projection =
      bench.add_subcommand("projection", "Time the projection of a distance constraint, beside Bullet's soft body");
  add_list(*projection, "--n", options.n, whole_number(kLeastSide, kMostSide * kMostSide),
           "Particles along a side of the grid; 17,46,100,316,1000 if not given.\n"
           "With --case irregular: the approximate number of all particles; 100000 if not given");
  add_checked(*projection, "--case", options.only, one_of(kCases), "NAME",
              "Mesh of the cloth, grid or irregular; both if not given, but only the grid if --n is given");
  add_measuring(*projection, arguments, options, bench::run_projection, check_sizes);
  projection->footer(
      "A cloth of 2 m and 1 kg hangs by one side. Its mesh is a grid with both diagonals of every cell, or an\n"
      "irregular triangle mesh whose vertices are listed in random order. malha simulates it with 10 substeps of 1\n"
      "iteration (10x1) and with 1 substep of 10 iterations (1x10), Bullet with 10 iterations. Each runs 60 steps\n"
      "before it is measured. Then all of them, on every number of threads, are measured in turns, so that other\n"
      "load on the machine slows them alike and their ratios still hold.\n\n"
      "The time of a projection is that of whole steps, divided by constraints x substeps x iterations. The table\n"
      "compares it with a lower bound from memory bandwidth and arithmetic (the floor). It also has the strain and a\n"
      "hash of the state, because a faster step is worth less if it leaves the cloth more stretched.\n\n"
      "The folder gets the table (projection.txt), its rows (projection.json), a description of the machine\n"
      "(projection_machine.json) and, if gnuplot is installed, the chart.\n\n"
      "Examples:\n"
      "  malha bench projection                                         all sizes and both meshes; some minutes\n"
      "  malha bench projection --n 46 --threads 1,2 --json rows.json   one size\n"
      "  malha bench projection --case irregular                        only the irregular mesh\n"
      "  malha bench projection --n 17,100 --repeats 3 --seconds 0.2    short and less exact");
}

void add_filter(CLI::App& bench, BenchArguments& arguments) {
  bench::FilterOptions& options = arguments.of_filter;
  CLI::App* filter =
      bench.add_subcommand("filter", "Time the product of Desbrun's filter, dense and sparse, beside OpenBLAS");
  add_list(*filter, "--n", options.n, whole_number(kLeastSide, kMostFilterSide),
           "Particles along a side of the grid. One row is pinned, so that N gives N (N - 1) unknowns;\n"
           "17,24,32,46,71,100,141,316,1000 if not given");
  add_list(*filter, "--kernel", options.kernels, one_of(kKernels),
           "What to measure: dense, sparse, step (below); all if not given, but not step if --n is given");
  add_measuring(*filter, arguments, options, bench::run_filter);
  filter->footer(
      "A cloth of 2 m and 1 kg hangs by one row. Its springs of 1e4 N/m lie along the edges and diagonals of a\n"
      "grid, and a step is 1/60 s. Desbrun's filter multiplies forces by S = (M - dt^2 H)^-1. --kernel chooses what\n"
      "is measured:\n\n"
      "  dense   S stored as a symmetric matrix in float, double and int16, for at most 25,000 unknowns; and sgemm,\n"
      "          ssymm and three ssymv of OpenBLAS, each with the memory layout in which it is fastest\n"
      "  sparse  S stored as a Cholesky factor of its inverse, in float and double\n"
      "  step    the largest cloth whose whole step takes at most 16.6 ms; if --n is given, up to its largest\n\n"
      "All that run on the same number of threads are measured in turns with reading as many bytes, and with a STREAM\n"
      "triad over as many, so that their ratios hold even if other programs use the machine. A sparse product reads\n"
      "each number twice, and its GB/s counts both.\n\n"
      "The folder gets the table (filter.txt), its rows (filter.json), a description of the machine\n"
      "(filter_machine.json) and, if gnuplot is installed, the chart. Do not set OMP_PROC_BIND: it would keep all\n"
      "threads of OpenBLAS on one core.\n\n"
      "Examples:\n"
      "  malha bench filter                                          all of it; many minutes, and 6 GiB of memory\n"
      "  malha bench filter --n 46,100 --threads 2 --kernel dense --json rows.json\n"
      "  malha bench filter --kernel step                            only the largest cloth in real time\n"
      "  malha bench filter --n 17,46 --repeats 3 --seconds 0.02     short and less exact");
}

void add_self(CLI::App& bench, BenchArguments& arguments) {
  bench::SelfOptions& options = arguments.of_self;
  CLI::App* self = bench.add_subcommand("self", "Time self-collision, per particle and substep");
  add_list(*self, "--n", options.n, whole_number(16, 10'000'000),
           "Approximate numbers of particles; each case has its own if not given");
  add_list(*self, "--case", options.cases, one_of(bench::self_case_names()),
           "Cases: " + join(bench::self_case_names()) + ";\nall if not given, but only stack if --n is given");
  add_measuring(*self, arguments, options, bench::run_self);
  self->footer(
      "The cases are layers of cloth that slide on each other, a heap, a cloth that falls over a ball, a twisted\n"
      "cloth, a crumpled one, and two balls. Layers are measured for as long as --seconds says, the other motions\n"
      "from their start to their end. The numbers of threads are measured in turns, so that their ratios hold even\n"
      "if other programs use the machine.\n\n"
      "The folder gets the table (self.txt), its rows (self.json) and a description of the machine\n"
      "(self_machine.json); with layers of several sizes also a chart of their steps over the particles\n"
      "(self.svg, self.png).\n\n"
      "Examples:\n"
      "  malha bench self                                        all cases; half an hour, and 4 GiB of memory\n"
      "  malha bench self --case heap --n 1364                   the cloth of 2006\n"
      "  malha bench self --case layers --n 10000,100000         falling layers, with a chart\n"
      "  malha bench self --n 10000 --repeats 3 --seconds 0.2    short and less exact");
}

void add_contact(CLI::App& bench, BenchArguments& arguments) {
  bench::ContactOptions& options = arguments.of_contact;
  CLI::App* contact = bench.add_subcommand("contact", "Time contact with environment meshes, per particle and substep");
  add_list(*contact, "--case", options.cases, one_of(bench::contact_cases()),
           "Cases: " + join(bench::contact_cases()) + ";\nall if not given");
  add_checked(*contact, "--bullet", options.bullet_frames, whole_number(0, 1000), "N",
              "Also let Bullet simulate N frames of each cloth on a scan, at some seconds a frame; 0 if not given");
  add_checked(*contact, "--scenes", options.scenes, some_path(), "FOLDER",
              "Folder of the shipped scenes and their meshes; ./scenes if not given");
  add_measuring(*contact, arguments, options, bench::run_contact);
  contact->footer(
      "The cases are shipped scenes, measured from the moment when many particles are in contact, and cloths of\n"
      "40,000 and 100,000 particles on scanned meshes that turn at 450 degrees/s. The numbers of threads are\n"
      "measured in turns. These columns of the table need an explanation:\n\n"
      "  by list       closest-point queries in a step that a mesh's octree of near triangles answered\n"
      "  queries       those that searched the whole mesh, by Embree\n"
      "  far B, near B bytes that are cached for a particle far from the mesh, and near it\n"
      "  lists MiB     memory of the octrees\n"
      "  Bullet ms     time of a frame of Bullet's soft body on the same meshes (--bullet), which starts from the\n"
      "                state that malha had when its measurement began\n\n"
      "The folder gets the table (contact.txt), its rows (contact.json) and a description of the machine\n"
      "(contact_machine.json).\n\n"
      "Examples:\n"
      "  malha bench contact\n"
      "  malha bench contact --case drape_bunny,armadillo --threads 1 --repeats 3 --seconds 0.5    short, less exact");
}

void add_constraints(CLI::App& bench, BenchArguments& arguments) {
  bench::ConstraintOptions& options = arguments.of_constraints;
  CLI::App* constraints = bench.add_subcommand("constraints", "Time each kind of constraint, alone on a body");
  add_checked(*constraints, "--n", options.n, whole_number(16, 4'000'000), "N",
              "Approximate number of particles of each body; 100000 if not given");
  add_measuring(*constraints, arguments, options, bench::run_constraints);
  constraints->footer(
      "Each kind of constraint is measured alone, on a sheet that hangs by a row of particles, or on a closed ball\n"
      "where the kind needs one. Constraints that are solved in batches are timed by whole steps, the others by\n"
      "their own pass. The numbers of threads are measured in turns.\n\n"
      "The folder gets the table (constraints.txt), its rows (constraints.json) and a description of the machine\n"
      "(constraints_machine.json).\n\n"
      "Examples:\n"
      "  malha bench constraints\n"
      "  malha bench constraints --n 10000 --threads 2 --repeats 3 --seconds 0.1    short and less exact");
}

}  // namespace

std::string refused_benchmark(const char* word) { return refused_word("malha bench", word, "benchmark", kBenchmarks); }

void add_bench(CLI::App& app, BenchArguments& arguments) {
  CLI::App* bench = app.add_subcommand("bench", kBenchHelp);
  bench->require_subcommand(1);
  bench->footer(
      "malha bench NAME --help explains a benchmark and its options.\n\n"
      "Examples:\n  malha bench projection --n 46,100\n  malha bench filter --n 46,100\n  malha bench constraints");
  add_projection(*bench, arguments);
  add_filter(*bench, arguments);
  add_constraints(*bench, arguments);
  add_self(*bench, arguments);
  add_contact(*bench, arguments);
}

}  // namespace malha
