// SPDX-License-Identifier: Apache-2.0
// Parts of a glTF file: its vertices, and the JSON chunk that describes its binary chunk.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/output/frame_part.h"
#include "host/output/frames.h"

namespace malha {

/// Returns the contents of the binary chunk of a .glb; "" if there is none.
std::string_view glb_binary(std::string_view file);

using Float3 = std::array<float, 3>;

/// Points relative to the centre of their bounding box, where their node is placed. Floats are then precise enough for
/// a small body far from the origin.
struct CentredPoints {
  Float3 middle;               // m
  std::vector<Float3> points;  // m, from `middle`
};
CentredPoints centred(std::span<const Vec3> points);

/// Vertices of a glTF file: for each mesh its points, then copies of those that have several texture coordinates,
/// because a vertex of glTF has one.
struct GlbVertices {
  std::vector<int> point;                // of each vertex
  std::vector<std::size_t> begin;        // first vertex of each mesh, then their number
  std::vector<std::uint32_t> of_corner;  // vertex of each polygon's corner, counted in its mesh
  std::vector<std::array<float, 2>> uv;  // of each vertex; (0, 1) where a mesh has none
  std::vector<bool> has_uv;              // of each mesh

  /// Gathers the points of a mesh.
  std::vector<Vec3> gathered(std::size_t mesh, std::span<const Vec3> points) const;
};
GlbVertices glb_vertices(const FrameTopology& topology);

struct GlbText {
  std::string json;
  std::string rest;  // the binary chunk after the frames
};

/// Builds the JSON and the rest of the binary chunk. `frames`: the bytes of a FramePart with at least one frame. Throws
/// std::logic_error if malha was built without tinygltf.
GlbText glb_text(const FrameTopology& topology, const GlbVertices& vertices, std::string_view frames);

}  // namespace malha
