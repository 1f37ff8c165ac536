// SPDX-License-Identifier: Apache-2.0
// The command malha bench projection. Speed is never asserted.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/parallel/has_cuda.h"
#include "tests/support.h"
#include "tools/bench/peers/bullet.h"
#include "tools/bench/projection/measure.h"

namespace malha::bench {
namespace {

using Json = nlohmann::json;

/// The number of Bullet's rows per case.
const std::size_t kPeers = bullet_version().empty() ? 0 : 1;

/// Sets an environment variable during the lifetime of this object.
class Environment {
 public:
  Environment(const char* name, const std::string& value) : name_(name) {
    const char* before = getenv(name);
    was_set_ = before != nullptr;
    if (was_set_) before_ = before;
    setenv(name, value.c_str(), 1);
  }
  ~Environment() { was_set_ ? setenv(name_, before_.c_str(), 1) : unsetenv(name_); }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

 private:
  const char* name_;
  bool was_set_;
  std::string before_;
};

/// Runs the benchmark as briefly as possible.
Ended bench(std::vector<std::string> words, const TemporaryFolder& folder) {
  words.insert(words.begin(), {"bench", "projection", "--seconds", "0.01", "--repeats", "1"});
  return malha_command(words, folder / ".");
}

/// Expects all keys in every row, and positive finite numbers.
void expect_whole(const Json& rows) {
  for (const Json& row : rows) {
    for (const char* key : {"case", "schedule", "library", "library_version", "state_hash"})
      EXPECT_TRUE(row.contains(key) && row[key].is_string() && row[key] != "") << key << " in " << row;
    for (const char* key :
         {"n", "particles", "constraints", "threads", "ns_per_projection", "ns_min", "ns_max", "step_ms", "strain_rms",
          "strain_max", "working_set_bytes", "triad_gb_per_s", "floor_memory_ns", "floor_operations_ns", "floor_ns",
          "times_floor", "times_as_fast_as_bullet", "times_as_fast_as_one_thread"}) {
      if (kPeers == 0 && key == std::string("times_as_fast_as_bullet")) continue;
      ASSERT_TRUE(row.contains(key) && row[key].is_number()) << key << " in " << row;
      EXPECT_TRUE(std::isfinite(row[key].get<double>()) && row[key] > 0) << key << " in " << row;
    }
    EXPECT_EQ(row.contains("setup_s"), row["library"] == "malha") << row;
    if (!row.contains("setup_s")) continue;
    for (const char* owner : {"particles", "constraints", "patches", "model"})
      EXPECT_GT(row["memory_bytes"][owner], 0) << owner << " in " << row;
    for (const char* part : {"load", "order", "build_constraints", "patches", "colour", "layout", "total"})
      EXPECT_GT(row["setup_s"][part], 0) << part << " in " << row;
  }
}

TEST(BenchProjection, PlansPatchesForTheGivenMachine) {
  const TemporaryFolder folder;
  const auto hash = [&](const std::string& machine) {
    const Ended ended = bench({"--n", "100", "--threads", "1", "--for", machine, "--json", "rows.json"}, folder);
    EXPECT_EQ(ended.status, 0) << ended.err;
    const Json row = Json::parse(bytes_of(folder / "rows.json")).at(0);
    EXPECT_EQ(row["backend"], "openmp");
    return row["state_hash"].get<std::string>();
  };
  EXPECT_NE(hash("h200"), hash("cpu")) << "different patches lead to different bits";
}

TEST(Measuring, IsRefusedBeforeItStartsIfThereIsNoDevice) {
  if (has_cuda()) GTEST_SKIP() << "there is a device";
  const TemporaryFolder folder;
  for (std::vector<std::string> words : {std::vector<std::string>{"bench", "projection"},
                                         {"bench", "filter", "--kernel", "step"},
                                         {"bench", "self"},
                                         {"bench", "contact"},
                                         {"bench", "constraints"},
                                         {"study", "accuracy"},
                                         {"study", "scaling", "--quick"}}) {
    words.insert(words.end(), {"--backend", "cuda", "--out", "results"});
    const Ended ended = malha_command(words, folder / ".");
    EXPECT_EQ(ended.status, 2) << words[1];
    EXPECT_TRUE(ended.err.starts_with("backend: found ") && std::ranges::count(ended.err, '\n') == 1) << ended.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "results"));
  }
}

