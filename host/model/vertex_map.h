// SPDX-License-Identifier: Apache-2.0
// Values at the points of a body's mesh from a map of its shape's vertices.
#pragma once
#include <string>
#include <vector>

#include "kernels/projection/constraint_kind.h"
#include "malha/scene.h"

namespace malha {

/// The place of a map, for messages: the scene's file and a JSON pointer.
struct MapPlace {
  std::string file, pointer;
};

/// The values of a map at the points of the mesh of a shape, before any tear. A point that several vertices were merged
/// into has their mean, and a vertex with several texture coordinates that of what the picture has there. Throws
/// InputError: a list of another length, colours, texture coordinates or a picture that are not there.
std::vector<double> values_at_points(const Shape& shape, const Mesh& mesh, const VertexMap& map, const MapPlace& place);

/// Factors that a map may have, as numbers of scenes do.
inline constexpr double kLeastFactor = 1e-18, kMostFactor = 1e18;
struct FactorRange {
  bool zero_allowed = false;
  double most = kMostFactor;
};

/// The same for a body of the scene. Refuses values outside of the range.
std::vector<double> factors_at_points(const Scene& scene, std::size_t body, const Mesh& mesh, const VertexMap& map,
                                      const std::string& pointer, const FactorRange& range = {});

/// Factors of a parameter of this value. Refuses those that take it out of its range.
std::vector<double> parameter_factors_at_points(const Scene& scene, std::size_t body, const Mesh& mesh,
                                                const VertexMap& map, const Parameter& parameter, double value,
                                                const std::string& pointer);

/// A picture: its channels from the top row on, each in [0, 1].
struct ChannelPicture {
  int width = 0, height = 0, channels = 0;
  std::vector<float> values;

  /// The value of a channel (0 to 3: red, green, blue, alpha) at the texture coordinates u and v: linear between the
  /// middles of pixels, and constant from there to the borders. Beyond 0 and 1 the picture repeats. Grey pictures have
  /// one value for red, green and blue.
  double at(int channel, double u, double v) const;
};

/// Reads a PNG or JPEG file, of 8 or 16 bits a channel. Throws InputError.
ChannelPicture read_picture(const std::string& path);

}  // namespace malha
