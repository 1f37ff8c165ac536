// SPDX-License-Identifier: Apache-2.0
#include "host/environment/layout_map.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <utility>

#include "host/attachments/object_motion.h"
#include "host/environment/edge_surface.h"
#include "host/model/ordering/index_map.h"
#include "host/model/tear.h"

namespace malha {

namespace {

using Objects = std::vector<const EnvironmentMesh*>;

/// The objects of each kind, in the order of the colliders that have them.
struct Kinds {
  Objects meshes, shapes, deforming;
  std::vector<Objects> edge_groups;
  explicit Kinds(const Model& model) : edge_groups(malha::edge_groups(model)) {
    for (const EnvironmentMesh& one : model.environment)
      (deforms(one) ? deforming : one.exact ? shapes : meshes).push_back(&one);
  }
};

bool same_place(const Pose& a, const Pose& b) { return std::memcmp(a.r, b.r, sizeof a.r) == 0 && same(a.t, b.t); }

bool same_surface(const EnvironmentMesh& a, const EnvironmentMesh& b) {
  if (a.exact.has_value() != b.exact.has_value()) return false;
  if (!a.exact) return a.mesh.faces == b.mesh.faces && a.mesh.points == b.mesh.points;
  const ConvexShape &s = a.exact->shape, &t = b.exact->shape;
  return s.kind == t.kind && same(s.half, t.half) && s.radius == t.radius && same_place(a.exact->pose, b.exact->pose);
}

/// Tells whether what is kept of contacts with one object is right for the other.
bool same_contacts(const EnvironmentMesh& a, const EnvironmentMesh& b, double time) {
  const EnvironmentSpec &s = a.spec, &t = b.spec;
  if (s.name != t.name || s.thickness != t.thickness || s.sides != t.sides || deforms(a) != deforms(b)) return false;
  if (!same_surface(a, b)) return false;
  return deforms(a) ? points_at(a, time) == points_at(b, time)
                    : same_place(pose_at(s.motion, time), pose_at(t.motion, time));
}

/// The index of each of `now` in `then`, of which it is one by `same`.
template <class All, class Same>
std::vector<int> indices(const All& now, const All& then, const Same& same) {
  std::vector<int> all;
  for (const auto& one : now) {
    const auto found = std::ranges::find_if(then, [&](const auto& other) { return same(one, other); });
    all.push_back(found == then.end() ? LayoutMap::kNew : static_cast<int>(found - then.begin()));
  }
  return all;
}

double thickness_factor(const Model& model, std::size_t particle) {
  return model.thickness_factor.empty() ? 1 : model.thickness_factor[particle];
}

std::vector<int> first(std::size_t count) {
  std::vector<int> all(count);
  std::iota(all.begin(), all.end(), 0);
  return all;
}

}  // namespace

bool LayoutMap::has_new(const std::vector<int>& objects) const {
  return std::ranges::count(objects, kNew) + (objects.empty() ? 0 : std::ranges::count(particles, kNew)) > 0;
}

bool LayoutMap::has_same_particles(std::size_t count) const { return particles == first(count); }

LayoutMap map_of_particles(const Model& model, std::vector<int> particles) {
  const Kinds kinds(model);
  LayoutMap map;
  map.particles = std::move(particles);
  map.meshes = first(kinds.meshes.size()), map.shapes = first(kinds.shapes.size());
  map.deforming = first(kinds.deforming.size());
  map.edge_groups.assign(kinds.edge_groups.size(), LayoutMap::kNew);
  return map;
}

LayoutMap map_of_scenes(const Model& before, const Model& after, const std::vector<int>& user, double time) {
  const Kinds then(before), now(after);
  const auto same_object = [time](const EnvironmentMesh* a, const EnvironmentMesh* b) {
    return same_contacts(*a, *b, time);
  };
  LayoutMap map;
  map.meshes = indices(now.meshes, then.meshes, same_object),
  map.shapes = indices(now.shapes, then.shapes, same_object);
  map.deforming = indices(now.deforming, then.deforming, same_object);
  map.edge_groups = indices(now.edge_groups, then.edge_groups,
                            [&](const Objects& a, const Objects& b) { return std::ranges::equal(a, b, same_object); });
  const auto &s = before.scene.self_collision, &t = after.scene.self_collision;
  const std::vector<int> number = solver_of(before.user_index);
  bool keeps_thickness = s && t && s->thickness == t->thickness;
  const std::vector<bool> pinned = pinned_now(before, time), stays = pinned_now(after, time);
  for (const int i : after.user_index) {
    const int from = user[static_cast<std::size_t>(i)];
    map.particles.push_back(from == LayoutMap::kNew ? from : number[static_cast<std::size_t>(from)]);
    if (from == LayoutMap::kNew) continue;
    keeps_thickness = keeps_thickness && thickness_factor(after, map.particles.size() - 1) ==
                                             thickness_factor(before, static_cast<std::size_t>(map.particles.back()));
    map.releases = map.releases || (pinned[static_cast<std::size_t>(from)] && !stays[static_cast<std::size_t>(i)]);
  }
  map.keeps_self_distances = keeps_thickness;
  return map;
}

}  // namespace malha
