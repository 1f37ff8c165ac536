#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <set>
#include <sstream>

#include "host/base/near_miss.h"
#include "host/base/text.h"
#include "host/error.h"
#include "host/model/machine.h"
#include "host/model/model.h"
#include "host/report/plan_passes.h"
#include "host/report/ranks.h"
#include "host/report/report.h"
#include "host/solver/solver.h"

namespace malha {

namespace {

/// The fastest step, s: others may have shared the cores with other programs.
struct StepTimes {
  int steps = 0, threads = 1;  // steps that were taken
  double sweeps = 0;           // projections, and what is done in the same visits; without levels
  double particles = 0;        // prediction and state, where they are passes of their own
  double step = 0;
};

StepTimes take_step(Simulation& simulation) {
  const auto passes = [&](std::initializer_list<Pass> which) {
    double sum = 0;
    for (const Pass pass : which) sum += simulation.solver().pass_seconds()[static_cast<int>(pass)];
    return sum;
  };
  const auto now = [&] {
    const std::vector<double> levels = simulation.solver().seconds_of_levels();
    // Those of levels lie within those of the visits, where prediction and state are in them.
    const double within = simulation.solver().facts().fused ? std::accumulate(levels.begin(), levels.end(), 0.0) : 0;
    return std::array{passes({Pass::Visits, Pass::Projection}) - within, passes({Pass::Prediction, Pass::State})};
  };
  const auto before = now();
  const int alone = simulation.times().steps_alone;
  simulation.wake();  // asleep, it would do nothing
  simulation.step();
  const auto after = now();
  return {.steps = 1,
          .threads = simulation.times().steps_alone > alone ? 1 : simulation.threads(),
          .sweeps = after[0] - before[0],
          .particles = after[1] - before[1],
          .step = simulation.times().steps.last()};
}

/// For about a second: on all threads or on one, as steps are faster here.
StepTimes time_steps(Simulation& simulation) {
  constexpr double enough = 1;  // s
  constexpr int least = 5, most = 1000;
  StepTimes fastest;
  int steps = 0;
  for (double spent = 0; steps < least || (spent < enough && steps < most); ++steps) {
    const StepTimes now = take_step(simulation);
    spent += now.step;
    if (steps == 0 || now.sweeps + now.particles < fastest.sweeps + fastest.particles) fastest = now;
  }
  fastest.steps = steps;
  return fastest;
}

/// A sheet's borders grow as the root of its particles, a solid's as their surface; those of lines stay.
double growth_of_borders(const Model& model) {
  std::vector<bool> solid(model.count(), false);
  for (const auto& body : model.tetrahedra)
    for (const Tetrahedron& tetrahedron : body)
      for (const int i : tetrahedron) solid[i] = true;
  if (2 * std::count(solid.begin(), solid.end(), true) > model.count()) return 2.0 / 3;
  return model.look.faces.empty() ? 0 : 0.5;
}

int reductions_of(const Model& model, const SolverFacts& facts) {
  const int substeps = model.scene.solver.substeps, iterations = substeps * model.scene.solver.iterations;
  const bool looks = facts.edges || model.scene.self_collision || !model.environment.empty();
  int sum = looks ? substeps : 1;  // whether a particle has no finite position any more
  if (!model.damped.empty()) sum += substeps;
  if (!model.free.empty())  // before and after; and, where nothing else does, at the end
    sum += !facts.fused ? 2 * iterations + 1 : 2 * (facts.whole_steps ? 1 : substeps);
  sum += 2 * (substeps + iterations) * static_cast<int>(model.pressures.size());
  if (model.scene.sleep) ++sum;
  if (facts.flies) ++sum;
  return sum;
}

bool is_counted(const std::string& pass) {
  for (const char* counted : {"visits of prediction, projection and state", "projection", "prediction", "state",
                              "while nothing comes near the environment"})
    if (pass == counted) return true;
  return false;
}

std::string line_of(const char* format, auto... values) {
  char line[200];
  std::snprintf(line, sizeof line, format, values...);
  return line;
}

std::string rounded(double number) {
  if (number < 1) return "1";
  const double digit = std::pow(10, std::floor(std::log10(number)) - 1);
  return line_of("%.0f", std::round(number / digit) * digit);
}

std::string from(double particles) {
  return std::isinf(particles) ? "at no size" : "from " + rounded(particles) + " particles on";
}

/// From which size on more machines pay, and why not below.
void list_sizes(std::ostream& out, const RankTable& table) {
  const RankRow &two = table.rows[1], &all = table.rows.back();
  const int ranks = all.counts.ranks;
  const auto size = [&](const RankRow& row, double faster) {
    return from(particles_that_pay(table.scaling, row.seconds, row.counts.ranks, faster));
  };
  out << "  a body of this shape: 2 ranks are faster than 1 " << size(two, 1);
  if (ranks > 2) out << ", " << ranks << " " << size(all, 1);
  const double faster = ranks > 2 ? ranks / 2.0 : 1.5;
  out << "; " << ranks << line_of(" are %g times as fast ", faster) << size(all, faster) << "\n"
      << "    below, a step has less to save than its visits take at the least: "
      << line_of("%.3g ms, of one patch a phase, and %.3g ms of latency\n", table.scaling.patches * 1e3,
                 all.seconds.latency * 1e3)
      << "    by these times, if work is even, "
      << (table.scaling.growth == 0   ? "borders stay"
          : table.scaling.growth < .6 ? "borders grow as the root of the particles"
                                      : "borders grow as the particles to the power 2/3")
      << ", and latency, visits and the particles of a patch stay\n";
}

void list_rows(std::ostream& out, const RankTable& table) {
  out << "  ranks  border particles  messages/substep  KiB/substep  imbalance  ms/step: work  latency   bytes      all "
         " "
         "faster\n";
  const double alone = table.rows.front().seconds.sum();
  for (const auto& [counts, seconds] : table.rows) {
    std::int64_t messages = 0, bytes = 0;
    for (const RankVisit& visit : counts.visits)
      messages += visit_messages(visit, table.shape), bytes += visit_bytes(visit, table.shape);
    out << line_of("  %5d  %16d  %16lld  %11.1f  %9.2f", counts.ranks, counts.border, static_cast<long long>(messages),
                   static_cast<double>(bytes) / 1024, counts.imbalance())
        << line_of("  %13.3f  %7.3f  %6.3f  %7.3f  %6.2f\n", seconds.work * 1e3, seconds.latency * 1e3,
                   seconds.bytes * 1e3, seconds.sum() * 1e3, seconds.sum() > 0 ? alone / seconds.sum() : 1);
  }
}

const char* way_of(const PhaseVisit& visit) { return !visit.back ? "there" : !visit.there ? "back" : "both"; }

void list_visits(std::ostream& out, const RankTable& table) {
  const RankCounts& counts = table.rows.back().counts;
  const std::set<int> busy(counts.rank_of.begin(), counts.rank_of.end());
  const int idle = counts.ranks - static_cast<int>(busy.size());
  out << "  visits of " << counted(counts.ranks, "rank")
      << (idle > 0 ? ", " + std::to_string(idle) + " without a patch" : "") << ", in a substep:\n"
      << "  phase    way  patches  projections  particles sent  messages    KiB  imbalance      us\n";
  const std::int64_t iterations = table.shape.iterations;
  for (const RankVisit& visit : counts.visits) {
    const int patches = std::accumulate(visit.patches.begin(), visit.patches.end(), 0);
    const auto projections = std::accumulate(visit.projections.begin(), visit.projections.end(), std::int64_t{0});
    out << line_of("  %5d  %5s  %7d  %11lld  %14lld  %8lld", visit.visit.phase + 1, way_of(visit.visit), patches,
                   static_cast<long long>(iterations * projections),
                   static_cast<long long>(iterations * visit.travelling()),
                   static_cast<long long>(visit_messages(visit, table.shape)))
        << line_of("  %5.1f  %9.2f  %6.1f\n", static_cast<double>(visit_bytes(visit, table.shape)) / 1024,
                   visit.imbalance(), visit_seconds(visit, table.machines, table.shape) * 1e6);
  }
}

void list_not_counted(std::ostream& out, const RankTable& table) {
  out << "  " << counted(table.shape.reductions, "all-reduce") << " a step, of latency times log2 of the ranks each\n";
  if (table.not_counted.empty()) return;
  out << "  not counted but for their all-reduces: " << join(table.not_counted);
  if (table.steps > 0) {
    out << line_of(", %.3g of a step's %.3g ms here", table.not_counted_ms, table.step_ms);
    const double rest = table.not_counted_ms, alone = table.rows.front().seconds.sum() * 1e3;
    if (table.rows.size() > 1)
      out << line_of(": if that did not get faster, %d ranks would be %.2f times as fast as one",
                     table.rows.back().counts.ranks, (rest + alone) / (rest + table.rows.back().seconds.sum() * 1e3));
  }
  out << "\n";
}

}  // namespace

StepShape shape_of(const Simulation& simulation) {
  const Model& model = simulation.model();
  const SolverSpec& solver = model.scene.solver;
  const SolverFacts& facts = simulation.solver().facts();
  return {.substeps = solver.substeps,
          .iterations = solver.iterations,
          .number_bytes = bytes_of_number(solver.precision),
          .reductions = reductions_of(model, facts)};
}

void require_ranks(const Simulation& simulation, int ranks) {
  const Model& model = simulation.model();
  const int patches = simulation.solver().facts().patches.patches;
  if (model.scene.solver.type == "desbrun")
    refuse("malha plan", "--ranks", "the solver \"desbrun\"",
           "pbd; the filter of Desbrun's method is a triangular solve over whole bodies, which patches do not part");
  if (ranks < 1 || ranks > patches)
    refuse("malha plan", "--ranks", std::to_string(ranks),
           "1 to " + std::to_string(patches) + ", the scene's patches: a rank has whole ones");
}

RankTable plan_ranks(Simulation& simulation, const RankOptions& options) {
  require_ranks(simulation, options.ranks);
  const Model& model = simulation.model();
  const PatchPlan plan = plan_patches(model, simulation.threads());
  RankTable table;
  table.shape = shape_of(simulation);
  table.patches = static_cast<int>(plan.patches.size()), table.phases = plan.phases();
  for (const PassOfAStep& pass : passes_of_a_step(model, simulation.solver().facts()))
    if (!is_counted(pass.name)) table.not_counted.push_back(pass.name);
  RankMachines& machines = table.machines;
  machines.gbit = options.gbit, machines.latency_us = options.latency_us,
  machines.threads = table.threads = simulation.threads();
  if (!options.projection_ns || !options.particle_ns) {
    const StepTimes times = time_steps(simulation);
    table.steps = times.steps, machines.threads = times.threads, table.step_ms = times.step * 1e3;
    table.not_counted_ms = std::max(0.0, times.step - times.sweeps - times.particles) * 1e3;
    const RankCounts one = deal_ranks(model, plan, 1, machines.threads);
    double busy = 0, movable = one.particles[0];
    for (const RankVisit& visit : one.visits) busy += static_cast<double>(visit.busy[0]);
    busy *= table.shape.substeps * table.shape.iterations, movable *= table.shape.substeps;
    machines.projection_ns = busy > 0 ? times.sweeps / busy * 1e9 : 0;
    machines.particle_ns = movable > 0 ? (times.particles + (busy > 0 ? 0 : times.sweeps)) / movable * 1e9 : 0;
  }
  machines.projection_ns = options.projection_ns.value_or(machines.projection_ns);
  machines.particle_ns = options.particle_ns.value_or(machines.particle_ns);
  for (int ranks = 1;; ranks = std::min(2 * ranks, options.ranks)) {
    RankRow row{deal_ranks(model, plan, ranks, machines.threads), {}};
    row.seconds = step_seconds(row.counts, machines, table.shape);
    table.rows.push_back(std::move(row));
    if (ranks == options.ranks) break;
  }
  const double alone = table.rows.front().seconds.sum();
  const double most = static_cast<double>(table.patches) / (table.phases * machines.threads);  // that have work
  table.scaling = {static_cast<double>(model.count()), growth_of_borders(model), alone, alone / std::max(1.0, most)};
  return table;
}

std::string list_ranks(const RankTable& table) {
  const RankMachines& machines = table.machines;
  std::ostringstream out;
  out << "on several machines (an estimate), of " << counted(machines.threads, "thread") << " each"
      << (machines.threads < table.threads ? ", which is faster here now than " + std::to_string(table.threads) : "")
      << ", with " << shown(machines.gbit) << " Gbit/s and " << shown(machines.latency_us) << " us a message:\n"
      << line_of("  %.3g ns a projection, %.3g ns a particle and substep outside the visits: ", machines.projection_ns,
                 machines.particle_ns)
      << (table.steps > 0 ? "measured, the fastest of " + counted(table.steps, "step") : std::string("as given"))
      << "\n";
  list_rows(out, table);
  list_visits(out, table);
  if (table.rows.size() > 1) list_sizes(out, table);
  list_not_counted(out, table);
  return out.str();
}

}  // namespace malha
