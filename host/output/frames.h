// SPDX-License-Identifier: Apache-2.0
// Writer of a run's frames for other programs: ParaView, Blender, Maya, Houdini, MeshLab.
#pragma once
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "host/mesh/polygons.h"
#include "host/model/model.h"

namespace malha {

/// A mesh is what other programs see as one object: a body, or an object of a body's file.
struct FrameMesh {
  std::string name;  // no other mesh has it
  int body;          // its index in the scene
  int begin;         // index of its first point
  int polygon;       // index of its first polygon
};

/// A material of polygons.
struct FrameMaterial {
  std::string name;                    // no other material has it
  std::string file;                    // the mesh file that uses it
  std::string in_file;                 // its name there
  int index;                           // in that file's list of materials
  std::vector<std::string> libraries;  // what an OBJ file names as its files of materials
};

/// Topology that all frames share, in the user's numbering; several bodies are concatenated.
struct FrameTopology {
  Polygons polygons;                // mesh by mesh, with the texture coordinates, groups and materials of their files
  std::vector<Edge> lines;          // edges that belong to no face
  std::vector<int> loose;           // points that belong to no face and no line
  std::vector<Vec3> rest;           // points at rest, m; every frame has as many
  bool in_double = false;           // writes doubles, not floats, in formats that have them (all but pc2)
  std::vector<int> unused{};        // points that no element uses, but that count in the numbering
  std::vector<FrameMesh> meshes{};  // at least one
  std::vector<FrameMaterial> materials{};          // of the polygons
  std::vector<std::string> environment_names{};    // of its objects, which no mesh and no other object has
  std::span<const EnvironmentMesh> environment{};  // used by "glb" and "usda" alone; it must outlive the writer
};

/// The polygons of a mesh: the first, and the one behind the last.
struct PolygonRange {
  std::size_t first, end;
};
inline PolygonRange polygons_of(const FrameTopology& topology, std::size_t mesh) {
  const bool last = mesh + 1 == topology.meshes.size();
  return {static_cast<std::size_t>(topology.meshes[mesh].polygon),
          last ? topology.polygons.count() : static_cast<std::size_t>(topology.meshes[mesh + 1].polygon)};
}

/// Returns the points of a mesh.
template <class Points>
auto points_of(const FrameTopology& topology, std::size_t mesh, Points&& points) {
  const auto begin = static_cast<std::size_t>(topology.meshes[mesh].begin);
  const bool last = mesh + 1 == topology.meshes.size();
  const std::size_t end = last ? topology.rest.size() : static_cast<std::size_t>(topology.meshes[mesh + 1].begin);
  return std::span(points).subspan(begin, end - begin);
}

/// Number of vertices of objects that deform, of which "glb" stores displacements as it does those of bodies.
std::size_t deforming_vertices(std::span<const EnvironmentMesh> environment);
/// Throws InputError if a "glb" file cannot hold this many frames of this many points, those of such objects included.
void check_glb(const Scene& scene, std::size_t points, std::int64_t frames);

class FrameFormat;  // host/output/frame_formats.h

/// Writes frames in any of these formats:
///   "vtp"  frame_000000.vtp ... (VTK PolyData, raw appended; point data "velocity") and frames.pvd with the times
///   "pc2"  points_NAME.pc2 for each mesh (PointCache2, one sample a frame, which knows floats only) and rest.obj with
///          all of them in the same order of vertices (Blender's Mesh Cache)
///   "ply"  frame_000000.ply ... (binary; the velocity as vx, vy, vz)
///   "obj"  frame_000000.obj ... (as many digits as it takes to read back the same number)
///   "glb"  run.glb (glTF 2.0: bodies, environment, frames on a timeline), which appears at finish()
///   "usda" run.usda (USD text: the same), which appears at finish()
/// "obj", "pc2" and "glb" write the materials, the first two into materials.mtl.
class FrameWriter {
 public:
  /// Makes the folder if it is missing. `next` is the index of the first frame to be written: frames of an earlier run
  /// from there on are removed, those before it are kept (next > 0 continues a run, 0 starts a new one). Throws
  /// std::runtime_error that names the path: folder or file that cannot be written, or a point cache that does not
  /// continue at `next`; std::invalid_argument for an unknown format.
  FrameWriter(const std::filesystem::path& folder, const std::vector<std::string>& formats,
              const FrameTopology& topology, int next = 0);
  FrameWriter(FrameWriter&&) noexcept;
  FrameWriter& operator=(FrameWriter&&) noexcept;
  ~FrameWriter();

  /// Writes the next frame; `points` (m) and `velocities` (m/s) are as many as the points at rest, else
  /// std::invalid_argument. Throws std::runtime_error that names the path (full disk).
  void write(double time, std::span<const Vec3> points, std::span<const Vec3> velocities);

  /// Completes files that are valid only after the last write. Throws as write() does.
  void finish();

  /// Returns the index of the next frame to be written.
  int next() const { return next_; }

 private:
  std::size_t point_count_;
  int next_;
  std::vector<std::unique_ptr<FrameFormat>> formats_;
};

}  // namespace malha
