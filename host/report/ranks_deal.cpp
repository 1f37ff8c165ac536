#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "host/base/graph_cut.h"
#include "host/model/model.h"
#include "host/report/patch_work.h"
#include "host/report/ranks.h"

namespace malha {

namespace {

/// Particles that one patch needs from another in an iteration.
struct PatchFlow {
  int from, to, particles;
};

class Dealer {
 public:
  Dealer(const Model& model, const PatchPlan& plan, int ranks)
      : plan_(plan), work_(plan), ranks_(ranks), patches_(static_cast<int>(plan.patches.size())), flows_of_(patches_) {
    const SharedParticles shared(model, plan);
    std::map<std::pair<int, int>, int> particles;
    for (int i = 0; i < shared.count(); ++i)
      shared.for_each(i, [&](int before, const SharedParticles::Visit& visit) {
        if (before != visit.patch) ++particles[{before, visit.patch}];
      });
    for (const auto& [ends, count] : particles) {
      for (const int end : {ends.first, ends.second}) flows_of_[end].push_back(static_cast<int>(flows_.size()));
      flows_.push_back({ends.first, ends.second, count});
    }
  }

  /// Stretches of the solver's order, in which bodies and neighbours follow each other, of about equal work.
  std::vector<int> stretches() const {
    std::vector<int> order(patches_), rank_of(patches_);
    double all = 0, before = 0;
    for (int k = 0; k < patches_; ++k) order[plan_.number[k]] = k, all += static_cast<double>(work_.both(k));
    for (int n = 0, rank = 0; n < patches_; ++n) {
      const auto work = static_cast<double>(work_.both(order[n]));
      // By its middle; but every rank gets one.
      const int wanted = static_cast<int>((before + work / 2) / all * ranks_);
      if (n > 0) rank = std::min(std::clamp(wanted, rank, rank + 1), ranks_ - 1);
      rank = std::max(rank, ranks_ - (patches_ - n));
      rank_of[order[n]] = rank;
      before += work;
    }
    return rank_of;
  }

  /// Where no patch has much more than a rank's share: there METIS gives up, with words on standard output.
  bool is_for_metis() const {
    std::int64_t all = 0, most = 0;
    for (int k = 0; k < patches_; ++k) all += work_.both(k), most = std::max(most, work_.both(k));
    return 2 * most * ranks_ <= 3 * all;
  }

  std::vector<int> by_metis() const {
    std::vector<std::map<int, int>> weight(patches_);
    for (const PatchFlow& flow : flows_)
      weight[flow.from][flow.to] += flow.particles, weight[flow.to][flow.from] += flow.particles;
    WeightedGraph graph;
    for (int k = 0; k < patches_; ++k) {
      for (const auto& [to, particles] : weight[k]) graph.to.push_back(to), graph.weight.push_back(particles);
      graph.begin.push_back(static_cast<int>(graph.to.size()));
      graph.load.push_back(static_cast<int>(work_.both(k)));
    }
    return cut_graph(graph, ranks_);
  }

  /// Moves single patches to ranks of their neighbours as long as that evens out the phases. METIS balances their sum:
  /// given each phase by itself, it gives up on small ones.
  std::vector<int> even_out(std::vector<int> rank_of) {
    rank_of_ = std::move(rank_of);
    load_.assign(static_cast<std::size_t>(plan_.phases()) * ranks_, 0);
    for (int k = 0; k < patches_; ++k) at(work_.phase[k], rank_of_[k]) += static_cast<double>(work_.both(k));
    for (const PatchFlow& flow : flows_)
      if (rank_of_[flow.from] != rank_of_[flow.to]) at(work_.phase[flow.to], rank_of_[flow.to]) += flow.particles;
    constexpr int most_rounds = 30;
    bool moved = true;
    for (int round = 0; round < most_rounds && moved; ++round) {
      moved = false;
      for (int k = 0; k < patches_; ++k) moved = move_if_better(k) || moved;
    }
    return std::move(rank_of_);
  }

 private:
  double& at(int phase, int rank) { return load_[static_cast<std::size_t>(phase) * ranks_ + rank]; }

  /// Loads count by a high power: those of the slowest ranks nearly alone.
  static double cost(double load) { return std::pow(load, 8); }
  double add(int phase, int rank, double load) {
    double& sum = at(phase, rank);
    const double before = cost(sum);
    sum += load;
    return cost(sum) - before;
  }

  /// By how much the cost grows.
  double move(int k, int to) {
    const int from = rank_of_[k], phase = work_.phase[k];
    const auto work = static_cast<double>(work_.both(k));
    double grows = add(phase, from, -work) + add(phase, to, work);
    for (const int f : flows_of_[k]) {
      const PatchFlow& flow = flows_[f];
      if (flow.to == k) {
        const int other = rank_of_[flow.from];
        if (other != from) grows += add(phase, from, -flow.particles);
        if (other != to) grows += add(phase, to, flow.particles);
      } else {
        const int other = rank_of_[flow.to];
        grows += add(work_.phase[flow.to], other, flow.particles * ((other != to) - (other != from)));
      }
    }
    rank_of_[k] = to;
    return grows;
  }

  bool move_if_better(int k) {
    const int from = rank_of_[k];
    std::vector<int> near;
    for (const int f : flows_of_[k])
      for (const int end : {flows_[f].from, flows_[f].to})
        if (rank_of_[end] != from) near.push_back(rank_of_[end]);
    std::sort(near.begin(), near.end());
    near.erase(std::unique(near.begin(), near.end()), near.end());
    int best = from;
    double least = -1e-9 * cost(at(work_.phase[k], from));  // beyond rounding
    for (const int to : near) {
      if (const double grows = move(k, to); grows < least) least = grows, best = to;
      move(k, from);
    }
    if (best != from) move(k, best);
    return best != from;
  }

  const PatchPlan& plan_;
  const PatchWork work_;
  int ranks_, patches_;
  std::vector<PatchFlow> flows_;
  std::vector<std::vector<int>> flows_of_;  // of each patch, by their numbers
  std::vector<int> rank_of_;                // of each patch
  std::vector<double> load_;                // of each phase and rank
};

}  // namespace

RankCounts deal_ranks(const Model& model, const PatchPlan& plan, int ranks, int threads) {
  if (ranks == 1) return count_ranks(model, plan, std::vector<int>(plan.patches.size(), 0), 1, threads);
  // The fastest of some ways at common speeds: those of this machine differ from run to run.
  const RankMachines common{.projection_ns = 1, .particle_ns = 1};
  Dealer dealer(model, plan, ranks);
  std::vector<int> best;
  double least = std::numeric_limits<double>::infinity();
  const auto take = [&](std::vector<int> rank_of) {
    const double seconds = step_seconds(count_ranks(model, plan, rank_of, ranks, 1), common, {}).sum();
    if (seconds < least) least = seconds, best = std::move(rank_of);
  };
  std::vector<std::vector<int>> ways{dealer.stretches()};
  if (dealer.is_for_metis()) ways.push_back(dealer.by_metis());
  for (const std::vector<int>& way : ways) take(way), take(dealer.even_out(way));
  return count_ranks(model, plan, std::move(best), ranks, threads);
}

}  // namespace malha
