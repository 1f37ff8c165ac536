// SPDX-License-Identifier: Apache-2.0
// Polygons of frames as the bodies' mesh files have them, with texture coordinates and the names of objects, groups and
// materials. A body that may tear has the faces of the simulation instead, with what the file says of each.
#pragma once
#include <map>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/mesh/io/mesh_io.h"
#include "host/output/frames.h"

namespace malha {

class TopologyBuilder {
 public:
  /// The builder adds to `all`, which must outlive it and has all points.
  TopologyBuilder(const Scene& scene, FrameTopology& all) : scene_(scene), all_(all) {}

  /// Adds the meshes of the next body. Its points are begin ... end - 1, its faces have these as corners. Throws
  /// InputError for a mesh file that cannot be read again or has other vertices now.
  void add_body(int begin, int end, const std::vector<Quad>& faces);

  /// Names the objects of the environment, after all bodies.
  void name_environment();

 private:
  /// A body's mesh file.
  struct Source {
    FileMesh file;
    std::string path;         // "": the body has no file, or one without polygons
    std::vector<int> new_uv;  // index among those of the frames of each of the file's texture coordinates; -1: none
  };

  void add_mesh(const std::string& name, int begin);
  /// Adds a polygon of these points, with what the file says of its polygon `like`; -1: nothing. Corner k of it is
  /// corner of_corner(k) of that polygon.
  template <class OfCorner>
  void add_polygon(std::span<const int> points, Source& source, int like, const OfCorner& of_corner);
  void add_polygons_of_file(int begin, Source& source);
  void add_faces(int begin, int end, const std::vector<Quad>& faces, Source& source);
  int group_of(const Source& source, int polygon);
  int material_of(const Source& source, int polygon);

  const Scene& scene_;
  FrameTopology& all_;
  std::size_t body_ = 0;  // the next one
  std::set<std::string> mesh_names_, material_names_;
  std::map<std::string, int> groups_;
  std::map<std::pair<std::string, int>, int> materials_;  // by file and index there
};

}  // namespace malha
