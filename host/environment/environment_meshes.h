// SPDX-License-Identifier: Apache-2.0
// The meshes of the environment with what every query of a substep needs: their poses, what is known of the particles
// near them, the broad phase, and a way to Embree from any executor.
#pragma once
#include <algorithm>
#include <deque>
#include <vector>

#include "host/attachments/object_motion.h"
#include "host/base/array.h"
#include "host/environment/host_query_staging.h"
#include "host/environment/proximity_cache.h"
#include "host/model/model.h"

namespace malha {

template <class Executor, class R>
class EnvironmentMeshes {
 public:
  static constexpr bool kOnHost = Memory<Executor>::kOnHost;
  struct Object {
    Object(const Device& device, const EnvironmentMesh& mesh, std::size_t particles)
        : index(device, mesh.mesh), spec(mesh.spec), cache(particles) {}
    ClosestPointIndex index;
    const EnvironmentSpec& spec;  // of the model, whose motion the program may change
    ProximityCache<Executor, R> cache;
  };
  std::deque<Object> objects;

  EnvironmentMeshes(const Executor& executor, const Model& model)
      : executor_(executor), staging_(executor), group_count_(static_cast<int>(groups_of(model.x.size()))) {
    for (const EnvironmentMesh& mesh : model.environment)
      if (is_rigid_mesh(mesh)) objects.emplace_back(device_, mesh, model.x.size());
    const std::size_t masks = kOnHost ? 1 : objects.size();
    bits_ = Array<Executor, unsigned long long>(masks * static_cast<std::size_t>(group_count_), 0ull);
    meshes_.reserve(objects.size()), caches_.reserve(objects.size()), counted_.reserve(objects.size());
    if (kOnHost) return;
    counts_ = Array<Executor, BroadPhaseCounts>(objects.size());
    queries_ = Array<Executor, ContactQuery<R>>(objects.size());
  }

  int count() const { return static_cast<int>(objects.size()); }
  int groups() const { return group_count_; }
  const Executor& executor() const { return executor_; }

  /// Sets the poses of the meshes for a substep.
  void set_poses(double start, double end) {
    meshes_.clear(), caches_.clear();
    for (Object& o : objects) {
      o.index.reset_if_full();
      meshes_.push_back({&o.index, o.index.view(), o.spec.sides, o.spec.thickness, pose_at(o.spec.motion, start),
                         pose_at(o.spec.motion, end)});
      caches_.push_back(o.cache.view());
    }
  }
  /// Sets the meshes to rest at their poses at the end of this substep.
  void end_motion() {
    for (MovingMesh& mesh : meshes_) mesh.before = mesh.after;
  }
  /// Appends the motion of each mesh in this substep.
  void append_motion(std::vector<Pose>& motion) const {
    for (const MovingMesh& mesh : meshes_) motion.push_back(mesh.motion());
  }
  EnvironmentView<R> view(const Particles<R>& particles) const {
    return {meshes_.data(), count(), particles, caches_.data()};
  }

  /// The contact queries of all meshes, in a device's memory.
  const ContactQuery<R>* queries_on_device(const Particles<R>& particles) {
    std::vector<ContactQuery<R>> queries;
    for (int k = 0; k < count(); ++k) queries.push_back(view(particles).query(k));
    queries_.upload(queries);
    return queries_.data();
  }

  /// Masks of particles, from the first on: on a device there is one for each mesh.
  ActiveMask masks(int count) const { return {bits_.data(), count, group_count_}; }
  ActiveCount count_active(const ActiveMask& masks) const {
    return parallel_reduce<ActiveCount>(executor_, group_count_, CountActive{masks});
  }

  /// Distance (m) beyond its path at which a particle may get a contact with mesh k; ContactQuery has the same.
  float contact_range(int k) const { return static_cast<float>(2 * objects[k].spec.thickness); }

