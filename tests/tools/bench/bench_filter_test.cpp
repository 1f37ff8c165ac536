// SPDX-License-Identifier: Apache-2.0
// The command malha bench filter, and the variants that it compares. Speed is never asserted.
#include <sched.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/support.h"
#include "tools/bench/filter/filter_case.h"
#include "tools/bench/filter/step.h"
#include "tools/bench/filter/table.h"
#include "tools/bench/machine.h"
#include "tools/bench/peers/openblas.h"
#include "tools/bench/pinned.h"
#include "tools/bench/stream.h"

namespace malha::bench {
namespace {

using Json = nlohmann::json;

/// The number of OpenBLAS's rows per size and number of threads.
std::size_t peers() { return openblas_version().empty() ? 0 : 3; }

/// Runs the benchmark as briefly as possible.
Ended bench_filter(std::vector<std::string> words, const TemporaryFolder& folder) {
  words.insert(words.begin(), {"bench", "filter", "--seconds", "0.001", "--repeats", "2"});
  return malha_command(words, folder / ".");
}

/// Expects all keys in every row, and positive finite numbers.
void expect_whole_filter(const Json& rows) {
  for (const Json& row : rows) {
    for (const char* key : {"kernel", "storage"}) EXPECT_TRUE(row.contains(key) && row[key].is_string()) << row;
    std::vector<std::string> keys{
        "n",      "particles", "side",           "threads", "ms",           "ms_min",
        "ms_max", "gb_per_s",  "relative_error", "setup_s", "memory_bytes", "relative_error_elastic"};
    const std::string kernel = row["kernel"];
    if (kernel == "dense" || kernel == "sparse") {
      for (const char* key : {"read_gb_per_s", "of_read_bandwidth", "times_triad"}) keys.push_back(key);
      for (const char* peer : {"sgemm", "ssymm", "ssymv"})
        if (peers() > 0) keys.push_back(std::string("times_as_fast_as_") + peer);
    }
    for (const std::string& key : keys) {
      ASSERT_TRUE(row.contains(key) && row[key].is_number()) << key << " in " << row;
      EXPECT_TRUE(std::isfinite(row[key].get<double>()) && row[key] > 0) << key << " in " << row;
    }
  }
}

/// Upper bounds of the errors for noise and elastic forces at 10 x 10, by storage.
double most_error(const std::string& storage) { return storage == "double" ? 1e-12 : storage == "float" ? 1e-5 : 1e-2; }

TEST(BenchFilter, WritesARowForEveryVariant) {
  const TemporaryFolder folder;
  const Ended ended = bench_filter({"--n", "10", "--threads", "2,1", "--json", "rows/rows.json"}, folder);
  ASSERT_EQ(ended.status, 0) << ended.err;
  const Json rows = Json::parse(bytes_of(folder / "rows/rows.json"));
  expect_whole_filter(rows);
  ASSERT_EQ(rows.size(), 2 * (5 + peers()));
  std::set<std::string> who;
  for (const Json& row : rows) {
    const std::string storage = row["storage"];
    who.insert(row["kernel"].get<std::string>() + " " + storage + " " + row["threads"].dump());
    EXPECT_EQ(row["n"], 90) << "10 x 10 without the row of pins";
    EXPECT_EQ(row["particles"], 100);
    EXPECT_LT(row["relative_error"], most_error(storage)) << row;
    EXPECT_LT(row["relative_error_elastic"], most_error(storage)) << row;
  }
  EXPECT_EQ(who.size(), rows.size()) << "each on each number of threads";
  for (const char* one : {"dense float 1", "dense double 2", "dense int16 1", "sparse float 2", "sparse double 1"})
    EXPECT_TRUE(who.contains(one)) << one;

  const auto files = files_in(folder / "out/bench_filter");
  EXPECT_EQ(files.at("filter.json"), bytes_of(folder / "rows/rows.json"));
  EXPECT_EQ(ended.out.find(files.at("filter.txt")), 0u) << "the table is what was printed";
  for (const char* key : {"compiler", "flags", "instructions", "cpu", "triad_gb_per_s", "read_gb_per_s", "cache_bytes"})
    EXPECT_TRUE(Json::parse(files.at("filter_machine.json")).contains(key)) << key;
  for (const char* part : {"N = 10: 90 unknowns, 100 particles", "on 1 thread ", "on 2 threads ",
                           peers() > 0 ? "; OpenBLAS " : "OpenBLAS on 1 thread: it was not installed"})
    EXPECT_TRUE(has(ended.out, part)) << part << " is not in\n" << ended.out;
  for (const auto& [name, bytes] : files) EXPECT_FALSE(name.ends_with(".tmp")) << name;
  if (has(ended.err, "gnuplot")) GTEST_SKIP() << ended.err;
  EXPECT_EQ(files.at("filter.png").substr(1, 3), "PNG");
  EXPECT_TRUE(has(files.at("filter.svg"), "</svg>"));
}

TEST(BenchFilter, MeasuresOnlyTheSelectedKernel) {
  const TemporaryFolder folder;
  ASSERT_EQ(bench_filter({"--n", "6", "--threads", "1", "--kernel", "sparse"}, folder).status, 0);
  const Json rows = Json::parse(bytes_of(folder / "out/bench_filter/filter.json"));
  ASSERT_EQ(rows.size(), 2u) << "float and double";
  for (const Json& row : rows) EXPECT_EQ(row["kernel"], "sparse");
}

TEST(BenchFilter, FindsTheRealTimeLimitUpToTheLargestSizeGiven) {
  const TemporaryFolder folder;
  const Ended ended = bench_filter({"--n", "6,12", "--threads", "1", "--kernel", "step"}, folder);
  ASSERT_EQ(ended.status, 0) << ended.err;
  const Json rows = Json::parse(bytes_of(folder / "out/bench_filter/filter.json"));
  expect_whole_filter(rows);
  ASSERT_EQ(rows.size(), 2u) << ended.out;
  EXPECT_EQ(rows[0]["kernel"], "dense step");
  EXPECT_EQ(rows[1]["kernel"], "sparse step");
  for (const Json& row : rows) {
    EXPECT_EQ(row["side"], 12) << "144 particles take far less than a frame";
    EXPECT_EQ(row["at_cap"], true);
    EXPECT_LE(row["ms"], kFrameMs);
    EXPECT_LT(row["relative_error"], most_error("float"));
  }
}

TEST(BenchFilter, LeavesOpenBlasOutIfItsThreadsWouldShareACore) {
  if (peers() == 0) GTEST_SKIP() << "OpenBLAS was not installed";
  const TemporaryFolder folder;
  setenv("OMP_PROC_BIND", "true", 1);
  const Ended ended = bench_filter({"--n", "6", "--threads", "2", "--kernel", "dense"}, folder);
  unsetenv("OMP_PROC_BIND");
  ASSERT_EQ(ended.status, 0) << ended.err;
  EXPECT_EQ(Json::parse(bytes_of(folder / "out/bench_filter/filter.json")).size(), 3u);
  EXPECT_TRUE(has(ended.out, "left out: OpenBLAS on 2 threads: OMP_PROC_BIND ")) << ended.out;
}

TEST(BenchFilter, RefusesInvalidOptionsAndWritesNothing) {
  const TemporaryFolder folder;
  const std::string see = "; see malha bench filter --help\n";
  const std::vector<std::pair<std::vector<std::string>, std::string>> slips{
      {{"--n", "2"}, "malha bench filter: --n: found \"2\"; allowed: a whole number from 3 to 2000" + see},
      {{"--n", "17,many"}, "malha bench filter: --n: found \"many\"; allowed: a whole number from 3 to 2000" + see},
      {{"--kernel", "densest"},
       "malha bench filter: --kernel: found \"densest\" (did you mean 'dense'?); allowed: dense, sparse, step" + see},
      {{"--threads", "0"}, "malha bench filter: --threads: found \"0\"; allowed: a whole number from 1 to 1024" + see},
      {{"--repeats", "0"}, "malha bench filter: --repeats: found \"0\"; allowed: a whole number from 1 to 1000" + see},
      {{"--seconds", "-1"}, "malha bench filter: --seconds: found \"-1\"; allowed: a number > 0 (s)" + see},
      {{"--kernels", "dense"},
       "malha bench filter: found \"--kernels\" (did you mean '--kernel'?); allowed: the options of malha bench "
       "filter" +
           see}};
  for (auto [words, answer] : slips) {
    words.insert(words.begin(), {"bench", "filter"});
    const Ended ended = malha_command(words, folder / ".");
    EXPECT_EQ(ended.status, 2);
    EXPECT_EQ(ended.err, answer);
    EXPECT_EQ(ended.out, "");
  }
  EXPECT_TRUE(files_in(folder / ".").empty());
}

TEST(BenchFilter, FailsBeforeMeasuringIfItCannotWrite) {
  const TemporaryFolder folder;
  folder.write("file", "not a folder");
  const Ended ended = bench_filter({"--n", "5", "--out", "file/out"}, folder);
  EXPECT_EQ(ended.status, 4);
  EXPECT_EQ(ended.err, "malha: file/out: cannot make the folder: Not a directory\n");
  EXPECT_EQ(ended.out, "");
}

TEST(BenchFilterCase, AllVariantsSolveTheSystem) {
  FilterCase which(12, 1);
  std::vector<std::string> left_out;
  const std::vector<ProductVariant> all = which.variants(1, true, true, left_out);
  ASSERT_EQ(all.size(), 5 + peers());
  const SpringSystem& system = which.system();
  std::vector<double> forces;
  for (int i = 0; i < 3 * system.count(); ++i) forces.push_back(std::sin(i + 1.0));
  for (const ProductVariant& one : all) {
    // A S F = F, to the precision of the stored S.
    const double error = relative_difference(multiply(system, one.apply(forces)), forces);
    EXPECT_LT(error, most_error(one.row.storage)) << one.row.kernel << " " << one.row.storage;
  }
  EXPECT_EQ(left_out.size(), peers() > 0 ? 0u : 1u);
}

TEST(BenchFilterCase, CountsTheBytesThatAProductReads) {
  FilterCase which(17, 1);
  std::vector<std::string> left_out;
  const double n = 272;
  for (const ProductVariant& one : which.variants(1, true, false, left_out)) {
    const std::string& kernel = one.row.kernel;
    const double number = one.row.storage == "double" ? 8 : one.row.storage == "float" ? 4 : 2;
    const double triangle = n * (n + 1) / 2 * number;
    if (kernel == "dense") {
      EXPECT_GE(one.row.bytes, triangle);
      EXPECT_LE(one.row.bytes, 1.1 * triangle) << "the padding of the diagonal's blocks";
    } else {
      EXPECT_EQ(one.row.bytes, kernel == "sgemm" ? 4 * n * n : kernel == "ssymm" ? triangle : 3 * triangle) << kernel;
    }
  }
}

TEST(LargestSide, IsFoundToTwoPercentForAnyPower) {
  for (const double power : {1.5, 2.3, 4.0})
    for (const int wanted : {3, 4, 57, 100, 316, 900}) {
      int tries = 0;
      const int side = largest_side(3, 100, 1000, 3, [&](int at) {
        ++tries;
        return kFrameMs * std::pow(at / (wanted + 0.5), power);
      });
      EXPECT_LE(side, wanted);
      EXPECT_GE(side, std::floor(wanted / 1.021)) << power;
      EXPECT_LE(tries, 14) << wanted << " " << power;
    }
}

TEST(LargestSide, MayBeTheCapOrNone) {
  EXPECT_EQ(largest_side(3, 100, 1000, 4, [](int) { return 1.0; }), 1000);
  EXPECT_EQ(largest_side(3, 100, 1000, 4, [](int) { return 1e3; }), 0);
  EXPECT_EQ(largest_side(3, 100, 7, 4, [](int) { return 1.0; }), 7) << "the guess is above the cap";
}

FilterRow row_of(const std::string& kernel, int side, std::vector<double> seconds) {
  FilterRow row;
  row.kernel = kernel, row.storage = "float";
  row.side = side, row.n = side * (side - 1);
  row.seconds = std::move(seconds);
  if (kernel == "dense" || kernel == "sparse") row.read_seconds = row.triad_seconds = {4e-3, 1e-3, 1e-3};
  return row;
}

TEST(BenchFilterRow, ComparesTurnByTurn) {
  FilterRow dense = row_of("dense", 46, {8e-3, 2e-3, 2e-3});
  const FilterRow blas = row_of("sgemm", 46, {80e-3, 20e-3, 10e-3});
  dense.bytes = 6e6;
  EXPECT_DOUBLE_EQ(times_as_fast(dense, blas), 10) << "the first turn was slow for both";
  EXPECT_DOUBLE_EQ(dense.ms(), 2);
  EXPECT_DOUBLE_EQ(dense.gb_per_s(), 3);
  EXPECT_DOUBLE_EQ(dense.part_of_read_bandwidth(), 0.5);
  EXPECT_DOUBLE_EQ(dense.times_triad(), 2);
}

TEST(BenchFilterTable, SaysWhichPromisesAreMet) {
  std::vector<FilterRow> rows{row_of("dense", 46, {1e-3, 1e-3, 1e-3}), row_of("sgemm", 46, {6e-3, 6e-3, 6e-3}),
                              row_of("ssymm", 46, {9e-3, 9e-3, 9e-3}), row_of("ssymv", 46, {2e-3, 2e-3, 2e-3}),
                              row_of("sparse", 316, {5e-3, 5e-3, 5e-3})};
  rows[0].bytes = 2e6, rows[4].threads = 2;
  std::string text = promise_lines(rows, 3e6);
  EXPECT_TRUE(has(text, " 6.00 x as fast as the better of sgemm and ssymm, at least 5: met\n")) << text;
  EXPECT_TRUE(has(text, " 2.00 x as fast as three ssymv, at least 3: NOT MET\n")) << text;
  EXPECT_TRUE(has(text, " 5.00 ms, at most 4 (5.00 x a triad over as many bytes): NOT MET\n")) << text;
  EXPECT_FALSE(has(text, "reading")) << "it fits into the cache: " << text;
  text = promise_lines(rows, 1e6);
  EXPECT_TRUE(has(text, "100 % of the bandwidth of reading, at least 85: met\n")) << text;
}

TEST(BenchFilterTable, FindsTheCrossoverBetweenTwoSizes) {
  const auto at = [](const std::string& kernel, int side, double ms) { return row_of(kernel, side, {ms, ms, ms}); };
  // Dense is twice as fast as sparse at 90 unknowns, and half as fast at 9,900: equal in the middle on logarithmic
  // scales.
  const std::vector<FilterRow> rows{at("dense", 10, 1), at("sparse", 10, 2), at("dense", 100, 8), at("sparse", 100, 4)};
  EXPECT_TRUE(has(crossover(rows),
                  "on 1 thread sparse is the faster one from about 9.4e+02 unknowns on (measured at "
                  "90 and 9900)\n"))
      << crossover(rows);
  EXPECT_TRUE(has(crossover({rows[0], rows[1]}), "dense is the faster one at every size"));
  EXPECT_TRUE(has(crossover({rows[2], rows[3]}), "sparse is the faster one from the smallest size on"));
  EXPECT_EQ(crossover({rows[0]}), "");
}

TEST(Streams, MoveAnyNumberOfBytes) {
  for (const int threads : {1, 2, 3})
    for (const std::size_t bytes : {std::size_t(1), std::size_t(1000), std::size_t(1) << 20}) {
      const Streams streams(bytes, threads);
      for (const double time : {streams.read(bytes), streams.triad(bytes), streams.read(bytes / 2 + 1)})
        EXPECT_TRUE(std::isfinite(time) && time > 0) << bytes << " bytes on " << threads;
    }
}

TEST(Pinned, RestoresTheAffinityOfThreads) {
  cpu_set_t before, during, after;
  sched_getaffinity(0, sizeof before, &before);
  if (CPU_COUNT(&before) < 2) GTEST_SKIP() << "one core";
  {
    const Pinned pinned(2);
    sched_getaffinity(0, sizeof during, &during);
  }
  sched_getaffinity(0, sizeof after, &after);
  EXPECT_EQ(CPU_COUNT(&during), 1);
  EXPECT_TRUE(CPU_EQUAL(&before, &after));
}

}  // namespace
}  // namespace malha::bench
