// SPDX-License-Identifier: Apache-2.0
// Contacts of particles with the meshes of the environment in a substep: detection, projection and restitution. Planes
// and impulses lie in the slots of the proximity caches, beside what they were computed from.
#pragma once
#include <algorithm>
#include <cmath>

#include "host/environment/clamp_tunnelling.h"
#include "host/environment/contact_query_device.h"
#include "host/environment/environment_meshes.h"

namespace malha {

template <class Executor, class R>
class EnvironmentContacts {
 public:
  explicit EnvironmentContacts(EnvironmentMeshes<Executor, R>& meshes)
      : meshes_(meshes), bounces_(std::any_of(meshes.objects.begin(), meshes.objects.end(), [](const Object& o) {
          return o.spec.restitution > 0;
        })) {}

  /// Detects the contacts of the paths from x to p, with the meshes at their poses of this substep.
  void detect(const Particles<R>& particles) {
    // Paths of at most half the thickness never need a sweep, whatever the distance from the mesh (needs_sweep()).
    for (Object& o : meshes_.objects) invalidate(o, particles, o.spec.motion.empty() ? o.spec.thickness / 2 : -1);
    if constexpr (EnvironmentMeshes<Executor, R>::kOnHost)
      detect_one_by_one(particles);
    else
      detect_together(particles);
  }

  void solve(const Particles<R>& particles) {
    particles.by_friction([&]<bool mapped>() {
      for (Object& o : meshes_.objects)
        for_slots(
            o, ResolveContact<R, mapped>{particles.p, o.cache.view().contacts, R(o.spec.friction), particles.friction});
    });
  }

  /// Applies restitution. `resting_speed`: the speed that gravity gives in two substeps, below which nothing bounces
  /// (m/s).
  void restitute(const Particles<R>& particles, double resting_speed, double h) {
    particles.by_friction([&]<bool mapped>() {
      for (Object& o : meshes_.objects)
        for_slots(o,
                  ApplyRestitution<R, mapped>{particles.p, particles.v, o.cache.view().contacts, R(o.spec.restitution),
                                              R(o.spec.friction), R(resting_speed), R(1 / h), particles.friction});
    });
  }
  /// Cancels motion of restitution through a mesh.
  void clamp_restitution(const Particles<R>& particles) {
    const ActiveMask moved = meshes_.masks(1);
    parallel_for(meshes_.executor(), moved.groups, FindRestituted<R>{particles, moved.bits});
    meshes_.query_embree(particles, moved, meshes_.count_active(moved),
                         [](const EnvironmentView<R>& all, const ActiveMask& active, const auto& launch) {
                           launch(ClampRestitution<R>{all, active.bits});
                         });
  }
  /// Returns true if restitute() may move particles.
  bool bounces() const { return bounces_; }

  /// Invalidates all contacts.
  void invalidate(const Particles<R>& particles) {
    for (Object& o : meshes_.objects) invalidate(o, particles, -1);
  }

  /// Number of contacts that pushed in the last substep.
  int count_pushing() const {
    double sum = 0;
    for (const Object& o : meshes_.objects)
      sum += parallel_reduce<Sum>(meshes_.executor(), o.cache.slots(), CountContact<R>{o.cache.view().contacts}).value;
    return static_cast<int>(sum);
  }

  /// Number of closest-point queries since the start.
  long long queries() const { return queries_; }

 private:
  using Object = typename EnvironmentMeshes<Executor, R>::Object;

  template <class Kernel>
  void for_slots(const Object& o, const Kernel& kernel) {
    parallel_for(meshes_.executor(), o.cache.slots(), kernel);
  }
  /// `max_path`: see InvalidateContacts.
  void invalidate(Object& o, const Particles<R>& particles, double max_path) {
    for_slots(o, InvalidateContacts<R>{o.cache.view().contacts, particles.p, max_path});
  }

  /// Queries the meshes one after the other, each with a broad phase of its own: an earlier mesh may have moved
  /// particles.
  void detect_one_by_one(const Particles<R>& particles) {
    const ActiveMask active = meshes_.masks(1);
    for (int k = 0; k < meshes_.count(); ++k) {
      meshes_.broad_phase(particles, k, meshes_.contact_range(k), active.bits, false);
      const ActiveCount count = meshes_.reserve_slots(k, k + 1, active);
      queries_ += count.particles;
      meshes_.query_embree(particles, active, count,
                           [k](const EnvironmentView<R>& all, const ActiveMask& staged, const auto& launch) {
                             launch(FindContact<R>(all, k, staged.bits));
                           });
    }
  }
  /// Queries all meshes with one transfer of what a device leaves to the host.
  void detect_together(const Particles<R>& particles) {
    const int count = meshes_.count();
    const ActiveMask active = meshes_.masks(count);
    double max_lift = INFINITY;
    for (int k = 0; k < count; ++k) {
      meshes_.broad_phase(particles, k, meshes_.contact_range(k), active.mask(k), false);
      max_lift = std::min(max_lift, double(meshes_.contact_range(k)));
    }
    const int queries = meshes_.reserve_slots(0, count, active).particles;
    queries_ += queries;
    if (queries == 0) return;
    const ContactQuery<R>* const on_device = meshes_.queries_on_device(particles);
    parallel_for(meshes_.executor(), active.groups, AllocateEntries<R>{on_device, active});
    parallel_for(meshes_.executor(), particles.count, QueryOctrees<R>{on_device, active, max_lift});
    meshes_.query_embree(particles, active, meshes_.count_active(active),
                         [&](const EnvironmentView<R>& staged, const ActiveMask& left, const auto& launch) {
                           for (int k = 0; k < count; ++k) launch(FindContact<R>(staged, k, left.mask(k)));
                         });
  }

  EnvironmentMeshes<Executor, R>& meshes_;
  bool bounces_;
  long long queries_ = 0;
};

}  // namespace malha
