// SPDX-License-Identifier: Apache-2.0
// This says which particles and objects of one layout those of another one are, so that contacts can keep their memory
// where a scene tears or is replaced.
#pragma once
#include <vector>

#include "host/model/model.h"

namespace malha {

/// The index in the layout before of each particle (the solver's order) and of each object or group of objects in this
/// one; kNew: it was none. An object whose contacts begin anew, because its surface or its distance is another one,
/// counts as new.
struct LayoutMap {
  static constexpr int kNew = -1;
  std::vector<int> particles;
  std::vector<int> meshes, shapes, deforming, edge_groups;  // rigid meshes, exact shapes, meshes that deform; "edges"
  bool keeps_self_distances = false;                        // pairs of self-collision keep their distances
  bool releases = false;                                    // a particle was pinned and is not any more

  /// Tells whether a pair of a particle and the k-th of some objects is new.
  bool is_new(const std::vector<int>& objects, std::size_t k, std::size_t particle) const {
    return objects[k] == kNew || particles[particle] == kNew;
  }
  /// Tells whether the particles are those of the layout before, which had this many, in the same order.
  bool has_same_particles(std::size_t count) const;
  /// Tells whether any pair of a particle and one of these objects is new.
  bool has_new(const std::vector<int>& objects) const;
};

/// The map of a layout whose particles are these and whose objects are those of the model before. Distances between
/// primitives are found anew, as where a vertex splits.
LayoutMap map_of_particles(const Model& model, std::vector<int> particles);

/// The map of a scene that replaces another one at a time (s). Bodies are the same if they have the same name and
/// number of particles, objects if their name, surface, thickness, sides and place are the same. `user`: the index in
/// `before` of each particle of `after` in the user's order, or kNew.
LayoutMap map_of_scenes(const Model& before, const Model& after, const std::vector<int>& user, double time);

}  // namespace malha