TEST(Floor, OfADeviceIsThatOfItsMemory) {
  Row row;
  row.case_name = "grid", row.particles = 100, row.constraints = 200, row.schedule = {10, 1}, row.backend = "cuda";
  row.projections = 10 * 2 * 200;
  set_floor(row, 1000, 5, 8);
  EXPECT_EQ(row.floor_operations_ns, 0);
  EXPECT_DOUBLE_EQ(row.floor_ns(), 76.0 / 4 / 1000) << "76 bytes per particle and 4 projections, at 1,000 GB/s";
}

TEST(BenchProjection, WritesARowForEveryScheduleAndLibrary) {
  const TemporaryFolder folder;
  const Ended ended = bench({"--n", "17", "--threads", "2,1", "--json", "rows/rows.json"}, folder);
  ASSERT_EQ(ended.status, 0) << ended.err;
  const Json rows = Json::parse(bytes_of(folder / "rows/rows.json"));
  expect_whole(rows);
  std::vector<std::string> who{"malha 10x1 1", "malha 10x1 2",        "malha 1x10 1",
                               "malha 1x10 2", "malha 10x1 levels 1", "malha 10x1 levels 2"};
  if (kPeers == 1) who.push_back("bullet 1x10 1");
  ASSERT_EQ(rows.size(), who.size()) << "malha's three schedules on two numbers of threads, and Bullet if it was found";
  for (std::size_t k = 0; k < who.size(); ++k) {
    const Json& row = rows[k];
    EXPECT_EQ(
        row["library"].get<std::string>() + " " + row["schedule"].get<std::string>() + " " + row["threads"].dump(),
        who[k]);
    EXPECT_EQ(row["case"], "grid");
    EXPECT_EQ(row["n"], 17);
    EXPECT_EQ(row["constraints"], 4 * 16 * 16 + 2 * 16 - 16) << "4 per cell, two borders, minus those between pins";
  }
  EXPECT_EQ(rows[0]["state_hash"], rows[1]["state_hash"]);
  EXPECT_EQ(rows[2]["state_hash"], rows[3]["state_hash"]);
  EXPECT_EQ(rows[4]["state_hash"], rows[5]["state_hash"]);
  EXPECT_NE(rows[0]["state_hash"], rows[2]["state_hash"]);
  EXPECT_NE(rows[0]["state_hash"], rows[4]["state_hash"]);

  const auto files = files_in(folder / "out/bench_projection");
  EXPECT_EQ(files.at("projection.json"), bytes_of(folder / "rows/rows.json"));
  EXPECT_EQ(ended.out.find(files.at("projection.txt")), 0u) << "the table is what was printed";
  for (const char* key : {"compiler", "flags", "instructions", "cpu", "triad_gb_per_s", "root_and_quotient_ns"})
    EXPECT_TRUE(Json::parse(files.at("projection_machine.json")).contains(key)) << key;
  for (const char* part :
       {"grid, N = 17: 289 particles, 1040 constraints", "  set-up on 2 threads: load ", "  memory: particles ",
        "  10x1 on 2 threads: ", kPeers == 1 ? " as Bullet" : "Bullet is left out: it was not installed"})
    EXPECT_TRUE(has(ended.out, part)) << part << " is not in\n" << ended.out;
  for (const auto& [name, bytes] : files) EXPECT_FALSE(name.ends_with(".tmp")) << name;
  if (has(ended.err, "gnuplot")) GTEST_SKIP() << ended.err;
  EXPECT_EQ(files.at("projection.png").substr(1, 3), "PNG");
  EXPECT_TRUE(has(files.at("projection.svg"), "</svg>"));
}

