#include "host/report/ranks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "host/base/graph_cut.h"
#include "host/error.h"
#include "host/model/model.h"

namespace malha {

namespace {

/// The movable particles that several patches visit, and those patches in the order of a sweep.
struct SharedParticles {
  std::vector<int> begin{0}, patch;

  SharedParticles(const Model& model, const PatchPlan& plan) {
    std::vector<int> visits(model.count() + 1, 0);
    each(plan, [&](int i, int) { ++visits[i + 1]; });
    std::partial_sum(visits.begin(), visits.end(), visits.begin());
    std::vector<int> next(visits.begin(), visits.end() - 1);
    patch.resize(visits.back());
    each(plan, [&](int i, int k) { patch[next[i]++] = k; });
    for (int i = 0; i < model.count(); ++i)
      if (visits[i + 1] > visits[i]) begin.push_back(visits[i + 1]);
  }
  int count() const { return static_cast<int>(begin.size()) - 1; }

  /// Calls visit(before, patch, first) for every visit to each of them, and the patch of the visit before it: that of
  /// the last one for the first.
  template <class Visit>
  void for_each(int particle, const Visit& visit) const {
    int before = patch[begin[particle + 1] - 1];
    for (int k = begin[particle]; k < begin[particle + 1]; ++k) {
      visit(before, patch[k], k == begin[particle]);
      before = patch[k];
    }
  }

