// SPDX-License-Identifier: Apache-2.0
#include "host/report/device_estimate.h"

#include <algorithm>
#include <vector>

#include "host/base/stopwatch.h"
#include "host/model/model.h"
#include "host/report/plan_passes.h"
#include "host/solver/solver.h"
#include "kernels/environment/edge_truncate.h"
#include "kernels/parallel/compute.h"

namespace malha {

namespace {

/// Returns how many numbers a patch solve moves for its particles. `position_numbers`: numbers of one position.
/// `predicts`, `updates`: this solve is the first or the last of the substep for particles that no other patch solves
/// before or after it.
double numbers_moved(const PatchPlan& plan, const Patch& patch, int position_numbers, bool predicts, bool updates) {
  double numbers = 0;
  for (int s = patch.segment; s < patch.segment + patch.segments; ++s) {
    const Segment& segment = plan.segments[s];
    const bool from_state = predicts && segment.first_solve && segment.movable;
    int each = position_numbers + 3 + 1;  // position, velocity or displacement, and w
    if (segment.movable) {
      if (updates && segment.last_solve)
        each += position_numbers + 3 +
                (from_state ? 0 : 3);  // the state is stored; v is loaded, unless the prediction has loaded it
      else
        each += 3;  // the displacement is stored
    }
    numbers += double(each) * segment.count;
  }
  return numbers;
}

/// Returns the bytes of a patch's constraints, with the bytes of one slot of each set.
double constraint_bytes(const PatchPlan& plan, const Patch& patch, const std::vector<double>& slot_bytes) {
  double bytes = 0;
  for (int b = patch.batch; b < patch.batch + patch.batches; ++b)
    bytes += slot_bytes[plan.batches[b].set] * plan.batches[b].count;
  return bytes;
}

/// Returns the largest measured rate at which all threads together read and write, bytes/s.
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

}  // namespace

PatchTraffic patch_traffic(const Model& model, const Solver& solver, const PatchPlan& plan) {
  const SolverStats& facts = solver.facts();
  const SolverSpec& spec = model.scene.solver;
  const double number = bytes_of_number(spec.precision);
  const int position_numbers =
      spec.precision == Precision::Float ? 6 : 3;  // with the rounding remainder of the position
  std::vector<double> slots(facts.sets.size(), 0), slot_bytes;
  for (const Batch& batch : plan.batches) slots[batch.set] += batch.count;
  for (std::size_t s = 0; s < slots.size(); ++s)
    slot_bytes.push_back(slots[s] > 0 ? static_cast<double>(facts.sets[s].bytes) / slots[s] : 0);
  const bool fuses = solver.step_plan().fuses();
  PatchTraffic traffic;
  for (int iteration = 0; iteration < spec.iterations; ++iteration)
    for (const ColourSweep& sweep : sweep_order(plan.colours())) {
      const bool predicts = fuses && goes_forward(sweep.sweeps) && iteration == 0;
      const bool updates = fuses && goes_backward(sweep.sweeps) && iteration + 1 == spec.iterations;
      for (int k = plan.colour_begin[sweep.colour]; k < plan.colour_begin[sweep.colour + 1]; ++k) {
        traffic.particle_bytes += number * numbers_moved(plan, plan.patches[k], position_numbers, predicts, updates);
        traffic.constraint_bytes += constraint_bytes(plan, plan.patches[k], slot_bytes);
      }
    }
  traffic.particle_bytes *= spec.substeps, traffic.constraint_bytes *= spec.substeps;
  return traffic;
}

DeviceEstimate estimate_device(const Simulation& simulation, const Machine& machine) {
  const Model& model = simulation.model();
  const SolverStats& facts = simulation.solver().facts();
  DeviceEstimate estimate{.machine = machine};
  for (const StepPass& pass : step_passes(model, simulation.solver())) {
    estimate.launches += pass.launches;
    estimate.launches_at_least = estimate.launches_at_least || !pass.remark.empty();
    if (!pass.name.starts_with("fused_solve") && pass.name != "projection") estimate.not_counted.push_back(pass.name);
  }
  // On a device, reductions and the preparation of contact queries for the host are launches of their own.
  estimate.launches_at_least =
      estimate.launches_at_least || (machine.fast_bytes > 0 && !simulation.solver().step_plan().fuses());
  estimate.replays = machine.fast_bytes > 0 && simulation.solver().step_plan().recorded == Recorded::Steps;
  if (facts.sets.empty()) return estimate;
  const PatchPlan plan = plan_patches(model, simulation.threads());
  estimate.colours = plan.colours(), estimate.groups_fewest = estimate.groups_most = plan.width();
  for (int colour = 0; colour < plan.colours(); ++colour)
    estimate.groups_fewest =
        std::min(estimate.groups_fewest, plan.colour_begin[colour + 1] - plan.colour_begin[colour]);
  const int groups_at_once = machine.groups(model.scene.solver.precision);
  estimate.groups_at_once = groups_at_once > 0 ? groups_at_once : simulation.threads();
  estimate.group_bytes = static_cast<double>(facts.patches.memory_bytes);
  estimate.traffic = patch_traffic(model, simulation.solver(), plan);
  estimate.bytes_per_second =
      machine.bytes_per_second > 0 ? machine.bytes_per_second : measured_bandwidth(simulation.threads());
  return estimate;
}

}  // namespace malha
