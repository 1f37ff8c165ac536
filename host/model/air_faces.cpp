// SPDX-License-Identifier: Apache-2.0
#include "host/model/air_faces.h"

namespace malha {

void add_air_faces(const Mesh& mesh, const std::vector<int>& solver_index, AirFaces& all) {
  std::vector<std::vector<int>> incident(mesh.points.size());
  for (Quad face : mesh.faces) {
    for (int& corner : face) {
      if (corner < 0) continue;
      incident[corner].push_back(static_cast<int>(all.faces.size()));
      corner = solver_index[corner];
    }
    all.faces.push_back(face);
  }
  if (all.begin.empty()) all.begin = {0};
  for (std::size_t i = 0; i < incident.size(); ++i) {
    if (incident[i].empty()) continue;
    all.particle.push_back(solver_index[i]);
    all.incident.insert(all.incident.end(), incident[i].begin(), incident[i].end());
    all.begin.push_back(static_cast<int>(all.incident.size()));
  }
}

}  // namespace malha
