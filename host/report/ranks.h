// What several machines would do with a model: its patches dealt to ranks, what these would send each other, and how
// long a step would take. Counted and estimated: no code runs on several machines.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/simulation.h"
#include "host/solver/patch_plan.h"

namespace malha {

/// Shared particles that one rank needs from another before a visit to the patches of a phase: how far they went, or
/// how fast they are where that visit predicts them.
struct RankFlow {
  int from, to;
  int particles;
  int started;  // of them, those that the rank has not had in this substep: where it began, too
};

/// A visit of an iteration to the patches of a phase.
struct RankVisit {
  PhaseVisit visit;
  std::vector<int> patches;               // of each rank
  std::vector<std::int64_t> projections;  // of each rank, there and back
  std::vector<std::int64_t> busy;         // of each rank: those of its threads' longest share, times its threads
  std::vector<RankFlow> flows;            // by the ranks they come from and go to, ascending: a message each

  std::int64_t travelling() const;  // particles
  double imbalance() const;         // the most projections of a rank over the mean
};

/// Of an iteration.
struct RankCounts {
  int ranks = 1;
  std::vector<int> rank_of;       // of each patch of the plan
  std::vector<RankVisit> visits;  // in their order
  std::vector<int> particles;     // of each rank, the movable ones that it visits last
  int border = 0;                 // particles that several ranks visit

  double imbalance() const;  // the sum over visits of the most projections of a rank, over that of the means
};

/// What the patches of this plan, dealt so, exchange when an iteration follows another. `threads`: of each rank.
RankCounts count_ranks(const Model& model, const PatchPlan& plan, std::vector<int> rank_of, int ranks, int threads);

/// Deals whole patches to ranks by METIS, evened out phase by phase: little is exchanged, and few ranks wait. The same
/// for every number of `threads`, and every time. `ranks`: 1 to the number of patches; some may get none.
RankCounts deal_ranks(const Model& model, const PatchPlan& plan, int ranks, int threads);

/// The machines and what connects them.
struct RankMachines {
  double gbit = 100;      // Gbit/s of each rank's link, either way
  double latency_us = 2;  // us, of a message
  int threads = 1;
  double projection_ns = 0, particle_ns = 0;  // of a projection, and of a particle and substep outside the visits
};

/// How often a step does what is exchanged.
struct StepShape {
  int substeps = 1, iterations = 1;
  int number_bytes = 4;  // of a coordinate; of a float there are two, with what rounding the place has lost
  int reductions = 0;    // all-reduces of a few numbers, a step
};
StepShape shape_of(const Simulation& simulation);

/// Of a step, s; each visit as long as its slowest rank.
struct RankSeconds {
  double work = 0, latency = 0, bytes = 0;
  double sum() const { return work + latency + bytes; }
};
RankSeconds step_seconds(const RankCounts& counts, const RankMachines& machines, const StepShape& shape);

/// A substep's, in all its iterations: s of a visit, and bytes and messages of all ranks.
double visit_seconds(const RankVisit& visit, const RankMachines& machines, const StepShape& shape);
std::int64_t visit_bytes(const RankVisit& visit, const StepShape& shape);
inline std::int64_t visit_messages(const RankVisit& visit, const StepShape& shape) {
  return static_cast<std::int64_t>(visit.flows.size()) * shape.iterations;
}

/// How a body of this shape would do at other sizes: borders grow with the power `growth` of its number of particles,
/// while latency, the visits, and the particles of a patch stay.
struct RankScaling {
  double particles = 1, growth = 0.5;
  double alone = 0;    // s, a step on one rank
  double patches = 0;  // s, a step of one patch a phase and thread: no rank is faster, however few it has
};

/// The least number of particles for which so many ranks, of which a step of so many particles as there are takes
/// `now`, are `faster` times as fast as one. Infinite where they never are.
double particles_that_pay(const RankScaling& scaling, const RankSeconds& now, int ranks, double faster);

struct RankOptions {
  int ranks = 1;
  double gbit = 100, latency_us = 2;
  std::optional<double> projection_ns = {}, particle_ns = {};  // measured where they are absent
};

struct RankRow {
  RankCounts counts;
  RankSeconds seconds;
};

struct RankTable {
  RankMachines machines;
  StepShape shape;
  int steps = 0;    // of which the fastest gave the speed; 0: it was given
  int threads = 1;  // that were asked for
  int patches = 0, phases = 0;
  RankScaling scaling;
  std::vector<std::string> not_counted;    // passes of a step
  double not_counted_ms = 0, step_ms = 0;  // of that step
  std::vector<RankRow> rows;               // 1, 2, 4 ... and the number of ranks
};

/// Throws InputError for Desbrun's method, and for more ranks than there are patches.
void require_ranks(const Simulation& simulation, int ranks);

/// Takes steps to measure what is not given. Throws as require_ranks() and Simulation::step() do.
RankTable plan_ranks(Simulation& simulation, const RankOptions& options);

/// For people.
std::string list_ranks(const RankTable& table);

}  // namespace malha