/// With 11 edges from the pins to the other end "auto" makes no levels, with 12 it does.
TEST(BenchProjection, MeasuresLevelsOnlyIfACaseHasThem) {
  const TemporaryFolder folder;
  const Ended ended = bench({"--n", "12,13", "--threads", "1"}, folder);
  ASSERT_EQ(ended.status, 0) << ended.err;
  std::vector<std::string> who;
  for (const Json& row : Json::parse(bytes_of(folder / "out/bench_projection/projection.json")))
    if (row["library"] == "malha") who.push_back(row["n"].dump() + " " + row["schedule"].get<std::string>());
  EXPECT_EQ(who, (std::vector<std::string>{"12 10x1", "12 1x10", "13 10x1", "13 1x10", "13 10x1 levels"}));
}

/// Levels reduce the large strain of a cloth whose particles are far from the pins.
TEST(BenchProjection, ComparesLevelsWithTheSameStepWithoutThem) {
  const TemporaryFolder folder;
  const Ended ended = bench({"--n", "100", "--threads", "1"}, folder);
  ASSERT_EQ(ended.status, 0) << ended.err;
  const Json rows = Json::parse(bytes_of(folder / "out/bench_projection/projection.json"));
  ASSERT_EQ(rows.size(), 3 + kPeers);
  const Json &plain = rows[0], &levels = rows[2];
  EXPECT_EQ(plain["schedule"], "10x1");
  EXPECT_EQ(plain["levels"], 0);
  EXPECT_EQ(levels["schedule"], "10x1 levels");
  EXPECT_GT(levels["levels"], 2);
  EXPECT_EQ(levels["constraints"], plain["constraints"]) << "only those of the cloth itself";
  EXPECT_GT(levels["times_the_step_without_levels"], 0);
  EXPECT_FALSE(plain.contains("times_the_step_without_levels"));
  EXPECT_LT(levels["strain_rms"].get<double>(), plain["strain_rms"].get<double>() / 3);
  EXPECT_LT(levels["strain_max"].get<double>(), plain["strain_max"].get<double>() / 3);
  EXPECT_GT(levels["memory_bytes"]["levels"], 0);
  EXPECT_GT(levels["setup_s"]["levels"], 0);
  EXPECT_TRUE(has(ended.out, "  levels on 1 thread: ")) << ended.out;
}

TEST(BenchProjection, RunsWithoutGnuplotAndReportsIt) {
  const TemporaryFolder folder;
  const Environment path("PATH", folder / ".");
  folder.write("projection.png", "of an earlier run");
  const Ended ended = bench({"--n", "5", "--threads", "1", "--out", "."}, folder);
  EXPECT_EQ(ended.status, 0);
  EXPECT_EQ(ended.err, "malha bench: no chart: gnuplot is not installed (Debian: gnuplot-nox)\n");
  std::vector<std::string> names;
  for (const auto& file : files_in(folder / ".")) names.push_back(file.first);
  EXPECT_EQ(names, (std::vector<std::string>{"projection.json", "projection.txt", "projection_machine.json"}));
}

TEST(BenchProjection, MeasuresOnlyTheIrregularMeshAndRemovesItsFile) {
  const TemporaryFolder folder, scratch;
  const Environment temporary("TMPDIR", scratch / ".");
  const Ended ended = bench({"--case", "irregular", "--n", "390", "--threads", "1"}, folder);
  ASSERT_EQ(ended.status, 0) << ended.err;
  const Json rows = Json::parse(bytes_of(folder / "out/bench_projection/projection.json"));
  expect_whole(rows);
  EXPECT_EQ(rows.size(), 3 + kPeers) << "19 edges from the pins there are levels";
  for (const Json& row : rows) {
    EXPECT_EQ(row["case"], "irregular");
    EXPECT_EQ(row["n"], 400) << "20 x 20 is nearest to 390";
    EXPECT_EQ(row["constraints"], rows[0]["constraints"]);
  }
  EXPECT_TRUE(std::filesystem::is_empty(scratch / "."));
}

