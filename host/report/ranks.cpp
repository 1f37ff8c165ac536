#include "host/report/ranks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "host/model/model.h"
#include "host/report/patch_work.h"

namespace malha {

namespace {

/// As launches deal groups to a team: consecutive ones, as many to each.
std::int64_t longest_share(const std::vector<std::int64_t>& work, int threads) {
  const auto count = static_cast<std::int64_t>(work.size());
  std::int64_t longest = 0;
  for (std::int64_t thread = 0; thread < threads; ++thread)
    longest = std::max(longest, std::accumulate(work.begin() + count * thread / threads,
                                                work.begin() + count * (thread + 1) / threads, std::int64_t{0}));
  return longest;
}

template <class T>
T most(const std::vector<T>& of) {
  return of.empty() ? T{} : *std::max_element(of.begin(), of.end());
}

double mean(const std::vector<std::int64_t>& of) {
  return static_cast<double>(std::accumulate(of.begin(), of.end(), std::int64_t{0})) / static_cast<double>(of.size());
}

std::int64_t bytes_of_way(const StepShape& shape) { return std::int64_t{3} * shape.number_bytes; }
/// With what a float lacks of it.
std::int64_t bytes_of_start(const StepShape& shape) {
  return bytes_of_way(shape) * (shape.number_bytes < static_cast<int>(sizeof(double)) ? 2 : 1);
}

/// Of the slowest rank, which computes, and sends and receives at once. `first`: iteration of a substep.
RankSeconds slowest(const RankVisit& visit, const RankMachines& machines, const StepShape& shape, bool first) {
  const std::size_t ranks = visit.projections.size();
  std::vector<double> in(ranks, 0), out(ranks, 0);
  std::vector<int> received(ranks, 0), sent(ranks, 0);
  for (const RankFlow& flow : visit.flows) {
    const auto bytes =
        static_cast<double>(bytes_of_way(shape) * flow.particles + (first ? bytes_of_start(shape) * flow.started : 0));
    in[flow.to] += bytes, out[flow.from] += bytes;
    ++received[flow.to], ++sent[flow.from];
  }
  RankSeconds longest;
  for (std::size_t rank = 0; rank < ranks; ++rank) {
    const RankSeconds own{static_cast<double>(visit.busy[rank]) * machines.projection_ns * 1e-9,
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

/// In all iterations of a substep.
RankSeconds in_a_substep(const RankVisit& visit, const RankMachines& machines, const StepShape& shape) {
  return slowest(visit, machines, shape, true) + (shape.iterations - 1) * slowest(visit, machines, shape, false);
}

}  // namespace

std::int64_t RankVisit::travelling() const {
  std::int64_t sum = 0;
  for (const RankFlow& flow : flows) sum += flow.particles;
  return sum;
}

double RankVisit::imbalance() const {
  const double each = mean(projections);
  return each > 0 ? static_cast<double>(most(projections)) / each : 1;
}

double RankCounts::imbalance() const {
  double longest = 0, even = 0;
  for (const RankVisit& visit : visits)
    longest += static_cast<double>(most(visit.projections)), even += mean(visit.projections);
  return even > 0 ? longest / even : 1;
}

RankCounts count_ranks(const Model& model, const PatchPlan& plan, std::vector<int> rank_of, int ranks, int threads) {
  RankCounts counts;
  counts.ranks = ranks;
  counts.particles.assign(ranks, 0);
  const PatchWork work_of(plan);
  for (std::size_t k = 0; k < plan.patches.size(); ++k) counts.particles[rank_of[k]] += work_of.particles[k];
  for (const PhaseVisit& of : visits_of(plan.phases())) {
    RankVisit& visit = counts.visits.emplace_back();
    visit.visit = of;
    visit.patches.resize(ranks), visit.projections.resize(ranks), visit.busy.resize(ranks);
    std::vector<std::vector<std::int64_t>> work(ranks);
    for (int k = plan.phase_begin[of.phase]; k < plan.phase_begin[of.phase + 1]; ++k)
      work[rank_of[k]].push_back(of.sweeps() * work_of.projections[k]);
    for (int rank = 0; rank < ranks; ++rank) {
      visit.patches[rank] = static_cast<int>(work[rank].size());
      visit.projections[rank] = std::accumulate(work[rank].begin(), work[rank].end(), std::int64_t{0});
      visit.busy[rank] = threads * longest_share(work[rank], threads);
    }
  }
  const SharedParticles shared(model, plan);
  std::vector<std::map<std::pair<int, int>, RankFlow>> flows(counts.visits.size());
  std::vector<int> had(ranks, -1);  // the last shared particle of which each knows where the substep began
  for (int i = 0; i < shared.count(); ++i) {
    had[rank_of[shared.last(i)]] = i;
    bool border = false;
    shared.for_each(i, [&](int before, const SharedParticles::Visit& visit) {
      const int from = rank_of[before], to = rank_of[visit.patch];
      if (from == to) return;
      border = true;
      RankFlow& flow = flows[visit.of].try_emplace({from, to}, RankFlow{from, to, 0, 0}).first->second;
      ++flow.particles, flow.started += had[to] != i;
      had[to] = i;
    });
    counts.border += border;
  }
  for (std::size_t v = 0; v < flows.size(); ++v)
    for (const auto& [ends, flow] : flows[v]) counts.visits[v].flows.push_back(flow);
  counts.rank_of = std::move(rank_of);
  return counts;
}

RankSeconds step_seconds(const RankCounts& counts, const RankMachines& machines, const StepShape& shape) {
  RankSeconds step;
  for (const RankVisit& visit : counts.visits) step = step + in_a_substep(visit, machines, shape);
  step.work += most(counts.particles) * machines.particle_ns * 1e-9;
  step = shape.substeps * step;
  step.latency += shape.reductions * std::ceil(std::log2(counts.ranks)) * machines.latency_us * 1e-6;
  return step;
}

double visit_seconds(const RankVisit& visit, const RankMachines& machines, const StepShape& shape) {
  return in_a_substep(visit, machines, shape).sum();
}

std::int64_t visit_bytes(const RankVisit& visit, const StepShape& shape) {
  std::int64_t started = 0;
  for (const RankFlow& flow : visit.flows) started += flow.started;
  return bytes_of_way(shape) * shape.iterations * visit.travelling() + bytes_of_start(shape) * started;
}

double particles_that_pay(const RankScaling& scaling, const RankSeconds& now, int ranks, double faster) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  if (faster >= ranks) return infinite;
  const auto pays = [&](double size) {
    const double scale = size / scaling.particles, alone = scale * scaling.alone;
    const double work = std::max(alone / ranks, scaling.patches);
    return faster * (work + now.latency + std::pow(scale, scaling.growth) * now.bytes) <= alone;
  };
  constexpr double fewest = 1, many = 1e15;
  if (pays(fewest)) return fewest;
  if (!pays(many)) return infinite;
  double low = std::log(fewest), high = std::log(many);
  for (int round = 0; round < 60; ++round) (pays(std::exp((low + high) / 2)) ? high : low) = (low + high) / 2;
  return std::exp(high);
}

}  // namespace malha