  /// Broad phase of mesh k (see BroadPhaseTest).
  void broad_phase(const Particles<R>& particles, int k, float contact_range, unsigned long long* bits, bool add) {
    const MovingMesh& mesh = meshes_[k];
    const ProximityCache<Executor, R>& cache = objects[k].cache;
    const FloatBox box{rounded<float>(mesh.surface.centre), rounded<float>(mesh.surface.half)};
    for_groups(particles.count > kParticleGrain || cache.slots() > kThreadGrain,
               BroadPhaseTest<R>{particles, cache.view(), FloatPose(mesh.before), FloatPose(mesh.after), box,
                                 contact_range, add, bits});
  }

  /// Reserves contact slots at meshes first .. last - 1 for all particles that passed the broad phase. With one mask it
  /// holds for all meshes. With a mask for each mesh, mesh k has slots for the particles in masks 0 to k, because a
  /// particle that an earlier mesh moves is queried at the later ones too. Returns how many particles and groups
  /// passed.
  ActiveCount reserve_slots(int first, int last, const ActiveMask& masks) {
    const auto counting = [&](int k) {
      return CountBroadPhase<R>{{masks.bits, std::min(k + 1, masks.count), group_count_}, objects[k].cache.view()};
    };
    counted_.clear();
    if constexpr (kOnHost) {
      for (int k = first; k < last; ++k)
        counted_.push_back(parallel_reduce<BroadPhaseCounts>(executor_, group_count_, counting(k)));
    } else {
      for (int k = first; k < last; ++k) parallel_reduce_into(executor_, group_count_, counting(k), counts_.data() + k);
      counted_ = counts_.download();
    }
    ActiveCount active;
    for (int k = first; k < last; ++k) {
      const BroadPhaseCounts& at = counted_[k - first];
      objects[k].cache.reserve_slots(executor_, at.without_slot, at.slots, at.without_entries, at.entries);
      caches_[k] = objects[k].cache.view();
      active = {at.groups, masks.count > 1 ? active.particles + at.particles : at.particles};
    }
    return active;
  }

  /// Runs query(environment, masks, launch) on the `active` particles of the masks, in memory that the host reads:
  /// launch(kernel) runs a kernel that queries Embree on all their groups.
  template <class Query>
  void query_embree(const Particles<R>& particles, const ActiveMask& masks, const ActiveCount& active,
                    const Query& query) {
    if constexpr (kOnHost) {
      query(view(particles), masks, [&](const auto& kernel) { for_groups_interleaved(active.particles, kernel); });
    } else if (active.particles > 0) {
      const auto on_host = [&](const EnvironmentView<R>& all, const ActiveMask& staged) {
        query(all, staged, [&](const auto& kernel) { parallel_for_interleaved(executor_, staged.groups, kernel); });
      };
      staging_.run(view(particles), masks, active, on_host);
    }
  }

  /// Runs a kernel on all groups of particles.
  template <class Kernel>
  void for_groups(bool parallel, const Kernel& kernel) {
    if (!parallel) return parallel_groups(single_threaded(executor_), 0, group_count_, {}, kernel);
    parallel_region(executor_, group_count_,
                    [&](const auto& team) { parallel_groups(team, 0, group_count_, {}, kernel); });
  }

  std::size_t bytes() const { return bits_.bytes() + staging_.bytes(); }

 private:
  static constexpr int kThreadGrain = 1024;  // fewer queries are faster without a second thread if cores are shared

  /// Runs a kernel on all groups, interleaved over threads: a group may have many queries or none.
  template <class Kernel>
  void for_groups_interleaved(int queries, const Kernel& kernel) {
    if (queries <= kThreadGrain) return parallel_for_interleaved(single_threaded(executor_), group_count_, kernel);
    parallel_region(executor_, group_count_,
                    [&](const auto& team) { parallel_for_interleaved(team, group_count_, kernel); });
  }

  Executor executor_;
  Device device_;
  HostQueryStaging<Executor, R> staging_;
  std::vector<MovingMesh> meshes_;             // of the present substep
  std::vector<ProximityCacheView<R>> caches_;  // of each mesh
  std::vector<BroadPhaseCounts> counted_;      // of the meshes for which slots are reserved
  Array<Executor, unsigned long long> bits_;
  Array<Executor, BroadPhaseCounts> counts_;  // of each mesh, on a device
  Array<Executor, ContactQuery<R>> queries_;  // likewise
  int group_count_;
};

}  // namespace malha