 private:
  template <class Visit>
  static void each(const PatchPlan& plan, const Visit& visit) {
    for (std::size_t k = 0; k < plan.patches.size(); ++k)
      for (int s = plan.patches[k].segment; s < plan.patches[k].segment + plan.patches[k].segments; ++s) {
        const Segment& segment = plan.segments[s];
        if (!segment.movable || (segment.first && segment.last)) continue;
        for (int i = segment.global; i < segment.global + segment.count; ++i) visit(i, static_cast<int>(k));
      }
  }
};

std::vector<std::int64_t> projections_of_patches(const PatchPlan& plan) {
  std::vector<std::int64_t> sum(plan.patches.size(), 0);
  for (std::size_t k = 0; k < plan.patches.size(); ++k)
    for (int b = plan.patches[k].batch; b < plan.patches[k].batch + plan.patches[k].batches; ++b) {
      const Batch& batch = plan.batches[b];
      const auto from = plan.sets[batch.set].constraint.begin() + batch.slot;
      sum[k] += std::count_if(from, from + batch.count, [](int c) { return c >= 0; });  // gaps of runs are no work
    }
  return sum;
}

std::vector<int> phase_of_patches(const PatchPlan& plan) {
  std::vector<int> phase_of(plan.patches.size());
  for (int phase = 0; phase < plan.phases(); ++phase)
    std::fill(phase_of.begin() + plan.phase_begin[phase], phase_of.begin() + plan.phase_begin[phase + 1], phase);
  return phase_of;
}

/// The movable particles that each patch is the last to visit.
std::vector<int> particles_of_patches(const PatchPlan& plan) {
  std::vector<int> sum(plan.patches.size(), 0);
  for (std::size_t k = 0; k < plan.patches.size(); ++k)
    for (int s = plan.patches[k].segment; s < plan.patches[k].segment + plan.patches[k].segments; ++s)
      if (plan.segments[s].movable && plan.segments[s].last) sum[k] += plan.segments[s].count;
  return sum;
}

/// As launches deal groups to a team: consecutive ones, as many to each.
std::int64_t longest_share(const std::vector<std::int64_t>& work, int threads) {
  const auto count = static_cast<std::int64_t>(work.size());
  std::int64_t longest = 0;
  for (std::int64_t thread = 0; thread < threads; ++thread)
    longest = std::max(longest, std::accumulate(work.begin() + count * thread / threads,
                                                work.begin() + count * (thread + 1) / threads, std::int64_t{0}));
  return longest;
}

/// Vertices are patches; an edge's weight is what would travel along it in a sweep. The loads are those of the phases,
/// each by itself (`by_phase`), or of all together.
WeightedGraph graph_of(const PatchPlan& plan, const SharedParticles& shared, bool by_phase) {
  std::vector<std::map<int, int>> weight(plan.patches.size());
  for (int i = 0; i < shared.count(); ++i)
    shared.for_each(i, [&](int before, int patch, bool) {
      if (before != patch) ++weight[before][patch], ++weight[patch][before];
    });
  WeightedGraph graph;
  graph.kinds = by_phase ? plan.phases() : 1;
  const std::vector<std::int64_t> projections = projections_of_patches(plan);
  const std::vector<int> phase_of = phase_of_patches(plan), particles = particles_of_patches(plan);
  graph.load.assign(plan.patches.size() * graph.kinds, 0);
  for (std::size_t k = 0; k < plan.patches.size(); ++k) {
    for (const auto& [to, particles_between] : weight[k])
      graph.to.push_back(to), graph.weight.push_back(particles_between);
    graph.begin.push_back(static_cast<int>(graph.to.size()));
    graph.load[k * graph.kinds + (by_phase ? phase_of[k] : 0)] = static_cast<int>(projections[k]) + particles[k] + 1;
  }
  return graph;
}

/// Stretches of the solver's order, in which bodies and neighbours follow each other, of about equal work.
std::vector<int> stretches(const PatchPlan& plan, int ranks) {
  const std::vector<std::int64_t> projections = projections_of_patches(plan);
  const std::vector<int> particles = particles_of_patches(plan);
  const int count = static_cast<int>(plan.patches.size());
  std::vector<int> order(count), rank_of(count);
  for (int k = 0; k < count; ++k) order[plan.number[k]] = k;
  double all = 0, before = 0;
  for (int k = 0; k < count; ++k) all += static_cast<double>(projections[k]) + particles[k] + 1;
  for (int n = 0, rank = 0; n < count; ++n) {
    const double work = static_cast<double>(projections[order[n]]) + particles[order[n]] + 1;
    // By its middle; but every rank gets one, and as many are left as ranks are.
    const int wanted = static_cast<int>((before + work / 2) / all * ranks);
    if (n > 0) rank = std::min(std::clamp(wanted, rank, rank + 1), ranks - 1);
    rank = std::max(rank, ranks - (count - n));
    rank_of[order[n]] = rank;
    before += work;
  }
  return rank_of;
}

template <class T>
T most(const std::vector<T>& of) {
  return of.empty() ? T{} : *std::max_element(of.begin(), of.end());
}

double mean(const std::vector<std::int64_t>& of) {
  return static_cast<double>(std::accumulate(of.begin(), of.end(), std::int64_t{0})) / static_cast<double>(of.size());
}

/// Of the slowest rank, which computes, and sends and receives at once.
RankSeconds slowest(const RankPhase& phase, const RankMachines& machines, const StepShape& shape, bool first) {
  const std::size_t ranks = phase.projections.size();
  std::vector<double> in(ranks, 0), out(ranks, 0);
  std::vector<int> received(ranks, 0), sent(ranks, 0);
  const int place = 3 * shape.number_bytes;
  for (const RankFlow& flow : phase.flows) {
    const double bytes = static_cast<double>(place) * (flow.particles + (first && shape.predicts ? flow.first : 0));
    in[flow.to] += bytes, out[flow.from] += bytes;
    ++received[flow.to], ++sent[flow.from];
  }
  RankSeconds longest;
  for (std::size_t rank = 0; rank < ranks; ++rank) {
    const RankSeconds own{static_cast<double>(phase.busy[rank]) * machines.projection_ns * 1e-9,
                          std::max(received[rank], sent[rank]) * machines.latency_us * 1e-6,
                          std::max(in[rank], out[rank]) * 8 / (machines.gbit * 1e9)};
    if (own.sum() > longest.sum()) longest = own;
  }
  return longest;
}

RankSeconds operator+(const RankSeconds& a, const RankSeconds& b) {
  return {a.work + b.work, a.latency + b.latency, a.bytes + b.bytes};
}
RankSeconds operator*(double factor, const RankSeconds& a) {
  return {factor * a.work, factor * a.latency, factor * a.bytes};
}

/// In all sweeps of a substep.
RankSeconds in_a_substep(const RankPhase& phase, const RankMachines& machines, const StepShape& shape) {
  return slowest(phase, machines, shape, true) + (shape.iterations - 1) * slowest(phase, machines, shape, false);
}

}  // namespace

std::int64_t RankPhase::travelling() const {
  std::int64_t sum = 0;
  for (const RankFlow& flow : flows) sum += flow.particles;
  return sum;
}

double RankPhase::imbalance() const {
  const double each = mean(projections);
  return each > 0 ? static_cast<double>(most(projections)) / each : 1;
}

double RankCounts::imbalance() const {
  double longest = 0, even = 0;
  for (const RankPhase& phase : phases)
    longest += static_cast<double>(most(phase.projections)), even += mean(phase.projections);
  return even > 0 ? longest / even : 1;
}

RankCounts count_ranks(const Model& model, const PatchPlan& plan, std::vector<int> rank_of, int ranks, int threads) {
  RankCounts counts;
  counts.ranks = ranks;
  counts.particles.assign(ranks, 0);
  const std::vector<std::int64_t> projections = projections_of_patches(plan);
  const std::vector<int> phase_of = phase_of_patches(plan), particles = particles_of_patches(plan);
  for (int k = 0; k < static_cast<int>(plan.patches.size()); ++k) counts.particles[rank_of[k]] += particles[k];
  for (int p = 0; p < plan.phases(); ++p) {
    RankPhase& phase = counts.phases.emplace_back();
    phase.patches.resize(ranks), phase.projections.resize(ranks), phase.busy.resize(ranks);
    std::vector<std::vector<std::int64_t>> work(ranks);
    for (int k = plan.phase_begin[p]; k < plan.phase_begin[p + 1]; ++k) work[rank_of[k]].push_back(projections[k]);
    for (int rank = 0; rank < ranks; ++rank) {
      phase.patches[rank] = static_cast<int>(work[rank].size());
      phase.projections[rank] = std::accumulate(work[rank].begin(), work[rank].end(), std::int64_t{0});
      phase.busy[rank] = threads * longest_share(work[rank], threads);
    }
  }
  const SharedParticles shared(model, plan);
  std::vector<std::map<std::pair<int, int>, RankFlow>> flows(plan.phases());
  for (int i = 0; i < shared.count(); ++i) {
    bool border = false;
    shared.for_each(i, [&](int before, int patch, bool first) {
      const int from = rank_of[before], to = rank_of[patch];
      if (from == to) return;
      border = true;
      RankFlow& flow = flows[phase_of[patch]].try_emplace({from, to}, RankFlow{from, to, 0, 0}).first->second;
      ++flow.particles, flow.first += first;
    });
    counts.border += border;
  }
  for (int p = 0; p < plan.phases(); ++p)
    for (const auto& [ends, flow] : flows[p]) counts.phases[p].flows.push_back(flow);
  counts.rank_of = std::move(rank_of);
  return counts;
}

RankCounts deal_ranks(const Model& model, const PatchPlan& plan, int ranks, int threads) {
  // METIS bounds the loads and cuts little, but does not know what a message costs, nor that threads take whole
  // patches. Of its ways and of plain stretches the one is taken that is the fastest at common speeds: those of this
  // machine differ from run to run.
  const RankMachines common{.threads = threads, .projection_ns = 1, .particle_ns = 1};
  const StepShape shape;
  std::vector<std::vector<int>> ways{stretches(plan, ranks)};
  if (ranks > 1) {
    const SharedParticles shared(model, plan);
    for (const bool by_phase : {true, false}) {
      const WeightedGraph graph = graph_of(plan, shared, by_phase);
      for (const CutBy by : {CutBy::KWay, CutBy::Bisection}) ways.push_back(cut_graph(graph, ranks, by));
    }
  }
  RankCounts best;
  double least = std::numeric_limits<double>::infinity();
  for (std::vector<int>& way : ways) {
    RankCounts counts = count_ranks(model, plan, std::move(way), ranks, threads);
    const double seconds = step_seconds(counts, common, shape).sum();
    if (seconds < least) least = seconds, best = std::move(counts);
  }
  return best;
}

RankSeconds step_seconds(const RankCounts& counts, const RankMachines& machines, const StepShape& shape) {
  RankSeconds step;
  for (const RankPhase& phase : counts.phases) step = step + in_a_substep(phase, machines, shape);
  step.work += most(counts.particles) * machines.particle_ns * 1e-9;
  step = shape.substeps * step;
  step.latency += shape.reductions * std::ceil(std::log2(counts.ranks)) * machines.latency_us * 1e-6;
  return step;
}

double phase_seconds(const RankPhase& phase, const RankMachines& machines, const StepShape& shape) {
  return in_a_substep(phase, machines, shape).sum();
}

std::int64_t phase_bytes(const RankPhase& phase, const StepShape& shape) {
  std::int64_t first = 0;
  for (const RankFlow& flow : phase.flows) first += flow.first;
  return 3 * shape.number_bytes * (shape.iterations * phase.travelling() + (shape.predicts ? first : 0));
}

double particles_that_pay(double particles, double growth, double alone, const RankSeconds& now, int ranks,
                          double faster) {
  if (faster >= ranks) return std::numeric_limits<double>::infinity();
  const auto pays = [&](double size) {
    const double scale = size / particles;
    return faster * (scale * alone / ranks + now.latency + std::pow(scale, growth) * now.bytes) <= scale * alone;
  };
  constexpr double fewest = 1, many = 1e15;
  if (pays(fewest)) return fewest;
  if (!pays(many)) return std::numeric_limits<double>::infinity();
  double low = std::log(fewest), high = std::log(many);
  for (int round = 0; round < 60; ++round) (pays(std::exp((low + high) / 2)) ? high : low) = (low + high) / 2;
  return std::exp(high);
}

}  // namespace malha
