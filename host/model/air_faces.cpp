// SPDX-License-Identifier: Apache-2.0
#include "host/model/air_faces.h"

namespace malha {

void add_air_faces(const Mesh& mesh, const std::vector<int>& name, AirFaces& all) {
  std::vector<std::vector<int>> around(mesh.points.size());
  for (Quad face : mesh.faces) {
    for (int& corner : face) {
      if (corner < 0) continue;
      around[corner].push_back(static_cast<int>(all.faces.size()));
      corner = name[corner];
    }
    all.faces.push_back(face);
  }
  if (all.begin.empty()) all.begin = {0};
  for (std::size_t i = 0; i < around.size(); ++i) {
    if (around[i].empty()) continue;
    all.particle.push_back(name[i]);
    all.around.insert(all.around.end(), around[i].begin(), around[i].end());
    all.begin.push_back(static_cast<int>(all.around.size()));
  }
}

}  // namespace malha
