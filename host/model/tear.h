// SPDX-License-Identifier: Apache-2.0
// Tearing (Müller et al. 2006, figure 10) and cutting by a knife: the vertices that split, and the model after the
// splits.
#pragma once
#include <vector>

#include "host/model/model.h"

namespace malha {

/// The split of a vertex into two. `faces` and `lines` get the duplicate, which is the body's next particle; the others
/// keep the vertex.
struct Split {
  int body, vertex;
  std::vector<int> faces, lines;  // in the body's numbering, ascending
};

/// Splits the vertex: appends its duplicate at the same position.
void apply(const Split& split, Mesh& mesh);

/// Finds the splits for the positions x (m, the user's order). For each overstretched edge, the most strained first,
/// one of its ends splits along the plane through it that is perpendicular to the edge. A split relieves its
/// neighbourhood, so that only one vertex of a neighbourhood splits at a time. Pinned vertices do not split, nor those
/// with no faces or lines beyond the plane. `pinned`: see pinned_now().
std::vector<Split> find_tears(const Model& model, const std::vector<Vec3>& x, const std::vector<bool>& pinned);

/// Finds the cut of a knife: the splits that separate the two ends of these edges (the user's numbering), each given as
/// {left, right} of the knife. The cut runs along edges of the mesh, on the left of the knife, or on the right if fewer
/// ends are pinned there. Crossed faces stay whole, on the other side of the cut. A vertex all of whose faces are
/// crossed is not split. Pinned vertices split too, and both resulting particles are pinned. Ends that no longer share
/// a face or line are left as they are. `pinned`: see pinned_now(). Throws InputError for an index out of range, for an
/// edge between two bodies, and for a body without "tear".
std::vector<Split> find_cuts(const Model& model, const std::vector<Edge>& crossed, const std::vector<bool>& pinned);

/// Tells whether each particle (the user's numbering) is pinned at `time` (s), or among the particles `held` by the
/// user.
std::vector<bool> pinned_now(const Model& model, double time, const std::vector<int>& held = {});

/// The intact meshes of a scene and the splits since, from which a torn model is built.
struct TearState {
  const RenderMesh* intact;          // before any tear
  const std::vector<Split>* splits;  // in the order in which they happened
  const std::vector<EnvironmentMesh>* environment;
  int zero_area_faces;
  const std::vector<std::string>* notes;
};

/// Builds the model after the splits. Rest lengths are those of the intact mesh, and masses are shared as in it, so
/// that the two parts of a vertex together have its mass.
Model build_torn_model(const Scene& scene, const TearState& torn, const OpenMP& threads = 1,
                       const PatchBounds& bounds = {});

/// The mesh of a body at the start, in the body's numbering.
Mesh body_mesh(const RenderMesh& render_mesh, std::size_t body);

/// The edges that may tear, in the solver's numbering, and the lengths (m) beyond which they do.
struct TearableEdges {
  std::vector<Edge> ends;
  std::vector<double> max_length;
};
TearableEdges tearable_edges(const Model& model);

/// True if a body of the scene has "tear".
bool can_tear(const Scene& scene);

/// For each particle of `after` (the solver's order) the particle of `before` that it is or is a duplicate of. The
/// splits from `first` on happened between the two models.
std::vector<int> ancestors(const Model& before, const Model& after, const std::vector<Split>& splits,
                           std::size_t first);

/// Splits as integers, for checkpoints.
std::vector<int> encode_splits(const std::vector<Split>& splits);
/// The splits that encode_splits() encoded. Throws InputError, which names `file`, unless they can be applied to the
/// bodies of `intact` one after the other.
std::vector<Split> decode_splits(const std::vector<int>& numbers, const Scene& scene, const RenderMesh& intact,
                                 const std::string& file);

}  // namespace malha
