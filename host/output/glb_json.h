// SPDX-License-Identifier: Apache-2.0
// The JSON chunk of a glTF file: what its binary chunk holds, and how it belongs together.
#pragma once
#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/output/frames.h"

namespace malha {

using Float3 = std::array<float, 3>;

/// Points about the middle of the box around them, which is where their node is: floats have digits enough for a small
/// body far from the origin.
struct CentredPoints {
  Float3 middle;               // m
  std::vector<Float3> points;  // m, from there
};
CentredPoints centred(std::span<const Vec3> points);

/// The points of a body.
template <class Points>
auto points_of(const FrameTopology& topology, std::size_t body, Points&& points) {
  const std::size_t begin = topology.bodies[body].begin;
  const bool last = body + 1 == topology.bodies.size();
  const std::size_t end = last ? topology.rest.size() : topology.bodies[body + 1].begin;
  return std::span(points).subspan(begin, end - begin);
}

struct GlbText {
  std::string json;
  std::string rest;  // of the binary chunk, behind the frames
};

/// `frames`: what a GlbPart has, of one frame or more. Throws std::logic_error where malha was built without tinygltf.
GlbText glb_text(const FrameTopology& topology, std::string_view frames);

}  // namespace malha
