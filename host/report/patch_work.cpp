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
  const auto each_of = [&plan](int patch, const auto& work) {
    const int first = plan.patches[patch].segment;
    for (int s = first; s < first + plan.patches[patch].segments; ++s)
      if (const Segment& segment = plan.segments[s]; segment.movable)
        for (int i = segment.global; i < segment.global + segment.count; ++i) work(i);
  };
  std::vector<int> patches(model.count(), 0);
  for (std::size_t k = 0; k < plan.patches.size(); ++k) each_of(static_cast<int>(k), [&](int i) { ++patches[i]; });
  const auto each = [&](const auto& work) {
    const std::vector<PhaseVisit> order = visits_of(plan.phases());
    for (std::size_t v = 0; v < order.size(); ++v)
      for (int k = plan.phase_begin[order[v].phase]; k < plan.phase_begin[order[v].phase + 1]; ++k)
        each_of(k, [&](int i) {
          if (patches[i] > 1) work(i, Visit{k, static_cast<int>(v)});
        });
  };
  std::vector<int> count(model.count() + 1, 0);
  each([&](int i, const Visit&) { ++count[i + 1]; });
  std::partial_sum(count.begin(), count.end(), count.begin());
  std::vector<int> next(count.begin(), count.end() - 1);
  visits.resize(count.back());
  each([&](int i, const Visit& visit) { visits[next[i]++] = visit; });
  for (int i = 0; i < model.count(); ++i)
    if (count[i + 1] > count[i]) begin.push_back(count[i + 1]);
}

}  // namespace malha
