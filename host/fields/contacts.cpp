// SPDX-License-Identifier: Apache-2.0
#include "host/fields/contacts.h"

#include <cmath>

#include "host/attachments/object_motion.h"
#include "host/base/parallel_tasks.h"

namespace malha {

namespace {

constexpr int kChunk = 256;  // particles; a query takes about a microsecond

/// Returns the contact of a particle at `a` (in the object's frame), or none.
std::optional<ContactPoint> touch(const ClosestPointIndex& surface, Sides sides, const Point& a, double thickness,
                                  double reach) {
  if (surface.box_distance(a) > reach) return std::nullopt;
  const ClosestPoint near = surface.closest(a, reach);
  if (!near.found) return std::nullopt;
  const Point away = a - near.q;
  // At a two-sided surface a particle counts as being on the side where it is now.
  const bool behind = dot(near.normal, away) < 0;
  if (behind && sides == Sides::OneSided && near.boundary)
    return std::nullopt;  // it is beyond the boundary of the mesh, not behind the surface
  Point normal = near.normal;
  // At an edge or a corner the contact normal points from the closest point to the particle. On the surface itself only
  // the surface normal is defined.
  if (near.distance > 1e-3 * thickness)
    normal = away * ((behind && sides != Sides::TwoSided ? -1 : 1) / near.distance);
  else if (behind && sides == Sides::TwoSided)
    normal = -normal;
  const double distance = behind && sides != Sides::TwoSided ? -near.distance : near.distance;
  return ContactPoint{-1, -1, {near.q.x, near.q.y, near.q.z}, {normal.x, normal.y, normal.z}, distance};
}

/// The same for an exact shape.
std::optional<ContactPoint> touch(const PlacedShape& placed, const Point& a, double reach) {
  const Point own = to_local(placed.pose, a);
  const SurfaceDistance<double> near = distance_to(placed.shape, own);
  if (std::abs(near.distance) > reach) return std::nullopt;
  const Point q = to_world(placed.pose, own - near.normal * near.distance), n = rotate(placed.pose, near.normal);
  return ContactPoint{-1, -1, {q.x, q.y, q.z}, {n.x, n.y, n.z}, near.distance};
}

}  // namespace

Contacts::Contacts(const Model& model, int threads) : threads_(threads) {
  if (shape_count(model) < model.environment.size()) device_.emplace();
  for (const EnvironmentMesh& object : model.environment) {
    std::optional<ClosestPointIndex>& surface = surfaces_.emplace_back();
    if (is_rigid_mesh(object)) surface.emplace(*device_, object.mesh);
  }
}

std::vector<ContactPoint> Contacts::operator()(const std::vector<Vec3>& x,
                                               const std::vector<EnvironmentMesh>& environment, double time,
                                               double slack) const {
  std::vector<ContactPoint> all;
  const int chunks = static_cast<int>((x.size() + kChunk - 1) / kChunk);
  std::vector<std::vector<ContactPoint>> found(chunks);
  for (std::size_t o = 0; o < environment.size(); ++o) {
    const EnvironmentMesh& object = environment[o];
    std::optional<ClosestPointIndex> deformed;  // in the world
    if (deforms(object)) deformed.emplace(*device_, mesh_at(object, time));
    const ClosestPointIndex* const surface = deformed ? &*deformed : surfaces_[o] ? &*surfaces_[o] : nullptr;
    const Pose pose = deformed ? Pose{} : pose_at(object.spec.motion, time);
    const double thickness = object.spec.thickness, reach = (1 + slack) * thickness;
    const auto look = [&](int chunk) {
      const std::size_t begin = std::size_t(chunk) * kChunk, end = std::min(x.size(), begin + kChunk);
      found[chunk].clear();
      for (std::size_t i = begin; i < end; ++i) {
        const Point a = to_local(pose, Point{x[i][0], x[i][1], x[i][2]});
        std::optional<ContactPoint> one =
            object.exact ? touch(*object.exact, a, reach) : touch(*surface, object.spec.sides, a, thickness, reach);
        if (!one) continue;
        const Point at = to_world(pose, Point{one->at[0], one->at[1], one->at[2]});
        const Point normal = rotate(pose, Point{one->normal[0], one->normal[1], one->normal[2]});
        one->particle = static_cast<int>(i), one->object = static_cast<int>(o);
        one->at = {at.x, at.y, at.z}, one->normal = {normal.x, normal.y, normal.z};
        found[chunk].push_back(*one);
      }
    };
    parallel_tasks(OpenMP{threads_}, chunks, look);
    for (const auto& some : found) all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

}  // namespace malha
