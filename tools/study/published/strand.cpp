// SPDX-License-Identifier: Apache-2.0
// The strand of Chen et al. 2024 (Vertex Block Descent): 20 vertices, stiffness 1e8, the last one of mass 1000, step
// 1/60 s, 100 iterations.
#include <array>

#include "tools/bench/output.h"
#include "tools/study/published/hanging.h"
#include "tools/study/published/parts.h"

namespace malha::study {

namespace {

using bench::formatted;

HangingWeight strand(int substeps, int iterations) { return {1000, 0.1, 1e8, 1.0 / 60, 9.81, substeps, iterations}; }

std::vector<std::array<int, 2>> schedules(bool quick) {
  if (quick) return {{1, 100}, {10, 10}, {100, 1}};
  return {{1, 100}, {1, 1000}, {1, 10000}, {10, 10}, {100, 1}};
}

void add_strand(Cells& cells, Findings& findings) {
  Section section{"Vertex Block Descent 2024: a strand with a weight of 1000"};
  section.table.columns = {"method", "most stretch, m", "plain sweep's, m", "times Newton's"};
  const HangingWeight once = strand(1, 1);
  const Json newton = cells("strand: Newton", [&] { return newton_swing(once); });
  const double still = kLinks * once.weight * once.gravity / once.stiffness;
  findings.rows.push_back(row("strand of 2024", once, "Newton", newton));
  section.table.rows.push_back({"backward Euler, Newton", formatted("%.4g", largest_drop(newton)), "", "1"});
  std::string summary;
  for (const auto& [substeps, iterations] : schedules(cells.quick())) {
    const HangingWeight hanging = strand(substeps, iterations);
    const SwingResults run = measure_swings(cells, "strand", hanging);
    findings.rows.push_back(row("strand of 2024", hanging, "malha", run.malha));
    findings.rows.push_back(row("strand of 2024", hanging, "plain sweep", run.plain));
    const std::string name = formatted("malha, %d x %d", substeps, iterations);
    section.table.rows.push_back({name, formatted("%.4g", largest_drop(run.malha)),
                                  formatted("%.4g", largest_drop(run.plain)),
                                  formatted("%.3g", largest_drop(run.malha) / largest_drop(newton))});
    if (substeps * iterations == 100)
      append(summary, formatted("%.3g m by %d x %d", largest_drop(run.malha), substeps, iterations));
  }
  section.sentences = {
      "The paper shows a picture: XPBD's strand is too long after 100 iterations, and prints no length; spacing and "
      "the other masses, here 1 kg, are not known to us.",
      formatted("In equilibrium the weight is %.2g m below its initial position; with backward Euler by Newton's "
                "method it is "
                "at most %.2g m below. malha's XPBD, with the work of 100 sweeps (substeps x iterations): ",
                still, largest_drop(newton)) +
          summary + "."};
  findings.sections.push_back(section);
}

int count_strand(bool quick) { return 1 + static_cast<int>(schedules(quick).size()); }

void add_strand_together(Cells& cells, Findings& findings) {
  cells.measure_together([&] { add_strand(cells, findings); });  // it is too short to be divided
}

}  // namespace

const PublishedPart kStrandOf2024{count_strand, add_strand_together};

}  // namespace malha::study
