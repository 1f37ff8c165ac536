// SPDX-License-Identifier: Apache-2.0
#include "tools/study/stability/stability.h"

#include "tools/study/stability/lines.h"
#include "tools/study/stability/maps.h"

namespace malha::study {

namespace {

template <Section (*part)(Cells& cells, Json& rows)>
std::vector<Section> one_section(Cells& cells, Json& rows) {
  return {part(cells, rows)};
}

}  // namespace

const std::vector<StabilityPart>& stability_parts() {
  static const std::vector<StabilityPart> parts{{"steps", 60, 20, one_section<steps_map>},
                                                {"masses", 36, 12, one_section<masses_map>},
                                                {"resolution", 30, 12, one_section<resolution_map>},
                                                {"order", 48, 24, order_map},
                                                {"amplification", 72, 11, growth_of_motion},
                                                {"minute", 3, 3, one_section<minute_in_vacuum>},
                                                {"stiffness", 32, 12, one_section<stiffness_failure>},
                                                {"substeps", 14, 6, one_section<substeps_failure>},
                                                {"distance", 12, 6, one_section<distance_failure>},
                                                {"start", 12, 12, one_section<start_failure>},
                                                {"thickness", 5, 2, one_section<thickness_failure>},
                                                {"impact", 8, 4, one_section<impact_failure>},
                                                {"torque", 50, 20, one_section<torque_failure>},
                                                {"turning", 35, 14, one_section<turning_failure>},
                                                {"weight", 12, 4, one_section<weight_failure>}};
  return parts;
}

Findings run_stability(Cells& cells) {
  int planned = 0;
  for (const StabilityPart& part : stability_parts()) planned += cells.quick() ? part.quick_cells : part.cells;
  cells.plan(planned);
  Findings findings;
  for (const StabilityPart& part : stability_parts())
    for (Section& section : part.run(cells, findings.rows)) findings.sections.push_back(std::move(section));
  return findings;
}

}  // namespace malha::study