TEST(BenchProjection, RefusesInvalidOptionsAndWritesNothing) {
  const TemporaryFolder folder;
  const std::string see = "; see malha bench projection --help\n";
  const std::vector<std::pair<std::vector<std::string>, std::string>> slips{
      {{"bench"},
       "malha bench: found no benchmark; allowed: projection, filter, constraints, self, contact, --help, -h\n"},
      {{"bench", "projecton"},
       "malha bench: found \"projecton\" (did you mean 'projection'?); allowed: projection, filter, constraints, self, "
       "contact, --help, -h\n"},
      {{"bench", "projection", "--n", "17,many"},
       "malha bench projection: --n: found \"many\"; allowed: a whole number from 3 to 16000000" + see},
      {{"bench", "projection", "--n", "4001"},
       "malha bench projection: --n: found \"4001\"; allowed: a whole number from 3 to 4000" + see},
      {{"bench", "projection", "--n", "8", "--case", "irregular"},
       "malha bench projection: --n: found \"8\"; allowed: a whole number from 9 to 16000000" + see},
      {{"bench", "projection", "--threads", "0"},
       "malha bench projection: --threads: found \"0\"; allowed: a whole number from 1 to 1024" + see},
      {{"bench", "projection", "--case", "grids"},
       "malha bench projection: --case: found \"grids\" (did you mean 'grid'?); allowed: grid, irregular" + see},
      {{"bench", "projection", "--seconds", "0"},
       "malha bench projection: --seconds: found \"0\"; allowed: a number > 0 (s)" + see},
      {{"bench", "projection", "--repeats", "1.5"},
       "malha bench projection: --repeats: found \"1.5\"; allowed: a whole number from 1 to 1000" + see},
      {{"bench", "projection", "scene.json"},
       "malha bench projection: found \"scene.json\"; allowed: the options of malha bench projection" + see},
      {{"bench", "projection", "--thread", "1"},
       "malha bench projection: found \"--thread\" (did you mean '--threads'?); allowed: the options of malha bench "
       "projection" +
           see}};
  for (const auto& [words, answer] : slips) {
    const Ended ended = malha_command(words, folder / ".");
    EXPECT_EQ(ended.status, 2);
    EXPECT_EQ(ended.err, answer);
    EXPECT_EQ(ended.out, "");
  }
  EXPECT_TRUE(files_in(folder / ".").empty());
}

TEST(BenchProjection, FailsBeforeMeasuringIfItCannotWrite) {
  const TemporaryFolder folder;
  folder.write("file", "not a folder");
  const Ended ended = bench({"--n", "5", "--out", "file/out"}, folder);
  EXPECT_EQ(ended.status, 4);
  EXPECT_EQ(ended.err, "malha: file/out: cannot make the folder: Not a directory\n");
  EXPECT_EQ(ended.out, "");

  std::filesystem::create_directory(folder / "rows.json");
  const Ended json = bench({"--n", "5", "--json", "rows.json"}, folder);
  EXPECT_EQ(json.status, 4);
  EXPECT_EQ(json.err, "malha: rows.json: cannot write: Is a directory\n");
  EXPECT_EQ(json.out, "");
}

TEST(BenchProjection, RefusesCasesThatDoNotFitIntoMemory) {
  std::string threads = "1";
  for (int t = 2; t <= 400; ++t) threads += "," + std::to_string(t);
  const TemporaryFolder folder;
  const Ended ended = bench({"--n", "5,4000", "--threads", threads}, folder);
  EXPECT_EQ(ended.status, 2);
  EXPECT_EQ(ended.err.find("malha bench projection: --n: found 4000, which takes about "), 0u) << ended.err;
  EXPECT_TRUE(has(ended.err, "1200 lines of 1.6e+07 particles; allowed: what fits into the ")) << ended.err;
  EXPECT_EQ(ended.out, "");
  EXPECT_TRUE(files_in(folder / ".").empty());
}

