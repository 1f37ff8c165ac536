// SPDX-License-Identifier: Apache-2.0
// Tearing (Müller et al. 2006, figure 10): which vertices split, and meshes after that.
#pragma once
#include <vector>

#include "host/model/model.h"

namespace malha {

/// A vertex of a body becomes two: `faces` and `lines` get the duplicate, the body's next particle, the others keep it.
struct Split {
  int body, vertex;
  std::vector<int> faces, lines;  // numbers in the body, ascending
};

/// Appends the duplicate, at the vertex' place.
void apply(const Split& split, Mesh& mesh);

/// The splits that x (m, the user's order) asks for: edge by edge, the most strained first, one end each, along the
/// plane through it that is perpendicular to the edge. A split relieves what is around it, so that of one neighbourhood
/// only one vertex splits. Pinned vertices, and those that have nothing beyond the plane, do not.
/// `pinned`: see pinned_now().
std::vector<Split> find_tears(const Model& model, const std::vector<Vec3>& x, const std::vector<bool>& pinned);

/// Whether each particle (the user's number) is pinned at `time` (s), or `held`.
std::vector<bool> pinned_now(const Model& model, double time, const std::vector<int>& held = {});

/// What a torn model is made of.
struct Torn {
  const RenderMesh* whole;         // before any tear
  const std::vector<Split>* done;  // since then, in this order
  const std::vector<EnvironmentMesh>* environment;
  int zero_area_faces;
  const std::vector<std::string>* notes;
};

/// Lays the model out with these splits. Rest lengths are those of the whole mesh; a mass is shared as in it, so that
/// the parts of a vertex weigh what it weighed.
Model build_torn_model(const Scene& scene, const Torn& torn, int threads = 1, const PatchBounds& bounds = {});

/// The mesh of a body as it was made, numbered by itself.
Mesh body_mesh(const RenderMesh& render_mesh, std::size_t body);

/// The edges that tear where they become too long, in the solver's numbers, and how long that is (m).
struct Breakable {
  std::vector<Edge> ends;
  std::vector<double> longest;
};
Breakable breakable(const Model& model);

/// Whether a body of the scene tears.
bool tears(const Scene& scene);

/// For each particle of `after` (the solver's order), which one of `before` it is or is a duplicate of. Between them
/// lie the splits from `first` on.
std::vector<int> ancestors(const Model& before, const Model& after, const std::vector<Split>& done, std::size_t first);

/// As integers, for checkpoints, and back. The way back throws InputError, which names `file`, unless the integers are
/// splits that can be applied to the bodies of `whole` one after the other.
std::vector<int> numbers_of(const std::vector<Split>& splits);
std::vector<Split> splits_of(const std::vector<int>& numbers, const Scene& scene, const RenderMesh& whole,
                             const std::string& file);

}  // namespace malha
