// SPDX-License-Identifier: Apache-2.0
#include "tools/study/cloth_methods.h"

#include "tools/bench/cloth.h"

namespace malha::study {

Scene ClothMethod::scene(int side) const {
  Scene scene = bench::hanging_cloth(bench::grid_case(side), {substeps, 1});
  scene.file = "malha study";
  if (desbrun) scene.solver.type = "desbrun", scene.solver.desbrun.filter = filter;
  return scene;
}

const char* ClothMethod::style() const {
  if (!desbrun) return "lw 2 ps 0.9 lc rgb '#0072b2' pt 7";
  return filter == FilterKind::Sparse ? "lw 2 ps 0.9 lc rgb '#009e73' pt 13" : "lw 2 ps 0.9 lc rgb '#e69f00' pt 5";
}

double ClothMethod::memory_bytes(double particles) const {
  const double stored =
      filter == FilterKind::Dense ? 2 * particles * particles : 0;  // a triangle of the matrix in float
  return (desbrun ? 900 : 250) * particles + stored;
}

double ClothMethod::setup_peak_bytes(double particles) const {
  return memory_bytes(particles) + (desbrun ? 500 : 400) * particles;
}

const std::vector<ClothMethod>& cloth_methods() {
  static const std::vector<ClothMethod> all{{"PBD, 10 substeps", false, FilterKind::Auto, 10},
                                            {"Desbrun, sparse", true, FilterKind::Sparse, 1},
                                            {"Desbrun, dense", true, FilterKind::Dense, 1}};
  return all;
}

std::string with_commas(long long number) {
  std::string text = std::to_string(number);
  for (int at = static_cast<int>(text.size()) - 3; at > 0; at -= 3) text.insert(at, ",");
  return text;
}

}  // namespace malha::study
