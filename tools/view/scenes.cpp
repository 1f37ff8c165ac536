// SPDX-License-Identifier: Apache-2.0
#include "tools/view/scenes.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "host/mesh/io/mesh_io.h"

namespace malha::view {

namespace fs = std::filesystem;

std::vector<std::string> scenes_near(const std::string& scene) {
  std::vector<std::string> found;
  std::set<fs::path> seen;
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);  // in bin/
  const fs::path installed = program.parent_path().parent_path() / "share/malha/scenes";
  for (const fs::path& folder : {fs::path(scene).parent_path(), fs::path("scenes"), installed}) {
    const fs::path here = folder.empty() ? fs::path(".") : folder;
    for (const auto& entry : fs::directory_iterator(here, error)) {
      const fs::path& path = entry.path();
      if (path.extension() != ".json" || path.filename() == "schema.json") continue;
      if (seen.insert(fs::weakly_canonical(path, error)).second) found.push_back(path.string());
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

Scene scene_of_mesh(const std::string& path) {
  const Mesh mesh = read_mesh(path);
  Vec3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
  for (const Vec3& point : mesh.points)
    for (int k = 0; k < 3; ++k) low[k] = std::min(low[k], point[k]), high[k] = std::max(high[k], point[k]);
  double size = 0;
  for (int k = 0; k < 3; ++k) size = std::max(size, high[k] - low[k]);
  Scene scene;
  scene.name = fs::path(path).stem().string(), scene.file = path;
  scene.gravity = {0, -9.81, 0}, scene.duration = 10;
  BodySpec body;
  body.name = "mesh", body.shape = MeshFile{fs::absolute(path).string()}, body.mass = 1;
  ConstraintSpec edges;
  edges.type = "distance", edges.elements = {"edges"}, edges.compliance = 1e-6;
  body.constraints = {edges};
  scene.bodies = {body};
  EnvironmentSpec floor;
  floor.name = "floor", floor.shape = BoxShape{{20 * size, 0.2 * size, 20 * size}};
  floor.transform.translate = {(low[0] + high[0]) / 2, low[1] - 0.4 * size, (low[2] + high[2]) / 2};
  floor.friction = 0.5, floor.thickness = std::max(1e-6, 0.005 * size);
  scene.environment = {floor};
  return scene;
}

void throw_ball(Scene& scene, double time, const Vec3& from, const Vec3& velocity, double radius) {
  constexpr double kApart = 1.0 / 30, kFlight = 3;  // s
  EnvironmentSpec ball;
  int number = 1;
  const auto taken = [&] {
    return std::any_of(scene.environment.begin(), scene.environment.end(),
                       [&](const EnvironmentSpec& one) { return one.name == ball.name; });
  };
  do ball.name = "ball " + std::to_string(number++);
  while (taken());
  ball.shape = SphereShape{radius, 3}, ball.thickness = 0.03 * radius, ball.friction = 0.3;
  for (double t = 0; t <= kFlight; t += kApart) {
    Keyframe key;
    key.time = time + t;
    for (int k = 0; k < 3; ++k) key.translate[k] = from[k] + t * velocity[k] + 0.5 * t * t * scene.gravity[k];
    ball.motion.push_back(key);
  }
  scene.environment.push_back(ball);
}

}  // namespace malha::view
