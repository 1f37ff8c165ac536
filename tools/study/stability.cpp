#include "tools/study/stability.h"

#include "tools/study/stability_lines.h"
#include "tools/study/stability_maps.h"

namespace malha::study {

Findings run_stability(Cells& cells) {
  Findings findings;
  findings.sections.push_back(steps_map(cells, findings.rows));
  findings.sections.push_back(masses_map(cells, findings.rows));
  findings.sections.push_back(resolution_map(cells, findings.rows));
  for (Section& section : order_map(cells, findings.rows)) findings.sections.push_back(std::move(section));
  for (const auto failure : {stiffness_failure, substeps_failure, distance_failure, start_failure, thickness_failure,
                             torque_failure, turning_failure, weight_failure})
    findings.sections.push_back(failure(cells, findings.rows));
  return findings;
}

}  // namespace malha::study
