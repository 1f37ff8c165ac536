// SPDX-License-Identifier: Apache-2.0
// glTF 2.0 files (.glb, .gltf): meshes, the nodes that place them, skins, morph targets, and clips. Of materials
// there are the names; cameras and lights are skipped.
#pragma once
#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/mesh/affine.h"
#include "host/mesh/io/mesh_io.h"
#include "malha/mesh.h"

namespace malha {

using Quaternion = std::array<double, 4>;  // x, y, z, w

/// The place of a node in the frame of its parent: x -> translation + rotation (scale x).
struct GltfPlace {
  Vec3 translation{0, 0, 0};  // m
  Quaternion rotation{0, 0, 0, 1};
  Vec3 scale{1, 1, 1};
};

struct GltfNode {
  std::string name;
  int parent = -1;  // an earlier node; -1: a root
  GltfPlace place;
  std::optional<Affine> matrix{};  // instead of the place; such nodes are not animated
};

/// What carries vertices: a joint of a skin, or, with the identity as `inverse_bind`, the node of a mesh without skin.
struct GltfJoint {
  int node;
  Affine inverse_bind{};
};

/// The share of a vertex that follows a joint.
struct GltfInfluence {
  int joint;
  double weight;  // > 0; those of a vertex add up to 1
};

/// A morph target of a mesh on a node: the vertices that it moves, and by how much at a weight of 1.
struct GltfTarget {
  int weight;                 // index in the weights of all targets
  std::vector<int> vertices;  // ascending
  std::vector<std::array<float, 3>> differences;
};

enum class GltfPath { Translation, Rotation, Scale, Weights };
enum class GltfInterpolation { Step, Linear, CubicSpline };

/// The values of one property of a node over time.
struct GltfChannel {
  GltfPath path;
  GltfInterpolation interpolation;
  int target;                  // a node, or, of Weights, the first weight of its mesh
  int size;                    // numbers of a value
  std::vector<double> times;   // s, ascending
  std::vector<double> values;  // `size` for each time; of CubicSpline the tangent before, the value, the tangent after
};

struct GltfClip {
  std::string name;
  std::vector<GltfChannel> channels;
};

/// Places of all nodes, and the weights of all morph targets.
struct GltfPose {
  std::vector<GltfPlace> places;
  std::vector<double> weights;
};

/// A file. Vertices and faces are those of the nodes of its scene, depth first, each by its mesh's primitives.
struct GltfScene {
  std::vector<GltfNode> nodes;  // parents before their children
  std::vector<GltfJoint> joints;
  std::vector<Vec3> points;          // m, of each vertex before morph targets and joints
  std::vector<int> influence_begin;  // first influence of each vertex, then their number
  std::vector<GltfInfluence> influences;
  std::vector<GltfTarget> targets;
  std::vector<std::array<float, 4>> colours;  // of each vertex, its COLOR_0; empty if no primitive has any
  Polygons triangles;  // with TEXCOORD_0 where it is read; objects are the nodes that have a mesh
  std::vector<GltfClip> clips;
  GltfPose rest;  // the pose without a clip
};

/// Reads a file whose content is `data`; buffers beside it are read from its folder. Throws InputError, which names the
/// file and the part of it, what was found and what is allowed.
GltfScene read_gltf_scene(const std::string& file, std::string_view data, Attributes attributes = Attributes::None);

/// Leaves only these vertices, in this order, and no triangles.
void select_vertices(GltfScene& file, std::span<const int> vertices);

/// Memory of deform(), which later calls use again.
struct GltfMaps {
  std::vector<Affine> nodes, joints;
};
/// The positions of all vertices (m) in a pose, mapped by `map`.
void deform(const GltfScene& file, const GltfPose& pose, const Affine& map, std::span<Vec3> points, GltfMaps& memory);
void deform(const GltfScene& file, const GltfPose& pose, const Affine& map, std::span<Vec3> points);

}  // namespace malha