TEST(BenchProjection, KeepsFinishedCasesWhenItIsStopped) {
  const TemporaryFolder folder;
  MalhaProcess process({"bench", "projection", "--n", "5,400", "--threads", "1", "--seconds", "0.01", "--repeats", "1",
                        "--json", "rows.json"},
                       folder / ".");
  while (process.running() && !std::filesystem::exists(folder / "rows.json"))
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  process.send(SIGINT);
  EXPECT_EQ(process.wait().status, -SIGINT);
  for (const char* name : {"rows.json", "out/bench_projection/projection.json"}) {
    const Json rows = Json::parse(bytes_of(folder / name));
    expect_whole(rows);
    ASSERT_EQ(rows.size(), 2 + kPeers);
    EXPECT_EQ(rows[0]["n"], 5);
  }
  EXPECT_TRUE(has(bytes_of(folder / "out/bench_projection/projection.txt"), "grid, N = 5: "));
}

Row row_of_steps(const Schedule& schedule, int threads, std::vector<double> step_seconds) {
  Row row;
  row.case_name = "grid";
  row.particles = 100, row.constraints = 400;
  row.projections = row.constraints * schedule.projections() * 2;  // a symmetric sweep
  row.schedule = schedule, row.threads = threads;
  row.step_seconds = std::move(step_seconds);
  return row;
}

TEST(BenchRow, CountsEveryProjectionOfAStep) {
  const Row row = row_of_steps({5, 2}, 1, {3e-6, 1e-6, 2e-6});
  EXPECT_DOUBLE_EQ(row.ns_min(), 1000.0 / 8000);
  EXPECT_DOUBLE_EQ(row.ns_per_projection(), 2000.0 / 8000);
  EXPECT_DOUBLE_EQ(row.ns_max(), 3000.0 / 8000);
  EXPECT_DOUBLE_EQ(row.step_ms(), 2e-3);
}

TEST(BenchRow, ComparesTurnByTurn) {
  const Row slow = row_of_steps({10, 1}, 1, {4e-6, 40e-6, 5e-6}), fast = row_of_steps({10, 1}, 2, {2e-6, 20e-6, 2e-6});
  EXPECT_DOUBLE_EQ(times_as_fast(fast, slow), 2) << "the second turn was slow for both";
}

TEST(BenchRow, HasAFloorOfBytesOrOperations) {
  Row row = row_of_steps({10, 1}, 2, {1e-6});
  set_floor(row, 10, 0.5, 2);
  EXPECT_DOUBLE_EQ(row.working_set_bytes, 40 * 100) << "a grid's constraints need no memory";
  EXPECT_DOUBLE_EQ(row.floor_memory_ns, 76.0 / 8 / 10);
  EXPECT_DOUBLE_EQ(row.floor_operations_ns, 0.25);
  EXPECT_DOUBLE_EQ(row.floor_ns(), 0.95);
  row.case_name = "irregular", row.schedule = {1, 10};
  set_floor(row, 100, 0.5, 2);
  EXPECT_DOUBLE_EQ(row.working_set_bytes, 40 * 100 + 8 * 400);
  EXPECT_DOUBLE_EQ(row.floor_memory_ns, ((76.0 + 9 * 52) / 10 / 4 + 8) / 2 / 100);
  EXPECT_DOUBLE_EQ(row.floor_ns(), 0.25);
  row.threads = 64;
  set_floor(row, 100, 0.5, 2);
  EXPECT_DOUBLE_EQ(row.floor_operations_ns, 0.25) << "64 threads on two cores are no faster than two";
}

}  // namespace
}  // namespace malha::bench
