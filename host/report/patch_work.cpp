#include "host/report/patch_work.h"

#include <algorithm>
#include <numeric>

namespace malha {

PatchWork::PatchWork(const PatchPlan& plan)
    : projections(plan.patches.size(), 0), phase(plan.patches.size()), particles(plan.patches.size(), 0) {
  for (std::size_t k = 0; k < plan.patches.size(); ++k) {
    const Patch& patch = plan.patches[k];
    for (int b = patch.batch; b < patch.batch + patch.batches; ++b) {
      const Batch& batch = plan.batches[b];
      const auto from = plan.sets[batch.set].constraint.begin() + batch.slot;
      projections[k] += std::count_if(from, from + batch.count, [](int c) { return c >= 0; });
    }
    for (int s = patch.segment; s < patch.segment + patch.segments; ++s)
      if (plan.segments[s].movable && plan.segments[s].last) particles[k] += plan.segments[s].count;
  }
  for (int p = 0; p < plan.phases(); ++p)
    std::fill(phase.begin() + plan.phase_begin[p], phase.begin() + plan.phase_begin[p + 1], p);
}

SharedParticles::SharedParticles(const Model& model, const PatchPlan& plan) {
  const auto each = [&plan](const auto& visit) {
    for (std::size_t k = 0; k < plan.patches.size(); ++k)
      for (int s = plan.patches[k].segment; s < plan.patches[k].segment + plan.patches[k].segments; ++s) {
        const Segment& segment = plan.segments[s];
        if (!segment.movable || (segment.first && segment.last)) continue;
        for (int i = segment.global; i < segment.global + segment.count; ++i) visit(i, static_cast<int>(k));
      }
  };
  std::vector<int> visits(model.count() + 1, 0);
  each([&](int i, int) { ++visits[i + 1]; });
  std::partial_sum(visits.begin(), visits.end(), visits.begin());
  std::vector<int> next(visits.begin(), visits.end() - 1);
  patch.resize(visits.back());
  each([&](int i, int k) { patch[next[i]++] = k; });
  for (int i = 0; i < model.count(); ++i)
    if (visits[i + 1] > visits[i]) begin.push_back(visits[i + 1]);
}

}  // namespace malha
