// SPDX-License-Identifier: Apache-2.0
#include "tools/study/stability/stability.h"

#include "tools/study/stability/lines.h"
#include "tools/study/stability/maps.h"

namespace malha::study {

namespace {

template <Section (*part)(Cells& cells, Json& rows)>
std::vector<Section> alone(Cells& cells, Json& rows) {
  return {part(cells, rows)};
}

}  // namespace

const std::vector<StabilityPart>& stability_parts() {
  static const std::vector<StabilityPart> parts{{"steps", 60, 20, alone<steps_map>},
                                                {"masses", 36, 12, alone<masses_map>},
                                                {"resolution", 30, 12, alone<resolution_map>},
                                                {"order", 48, 24, order_map},
                                                {"amplification", 72, 11, growth_of_motion},
                                                {"minute", 3, 3, alone<minute_in_vacuum>},
                                                {"stiffness", 32, 12, alone<stiffness_failure>},
                                                {"substeps", 14, 6, alone<substeps_failure>},
                                                {"distance", 12, 6, alone<distance_failure>},
                                                {"start", 12, 12, alone<start_failure>},
                                                {"thickness", 5, 2, alone<thickness_failure>},
                                                {"impact", 8, 4, alone<impact_failure>},
                                                {"torque", 50, 20, alone<torque_failure>},
                                                {"turning", 35, 14, alone<turning_failure>},
                                                {"weight", 12, 4, alone<weight_failure>}};
  return parts;
}

Findings run_stability(Cells& cells) {
  int planned = 0;
  for (const StabilityPart& part : stability_parts()) planned += cells.quick() ? part.in_quick : part.cells;
  cells.plan(planned);
  Findings findings;
  for (const StabilityPart& part : stability_parts())
    for (Section& section : part.run(cells, findings.rows)) findings.sections.push_back(std::move(section));
  return findings;
}

}  // namespace malha::study
