// SPDX-License-Identifier: Apache-2.0
#include "host/report/device_estimate.h"

#include <algorithm>
#include <cstdio>
#include <sstream>
#include <vector>

#include "host/base/spelling_suggestion.h"
#include "host/base/stopwatch.h"
#include "host/model/model.h"
#include "host/report/plan_passes.h"
#include "host/solver/graph_capture.h"
#include "host/solver/solver.h"
#include "kernels/environment/edge_truncate.h"
#include "kernels/parallel/compute.h"
#include "malha/text.h"

namespace malha {

namespace {

/// What a visit to a patch moves of its particles, in numbers. `place`: of one of them. `predicts`, `updates`: the
/// particles of which no visit was before, or is after.
double numbers_moved(const PatchPlan& plan, const Patch& patch, int place, bool predicts, bool updates) {
  double numbers = 0;
  for (int s = patch.segment; s < patch.segment + patch.segments; ++s) {
    const Segment& segment = plan.segments[s];
    const bool from_state = predicts && segment.first_solve && segment.movable;
    int each = place + 3 + 1;  // where it is, v or how far it went, and w
    if (segment.movable) {
      if (updates && segment.last_solve)
        each += place + 3 + (from_state ? 0 : 3);  // the state is written; v is read, where it was not before
      else
        each += 3;  // how far it went
    }
    numbers += double(each) * segment.count;
  }
  return numbers;
}

/// Of the constraints of a patch. `each`: bytes a slot of every set.
double constraint_bytes(const PatchPlan& plan, const Patch& patch, const std::vector<double>& each) {
  double bytes = 0;
  for (int b = patch.batch; b < patch.batch + patch.batches; ++b)
    bytes += each[plan.batches[b].set] * plan.batches[b].count;
  return bytes;
}

/// Bytes a second that all threads together read and write, at best.
double measured_bandwidth(int threads) {
  constexpr int kCount = 8 << 20;  // x 3 x 4 bytes: far beyond caches
  std::vector<float> from(3 * std::size_t(kCount), 1.0f), to(from.size(), 0.0f);
  const auto points = [](std::vector<float>& of) {
    return Points<float>{of.data(), of.data() + kCount, of.data() + 2 * kCount};
  };
  double best = 1e30;
  for (int round = 0; round < 5; ++round)
    best = std::min(best, seconds([&] {
                      parallel_for(OpenMP{threads}, kCount,
                                   CopyPoints<float, Points<float>, Points<float>>{points(from), points(to)});
                    }));
  return 2.0 * double(from.size()) * sizeof(float) / best;
}

std::string with_unit(double number, const char* const (&units)[4], double step) {
  int u = 0;
  for (; u < 3 && number >= step; ++u) number /= step;
  char text[40];
  std::snprintf(text, sizeof text, "%.3g %s", number, units[u]);
  return text;
}
std::string bytes_text(double bytes) { return with_unit(bytes, {"B", "KiB", "MiB", "GiB"}, 1024); }
std::string per_second(double bytes) { return with_unit(bytes / 1e6, {"MB/s", "GB/s", "TB/s", "PB/s"}, 1000); }

}  // namespace

SolveTraffic solve_traffic(const Model& model, const Solver& solver, const PatchPlan& plan) {
  const SolverStats& facts = solver.facts();
  const SolverSpec& spec = model.scene.solver;
  const double number = bytes_of_number(spec.precision);
  const int place = spec.precision == Precision::Float ? 6 : 3;  // and what it lacks of the position
  std::vector<double> slots(facts.sets.size(), 0), each;
  for (const Batch& batch : plan.batches) slots[batch.set] += batch.count;
  for (std::size_t s = 0; s < slots.size(); ++s)
    each.push_back(slots[s] > 0 ? static_cast<double>(facts.sets[s].bytes) / slots[s] : 0);
  SolveTraffic traffic;
  for (int iteration = 0; iteration < spec.iterations; ++iteration)
    for (const PhaseSweep& sweep : sweep_order(plan.phases())) {
      const bool predicts = facts.fused && sweep.forward && iteration == 0;
      const bool updates = facts.fused && sweep.backward && iteration + 1 == spec.iterations;
      for (int k = plan.phase_begin[sweep.phase]; k < plan.phase_begin[sweep.phase + 1]; ++k) {
        traffic.particle_bytes += number * numbers_moved(plan, plan.patches[k], place, predicts, updates);
        traffic.constraint_bytes += constraint_bytes(plan, plan.patches[k], each);
      }
    }
  traffic.particle_bytes *= spec.substeps, traffic.constraint_bytes *= spec.substeps;
  return traffic;
}

DeviceEstimate plan_for(const Simulation& simulation, const Machine& machine) {
  const Model& model = simulation.model();
  const SolverStats& facts = simulation.solver().facts();
  DeviceEstimate demand{.machine = machine};
  for (const PassOfAStep& pass : passes_of_a_step(model, facts)) {
    demand.launches += pass.launches;
    demand.launches_at_least = demand.launches_at_least || pass.at_least || !pass.remark.empty();
    if (!pass.name.starts_with("fused_solve") && pass.name != "projection") demand.not_counted.push_back(pass.name);
  }
  // A device's sums are launches of their own, and so is what it does before it asks the host about contacts.
  demand.launches_at_least = demand.launches_at_least || (machine.fast_bytes > 0 && !facts.fused);
  demand.replays = machine.fast_bytes > 0 && can_capture_step(model);
  if (facts.sets.empty()) return demand;
  const PatchPlan plan = plan_patches(model, simulation.threads());
  demand.phases = plan.phases(), demand.groups_fewest = demand.groups_most = plan.width();
  for (int phase = 0; phase < plan.phases(); ++phase)
    demand.groups_fewest = std::min(demand.groups_fewest, plan.phase_begin[phase + 1] - plan.phase_begin[phase]);
  const int at_once = machine.groups(model.scene.solver.precision);
  demand.at_once = at_once > 0 ? at_once : simulation.threads();
  demand.group_bytes = static_cast<double>(facts.patches.memory_bytes);
  demand.moved = solve_traffic(model, simulation.solver(), plan);
  demand.bytes_per_second =
      machine.bytes_per_second > 0 ? machine.bytes_per_second : measured_bandwidth(simulation.threads());
  return demand;
}

std::string list_demand(const DeviceEstimate& demand) {
  const Machine& machine = demand.machine;
  std::ostringstream out;
  out << "for " << machine.name << " (" << machine.what << "):\n";
  out << "  launches: " << (demand.launches_at_least ? "at least " : "") << demand.launches << " a step"
      << (demand.replays ? ", recorded once and replayed\n" : "\n");
  if (demand.phases == 0) {
    out << "  no batched constraints, and so no patches\n";
    return out.str();
  }
  out << "  groups: " << demand.groups_fewest;
  if (demand.groups_most > demand.groups_fewest) out << " to " << demand.groups_most;
  out << " in each of " << counted(demand.phases, "phase") << "; it works on " << demand.at_once << " at once\n"
      << "  fast memory: at most " << bytes_text(demand.group_bytes) << " a group";
  if (machine.fast_bytes > 0) out << ", of " << bytes_text(double(machine.fast_bytes)) << " that a group can have";
  if (demand.is_too_large()) out << "; so all groups will use the device's memory instead";
  const SolveTraffic& moved = demand.moved;
  char took[32];
  std::snprintf(took, sizeof took, "%.3g", demand.ms());
  out << "\n  memory: visits move " << bytes_text(moved.particle_bytes + moved.constraint_bytes)
      << " a step (particles " << bytes_text(moved.particle_bytes) << ", constraints "
      << bytes_text(moved.constraint_bytes) << ")\n  at " << per_second(demand.bytes_per_second)
      << (machine.bytes_per_second > 0 ? "" : ", measured now,") << " this alone takes " << took << " ms\n";
  if (!demand.not_counted.empty()) out << "  not counted in that: " << join(demand.not_counted) << "\n";
  return out.str();
}

}  // namespace malha
