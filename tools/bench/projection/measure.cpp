// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/projection/measure.h"

#include <algorithm>

#include "host/base/build_info.h"
#include "host/base/hash.h"
#include "host/solver/solver.h"
#include "malha/simulation.h"
#include "malha/text.h"
#include "tools/bench/medians.h"
#include "tools/bench/peers/bullet.h"

namespace malha::bench {

namespace {

constexpr Schedule kSchedules[] = {{10, 1}, {1, 10}, {10, 1, true}};

/// A simulation that is measured in turns with others: its row, its step, and how the row gets strain and state hash.
struct Runner {
  Row row;
  std::function<void()> step;
  std::function<void(Row&)> read_state;
};

Runner malha_runner(const Case& which, const Schedule& schedule, const RunsOn& on, int threads) {
  const auto simulation =
      std::make_shared<Simulation>(hanging_cloth(which, schedule), on.simulation_options(threads, false));
  Runner runner;
  runner.row.backend = on.backend;
  runner.row.library = "malha", runner.row.version = version();
  runner.row.schedule = schedule, runner.row.threads = threads;
  runner.row.particles = simulation->model().count();
  for (const SetStats& set : simulation->solver().facts().sets) runner.row.constraints += set.constraints;
  runner.row.projections = simulation->solver().facts().projections_per_step;
  runner.row.levels = static_cast<int>(simulation->solver().facts().levels.size());
  const RunTimes& times = simulation->times();
  runner.row.setup_seconds = setup_parts(simulation->model(), simulation->solver().facts());
  runner.row.setup_seconds.emplace_back("total", times.model_seconds + times.solver_seconds);
  runner.row.memory = memory_parts(simulation->model(), simulation->solver().facts());
  runner.step = [simulation] { simulation->step(); };
  runner.read_state = [simulation](Row& row) {
    const Measures measures = simulation->measure();
    row.strain = {measures.strain_rms, measures.strain_max};
    row.state_hash = simulation->state_hash();
  };
  return runner;
}

#if defined(MALHA_HAS_BULLET)
/// Bullet divides a step into iterations only; it has no substeps.
Runner bullet_runner(const Case& which) {
  const Schedule schedule{1, 10};
  const Scene scene = hanging_cloth(which, schedule);
  const auto cloth = std::make_shared<const Cloth>(cloth_of(scene));
  const auto soft = std::make_shared<BulletCloth>(*cloth, scene.gravity, schedule.iterations);
  Runner runner;
  runner.row.library = "bullet", runner.row.version = bullet_version();
  runner.row.schedule = schedule;
  runner.row.particles = static_cast<std::int64_t>(cloth->points.size());
  runner.row.constraints = static_cast<std::int64_t>(cloth->links.size());
  runner.row.projections = runner.row.constraints * schedule.projections();
  runner.step = [soft, dt = scene.solver.dt] { soft->step(dt); };
  runner.read_state = [soft, cloth](Row& row) {
    const std::vector<Vec3> positions = soft->positions();
    row.strain = strain(*cloth, positions);
    row.state_hash = hash_bytes(positions.data(), positions.size() * sizeof(Vec3));
  };
  return runner;
}
#else
Runner bullet_runner(const Case&) { return {}; }
#endif

std::string title_of(const Row& row) { return row.library + " " + row.schedule.name() + " on " + executor_of(row); }

}  // namespace

std::size_t lines_of_malha(const std::vector<int>& threads) { return std::size(kSchedules) * threads.size(); }

#if !defined(MALHA_HAS_BULLET)
std::string bullet_version() { return ""; }
#endif

std::string bullet_left_out(const Case& which) {
  if (bullet_version().empty()) return "it was not installed when malha was built (Debian: libbullet-dev)";
  return which.side > 500 ? "its warm-up alone would take minutes" : "";
}

std::vector<Row> measure(Case which, const MeasuringOptions& timing,
                         const std::function<void(const std::string&, double)>& show_progress) {
  show_progress("setting up", 0);
  std::vector<Runner> runners;
  for (const Schedule& schedule : kSchedules) {
    for (const int threads : timing.threads) {
      Runner runner = malha_runner(which, schedule, timing.on, threads);
      if (schedule.levels && runner.row.levels == 0) break;  // "auto" makes none here: the rows would repeat others
      runners.push_back(std::move(runner));
    }
  }
  if (bullet_left_out(which).empty()) runners.push_back(bullet_runner(which));
  which.folder.reset();

  const double turns = static_cast<double>(runners.size()) * (timing.repeats + 1);
  double turn = 0;
  for (Runner& runner : runners) {
    show_progress("warm-up: " + title_of(runner.row), turn++ / turns);
    for (int k = 0; k < kWarmUpSteps; ++k) runner.step();
    runner.read_state(runner.row);
  }
  for (int repeat = 1; repeat <= timing.repeats; ++repeat)
    for (Runner& runner : runners) {
      show_progress("repeat " + std::to_string(repeat) + ": " + title_of(runner.row), turn++ / turns);
      runner.row.step_seconds.push_back(mean_seconds(runner.step, timing.seconds));
    }

  std::vector<Row> rows;
  for (Runner& runner : runners) {
    runner.row.case_name = which.name, runner.row.n = which.n, runner.row.side = which.side;
    rows.push_back(std::move(runner.row));
  }
  return rows;
}

namespace {

// Bytes per particle: the first iteration reads x with its rounding remainder, v and w, and writes all but w. Each
// further one reads x, w and the displacement, and writes the displacement.
constexpr double kRead = 40, kWritten = 36;
constexpr double kReadAgain = 40, kWrittenAgain = 12;

/// Bytes per constraint: a grid's pattern yields the particles of its constraints, and all of them share a few rest
/// lengths.
double constraint_bytes(const Row& row) { return row.case_name == "grid" ? 0 : 8; }

}  // namespace

double working_set_bytes(const Row& row) {
  return static_cast<double>(row.particles) * kRead + static_cast<double>(row.constraints) * constraint_bytes(row);
}

void set_floor(Row& row, double triad_gb_per_s, double root_ns, int cores) {
  row.working_set_bytes = working_set_bytes(row);
  row.triad_gb_per_s = triad_gb_per_s;
  const int iterations = row.schedule.iterations, substeps = row.schedule.substeps;
  const double each = kRead + kWritten + (iterations - 1) * (kReadAgain + kWrittenAgain);
  const double bytes = static_cast<double>(row.particles) * each +
                       static_cast<double>(row.constraints) * iterations * constraint_bytes(row);
  row.floor_memory_ns = bytes * substeps / static_cast<double>(row.projections) / triad_gb_per_s;
  row.floor_operations_ns = row.on_device() ? 0 : root_ns / std::min(row.threads, cores);
}

}  // namespace malha::bench
