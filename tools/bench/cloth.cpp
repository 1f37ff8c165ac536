// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/cloth.h"

#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "host/mesh/generate.h"
#include "host/mesh/topology.h"
#include "host/model/pins.h"
#include "host/output/frames.h"
#include "tools/bench/irregular.h"

namespace malha::bench {

namespace {

constexpr double kSize = 2, kMass = 1;  // m, kg

/// Writes the mesh into the folder and returns the file's path.
std::string write_ply(const Mesh& mesh, const std::filesystem::path& folder) {
  FrameTopology topology{polygons_of(mesh.faces), {}, {}, mesh.points};
  topology.meshes = {{"sheet", 0, 0, 0}};
  const std::vector<Vec3> still(topology.rest.size());
  FrameWriter(folder, {"ply"}, topology).write(0, topology.rest, still);
  return (folder / "frame_000000.ply").string();
}

double distance(const Vec3& a, const Vec3& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

}  // namespace

ScratchFolder::ScratchFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "malha_bench_XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error(name + ": cannot make the folder");
  path_ = name;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

Case grid_case(int side) {
  return {"grid", side, double(side), GridShape{{kSize, kSize}, {side - 1, side - 1}}, {"edges", "shear"}, nullptr};
}

Case irregular_case(int particles) {
  const int side = static_cast<int>(std::lround(std::sqrt(particles)));
  const auto folder = std::make_shared<const ScratchFolder>();
  const MeshFile file{write_ply(irregular_sheet(side, kSize), folder->path())};
  return {"irregular", side * side, double(side), file, {"edges"}, folder};
}

Scene hanging_cloth(const Case& which, const Schedule& schedule) {
  ConstraintSpec distance;
  distance.type = "distance";
  distance.elements = which.on;
  BodySpec body;
  body.name = which.name + " " + std::to_string(which.n) + ", " + schedule.name();  // messages quote it
  body.shape = which.shape;
  body.mass = kMass;
  body.constraints = {distance};
  body.pins = {BoxPin{{-kSize, -kSize, 0}, {2 * kSize, kSize, 0}}};
  Scene scene;
  scene.file = "malha bench";
  scene.name = "a hanging cloth";
  scene.solver.dt = 1.0 / 60;
  scene.solver.substeps = schedule.substeps;
  scene.solver.iterations = schedule.iterations;
  if (!schedule.levels) scene.solver.levels = 0;
  scene.gravity = {0, -9.81, 0};
  scene.bodies = {body};
  return scene;
}

Cloth cloth_of(const Scene& scene) {
  const BodySpec& body = scene.bodies.front();
  const Mesh mesh = make_mesh(body.shape);
  Cloth cloth{mesh.points, masses_by_total(mesh, *body.mass), find_boundary_conditions(scene, 0, mesh).pinned, {}};
  for (const std::string& on : body.constraints.front().elements)
    for (const Edge& link : on == "shear" ? shear(mesh) : edges(mesh))
      if (!cloth.pinned[link[0]] || !cloth.pinned[link[1]]) cloth.links.push_back(link);
  return cloth;
}

Strain strain(const Cloth& cloth, const std::vector<Vec3>& positions) {
  Strain result;
  double squares = 0;
  for (const auto& [a, b] : cloth.links) {
    const double rest = distance(cloth.points[a], cloth.points[b]);
    const double part = std::abs(distance(positions[a], positions[b]) - rest) / rest;
    squares += part * part;
    result.max = std::max(result.max, part);
  }
  result.rms = std::sqrt(squares / static_cast<double>(cloth.links.size()));
  return result;
}

}  // namespace malha::bench
