// SPDX-License-Identifier: Apache-2.0
// Times and memory by part, which reports, plans and summaries name.
#include <sys/resource.h>

#include "host/model/memory_estimate.h"
#include "host/report/report.h"

namespace malha {

double median_step_ms(const RunTimes& times) { return times.steps.median() * 1000; }

NamedNumbers setup_parts(const Model& model, const SolverStats& facts) {
  const ModelSeconds& of = model.seconds;
  NamedNumbers parts{{"load", of.load},
                     {"order", of.order},
                     {"build_constraints", of.build_constraints},
                     {"patches", of.patches},
                     {"colour", facts.colour_seconds},
                     {"layout", facts.layout_seconds},
                     {"collision", facts.collision_seconds}};
  if (!facts.levels.empty()) parts.emplace_back("levels", facts.level_seconds);
  if (facts.filter) {
    parts.emplace_back("filter_order", facts.filter->order_seconds);
    parts.emplace_back("filter_factor", facts.filter->factor_seconds);
    parts.emplace_back("filter_columns", facts.filter->column_seconds);
  }
  return parts;
}

double peak_memory_mib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss / 1024.0;
}

NamedNumbers memory_parts(const Model& model, const SolverStats& facts) {
  const auto number = [](std::size_t bytes) { return static_cast<double>(bytes); };
  NamedNumbers parts{{"particles", number(facts.particle_bytes)},
                     {"constraints", number(facts.constraint_bytes + facts.long_range_bytes)},
                     {"air", number(facts.air_bytes)},
                     {"patches", number(facts.patches.bytes)},
                     {"springs", number(facts.spring_bytes)},
                     {"filter", number(facts.filter ? facts.filter->bytes : 0)},
                     {"collision", number(facts.collision_bytes)},
                     {"model", number(bytes(model))}};
  if (!facts.levels.empty()) parts.emplace_back("levels", number(facts.level_bytes));
  return parts;
}

}  // namespace malha
