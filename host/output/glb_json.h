// SPDX-License-Identifier: Apache-2.0
// JSON chunk of a glTF file: the description of its binary chunk.
#pragma once
#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/output/frames.h"

namespace malha {

using Float3 = std::array<float, 3>;

/// Points relative to the centre of their bounding box, where their node is placed. Floats are then precise enough for
/// a small body far from the origin.
struct CentredPoints {
  Float3 middle;               // m
  std::vector<Float3> points;  // m, from `middle`
};
CentredPoints centred(std::span<const Vec3> points);

/// Returns the points of a body.
template <class Points>
auto points_of(const FrameTopology& topology, std::size_t body, Points&& points) {
  const std::size_t begin = topology.bodies[body].begin;
  const bool last = body + 1 == topology.bodies.size();
  const std::size_t end = last ? topology.rest.size() : topology.bodies[body + 1].begin;
  return std::span(points).subspan(begin, end - begin);
}

struct GlbText {
  std::string json;
  std::string rest;  // the binary chunk after the frames
};

/// Builds the JSON and the rest of the binary chunk. `frames`: the bytes of a GlbPart with at least one frame. Throws
/// std::logic_error if malha was built without tinygltf.
GlbText glb_text(const FrameTopology& topology, std::string_view frames);

}  // namespace malha
