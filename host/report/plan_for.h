// What a step asks of the machine that a model is laid out for, before it runs there.
#pragma once
#include <string>

#include "host/model/machine.h"
#include "host/simulation.h"

namespace malha {

/// Of the visits of a step: how the particles and constraints travel between memory and cores.
struct VisitTraffic {
  double particle_bytes = 0, constraint_bytes = 0;
};

/// Each visit reads what it needs once and writes what it changes once. Zero for a model without batched constraints.
VisitTraffic visit_traffic(const Model& model, const Solver& solver);

/// Groups a phase, fast memory, launches a step, bytes moved, and how long memory alone would take over them. For the
/// CPU the bandwidth is measured.
std::string plan_for(const Simulation& simulation, const Machine& machine);

}  // namespace malha
