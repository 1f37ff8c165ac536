// SPDX-License-Identifier: Apache-2.0
#include "tools/study/published/published.h"

#include "tools/bench/output.h"
#include "tools/study/published/parts.h"

namespace malha::study {

Scene published_scene(const BodySpec& body, double dt, int substeps, int iterations, double gravity) {
  Scene scene;
  scene.file = "malha study", scene.name = body.name;
  scene.solver.dt = dt, scene.solver.substeps = substeps, scene.solver.iterations = iterations;
  scene.solver.precision = Precision::Double, scene.solver.levels = 0;  // the papers have none
  scene.gravity = {0, -gravity, 0};
  scene.bodies = {body};
  return scene;
}

std::string percent(double part) { return bench::formatted("%.3g %%", 100 * part); }

Findings run_published(Cells& cells) {
  const PublishedPart parts[] = {kSpringOf2016, kChainOf2016,  kWeightOf2019,
                                 kStrandOf2024, kSheetsOf2008, kClothOf2006};
  int planned = 0;
  for (const PublishedPart& part : parts) planned += part.cells(cells.quick());
  cells.plan(planned);
  Findings findings;
  for (const PublishedPart& part : parts) part.add(cells, findings);
  return findings;
}

}  // namespace malha::study
