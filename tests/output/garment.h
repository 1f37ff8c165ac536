// SPDX-License-Identifier: Apache-2.0
// A garment of two objects as a file with all that OBJ says of faces, and runs of it.
#pragma once
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "host/base/file.h"
#include "host/mesh/io/mesh_io.h"
#include "malha/simulation.h"
#include "tests/run_scenes.h"
#include "tests/support.h"

namespace malha {

/// Two objects. The cape is of a pentagon, a quad and a triangle in two materials and two groups, with a seam in its
/// texture coordinates along the edge of vertices 2 and 3, and has a vertex that nothing uses. The hood is a triangle
/// without texture coordinates.
inline constexpr char kGarment[] = R"(mtllib cloth of two.mtl
o Cape of wool
v 0 0 0
v 1 0 0
v 1 1 0.1
v 0 1 0
v -0.5 0.5 0.1
v 2 0 0
v 2 1 0.3
v 9 9 9
vt 0 0
vt 0.5 0
vt 0.5 0.5
vt 0 0.5
vt -0.25 0.25
vt 0.6 0
vt 0.6 0.5
vt 0.9 0.1
vt 0.9 0.7
g back
usemtl Wool red
f 1/1 2/2 3/3 4/4 5/5
g side
usemtl lining
f 3/7 2/6 6/8
f 3/7 6/8 7/9
o Hood
v 0 2 0
v 1 2 0
v 0 3 0.2
usemtl Wool red
f 9 10 11
)";

inline constexpr char kGarmentMaterials[] = R"(# made by hand
newmtl Wool red
Kd 0.8 0.1 0.05
map_Kd -s 2 2 1 pictures/wo ol.png
newmtl lining
Kd 0.2 0.3 0.4
d 0.5
)";

/// A PNG of one pixel.
inline const std::string kPicture(
    "\x89\x50\x4e\x47\x0d\x0a\x1a\x0a\x00\x00\x00\x0d\x49\x48\x44\x52\x00\x00\x00\x01\x00\x00\x00\x01\x08\x06\x00\x00"
    "\x00\x1f\x15\xc4\x89\x00\x00\x00\x0d\x49\x44\x41\x54\x78\xda\x63\xfc\xcf\xc0\x50\x0f\x00\x04\x85\x01\x80\x84\xa9"
    "\x8c\x21\x00\x00\x00\x00\x49\x45\x4e\x44\xae\x42\x60\x82",
    70);

class GarmentRun : public testing::Test {
 protected:
  GarmentRun() {
    garment_ = folder_.write("garment.obj", kGarment);
    folder_.write("cloth of two.mtl", kGarmentMaterials);
    std::filesystem::create_directory(folder_ / "pictures");
    write_whole(folder_ / "pictures/wo ol.png", kPicture);
    scene_ = swinging_sheet(false);
    Json& body = scene_["bodies"][0];
    body["name"] = "garment", body["shape"] = {{"mesh", garment_}}, body["pins"] = {{{"particles", {0}}}};
    body["constraints"] = {{{"type", "distance"}, {"compliance", 1e-4}}};
    body.erase("transform");
  }

  /// Runs four steps, and returns the folder of the frames.
  std::filesystem::path run(const std::vector<std::string>& formats) {
    scene_["outputs"]["frames"] = {{"every", 1}, {"formats", formats}};
    run_quietly(scene_, {.out = (folder_ / "out").string(), .steps = 4});
    return folder_ / "out/frames";
  }

  /// The places of the file's vertices after four steps, m.
  std::vector<Vec3> places() {
    Simulation simulation(parsed(scene_), {.threads = 1});
    for (int k = 0; k < 4; ++k) simulation.step();
    const std::vector<Vec3> x = simulation.positions();
    std::vector<Vec3> all;
    for (std::size_t b = 0; b < scene_["bodies"].size(); ++b)
      for (const int particle : simulation.particles_of_vertices(b))
        all.push_back(particle < 0 ? Vec3{9, 9, 9} : x[static_cast<std::size_t>(particle)]);
    return all;
  }

  TemporaryFolder folder_;
  std::string garment_;
  Json scene_;
};

inline std::vector<std::vector<int>> corner_lists_of(const Polygons& polygons) {
  std::vector<std::vector<int>> all;
  for (std::size_t f = 0; f < polygons.count(); ++f) {
    const auto corners = polygons.corners_of(f);
    all.emplace_back(corners.begin(), corners.end());
  }
  return all;
}

inline std::array<double, 2> uv_at(const Polygons& polygons, int corner) {
  const int uv = polygons.corner_uv.empty() ? -1 : polygons.corner_uv[static_cast<std::size_t>(corner)];
  return uv < 0 ? std::array{-9.0, -9.0} : polygons.uv[static_cast<std::size_t>(uv)];
}

inline std::vector<std::string> named(const std::vector<std::string>& names, const std::vector<int>& of) {
  std::vector<std::string> all;
  for (const int i : of) all.push_back(i < 0 ? "" : names[static_cast<std::size_t>(i)]);
  return all;
}

}  // namespace malha
