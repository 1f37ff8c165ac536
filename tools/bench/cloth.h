// SPDX-License-Identifier: Apache-2.0
// The hanging cloth of the benchmarks: a scene for malha, and plain lists for other libraries.
#pragma once
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "malha/scene.h"

namespace malha::bench {

struct Schedule {
  int substeps = 10, iterations = 1;
  bool levels = false;  // the scene's default, "auto"
  std::string name() const {
    return std::to_string(substeps) + "x" + std::to_string(iterations) + (levels ? " levels" : "");
  }
  int projections() const { return substeps * iterations; }  // of each constraint in a step
  bool operator==(const Schedule&) const = default;
};

/// A new folder below the system's folder for temporary files; the destructor removes it.
class ScratchFolder {
 public:
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// A cloth of 2 m x 2 m and 1 kg in the plane y = 0, pinned where z = 0.
struct Case {
  std::string name;  // "grid" or "irregular"
  int n = 0;         // particles a side of the grid; particles of the irregular mesh
  double side = 0;   // particles a side, for charts; the square root of n for the irregular mesh
  Shape shape;
  std::vector<std::string> on;                  // elements of the distance constraints: "edges", "shear"
  std::shared_ptr<const ScratchFolder> folder;  // contains the shape's mesh file; null for the grid
};

Case grid_case(int side);
/// An irregular mesh of about `particles` particles (side * side, see irregular.h), written as a PLY file.
Case irregular_case(int particles);

/// A scene of distance constraints of stiffness 1 and gravity; dt = 1/60 s, float. The schedule decides about levels,
/// so that a sweep over the particles alone can be measured too.
Scene hanging_cloth(const Case& which, const Schedule& schedule);

/// The scene's only body; particles are in the order of its mesh.
struct Cloth {
  std::vector<Vec3> points;  // m
  std::vector<double> mass;  // kg, of pinned particles too
  std::vector<bool> pinned;
  std::vector<Edge> links;  // without those between two pinned particles
};
Cloth cloth_of(const Scene& scene);

struct Strain {
  double rms = 0, max = 0;  // of |l - l0| / l0 over the links
};
Strain strain(const Cloth& cloth, const std::vector<Vec3>& positions);

}  // namespace malha::bench
