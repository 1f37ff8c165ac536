// SPDX-License-Identifier: Apache-2.0
// Collider of all environment meshes of a scene, substep by substep: contacts, the guard against tunnelling, and the
// speed up to which steps need neither. It is one of the colliders of host/environment/colliders.h, and made only for
// scenes that have meshes; without one there is no Embree device.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "host/base/point_array.h"
#include "host/environment/environment_contacts.h"
#include "host/measure/solver_stats.h"
#include "kernels/environment/clearance.h"

namespace malha {

template <class Executor, class R>
class MeshCollider {
 public:
  MeshCollider(const Executor& executor, const Model& model)
      : meshes_(executor, model), contacts_(meshes_), particles_(model.x.size()) {
    unresolved_.reserve(static_cast<std::size_t>(meshes_.groups()));
    if (!guards_run_in_turns(model)) return;
    saved_displacements_ = PointArray<Executor, R>(particles_);
    poses_ = Array<Executor, Pose>(meshes_.objects.size()), motion_.reserve(meshes_.objects.size());
  }

  /// Sets the motion of a substep: the meshes move from their poses at `start` to those at `end` (s).
  void set_poses(double start, double end) { meshes_.set_poses(start, end); }
  /// Sets the meshes to rest at their poses at the end of this substep.
  void end_motion() { meshes_.end_motion(); }
  /// Appends the motion of each mesh in this substep.
  void append_motion(std::vector<Pose>& motion) const { meshes_.append_motion(motion); }
  bool moves() const {
    return std::any_of(meshes_.objects.begin(), meshes_.objects.end(),
                       [](const Object& o) { return !o.spec.motion.empty(); });
  }
  int objects() const { return meshes_.count(); }

  /// Detects the contacts of the paths from x to p, with the meshes at their poses of this substep.
  void detect_contacts(const Particles<R>& particles) { contacts_.detect(particles); }
  void solve_contacts(const Particles<R>& particles) { contacts_.solve(particles); }
  /// See EnvironmentContacts.
  void restitute(const Particles<R>& particles, double resting_speed, double h) {
    contacts_.restitute(particles, resting_speed, h);
  }
  void clamp_restitution(const Particles<R>& particles) { contacts_.clamp_restitution(particles); }
  bool bounces() const { return contacts_.bounces(); }
  /// Number of contacts that pushed in the last substep.
  int contacts() const { return contacts_.count_pushing(); }
  /// Invalidates all contacts before substeps without contact detection.
  void invalidate_contacts(const Particles<R>& particles) { contacts_.invalidate(particles); }
  /// Lets particles that are nearer than the thickness now keep their distance until they move away by themselves.
  void keep_overlaps(const Particles<R>& /*particles*/) {
    for (Object& o : meshes_.objects)
      parallel_for(executor(), o.cache.slots(), KeepOverlap{o.cache.view().near, 2 * o.spec.thickness});
  }

  /// Final guard after the last iteration: clamps particles whose path crosses a surface, because constraints moved
  /// them farther than predicted.
  void clamp_tunnelling(const Particles<R>& particles) { clamp(particles, find_crossing_candidates(particles), false); }
  /// Final guard after self-collision: particles that it has moved across a surface move with that mesh instead, from
  /// where the substep began. Without `move_with_meshes` they are clamped in front of it instead. Marks them in `marks`
  /// as owned by their mesh. Returns whether any particle moved.
  bool resolve_crossings(const Particles<R>& particles, const KinematicMarks<R>& marks, bool move_with_meshes) {
    const ActiveCount active = find_crossing_candidates(particles);
    if (active.particles == 0) return false;
    parallel_for(executor(), particles.count,
                 CopyPoints<R, Points<R>, Points<R>>{particles.p.d, saved_displacements_.points()});
    clamp(particles, active, move_with_meshes);
    motion_.clear(), append_motion(motion_), poses_.upload(motion_);
    const MarkMovedParticles<R> mark{particles, saved_displacements_.points(), marks, poses_.data(), meshes_.count()};
    return parallel_reduce<Sum>(executor(), particles.count, mark).value > 0;
  }
  /// Allocates memory for max_contact_free_speed().
  void allocate_clearance() {
    clearance_ = Array<Executor, Clearance>(static_cast<std::size_t>(meshes_.groups()), Clearance{});
  }
  /// Largest speed (m/s) of particles during the next `substeps` of h seconds at which none comes near enough to a mesh
  /// at rest for a contact or a clamp. 0: contacts must be detected. `g`: gravity, m/s^2.
  double max_contact_free_speed(const Particles<R>& particles, double h, int substeps, double g) {
    const auto rounding =
        static_cast<float>(4e-6 + 4e-7 * substeps);  // two roundings for each substep, some ten in the broad phase
    for (int k = 0; k < meshes_.count(); ++k)
      meshes_.for_groups(particles.count > kParticleGrain,
                         MeasureClearance<R>{particles.x, particles.v, particles.w, particles.count, cache(k),
                                             meshes_.contact_range(k), rounding, k == 0, clearance_.data()});
    const MinClearance all =
        parallel_reduce<MinClearance>(executor(), meshes_.groups(), ReduceClearance{clearance_.data()});
    return all.max_contact_free_speed(h, substeps, g);
  }

  /// Largest depth of a particle below a surface (m) at the given time, or when it was forced through one.
  double max_penetration(const Particles<R>& particles, double time) const {
    double deepest = 0;
    for (const Object& o : meshes_.objects) {
      const MeasureDepth<R> kernel{&o.index, o.spec.sides, pose_at(o.spec.motion, time), particles, o.cache.view()};
      deepest = std::max(deepest, parallel_reduce<Deepest>(executor(), particles.count, kernel, kDepthGrain).depth);
    }
    return deepest;
  }

  std::size_t bytes() const {
    std::size_t sum = own_bytes();
    for (const Object& o : meshes_.objects) sum += o.cache.bytes() + o.index.bytes();
    return sum;
  }
  ContactStats facts() const {
    ContactStats facts;
    facts.closest_point_queries = contacts_.queries(), facts.far_bytes = own_bytes();
    for (const Object& o : meshes_.objects) {
      facts.near += o.cache.near();
      facts.far_bytes += o.cache.bytes() - o.cache.near_bytes(), facts.near_bytes += o.cache.near_bytes();
      facts.cell_bytes += o.index.cell_bytes(), facts.full_queries += o.index.queries();
    }
    return facts;
  }

  /// The proximity cache of a mesh, valid until the next detect_contacts or clamp_tunnelling.
  ProximityCacheView<R> cache(int mesh) const { return meshes_.objects[static_cast<std::size_t>(mesh)].cache.view(); }

  /// Number of triangles of each mesh.
  std::vector<int> triangles() const {
    std::vector<int> counts;
    for (const Object& o : meshes_.objects) counts.push_back(o.index.triangles());
    return counts;
  }

  /// Passes on the state that later substeps depend on, for checkpoints, as ProximityMemory does, but mesh by mesh: one
  /// copy of the caches of 1,000 meshes may be as large as everything else.
  template <class F>
  void for_each_part(const F& f) const {
    for (const Object& o : meshes_.objects) f(o.cache.boxes());
    for (const Object& o : meshes_.objects) f(o.cache.entries());
    for (int k = 0; k < meshes_.count(); ++k) f(meshes_.objects[k].cache.pair_records(first_pair(k)));
  }
  std::size_t box_count() const { return meshes_.objects.size() * groups_of(particles_); }
  std::size_t near_count() const {
    std::size_t sum = 0;
    for (const Object& o : meshes_.objects) sum += static_cast<std::size_t>(o.cache.near());
    return sum;
  }
  std::size_t max_entries() const {
    std::size_t sum = 0;
    for (const Object& o : meshes_.objects) sum += o.cache.max_entries();
    return sum;
  }
  void restore_state(const ProximityMemory& all) {
    const GroupBox* box = all.boxes.data();
    const CacheEntry* entry = all.entries.data();
    const PairRecord *near = all.near.data(), *const last = near + all.near.size();
    for (int k = 0; k < meshes_.count(); ++k) {
      ProximityCache<Executor, R>& cache = meshes_.objects[k].cache;
      if (all.boxes.empty()) {
        cache.clear(executor());
        continue;
      }
      const PairRecord* const end =
          std::find_if(near, last, [&](const PairRecord& a) { return a.pair >= first_pair(k + 1); });
      const GroupBox* const next = box + groups_of(particles_);
      cache.restore_state(executor(), {box, next}, entry, near, static_cast<std::size_t>(end - near), first_pair(k));
      entry += count_entries(box, particles_), box = next, near = end;
    }
  }

 private:
  using Object = typename EnvironmentMeshes<Executor, R>::Object;
  static constexpr bool kOnHost = EnvironmentMeshes<Executor, R>::kOnHost;
  static constexpr int kDepthGrain = 64;  // a query of a whole mesh costs about as much as a hundred plain updates

  const Executor& executor() const { return meshes_.executor(); }
  long long first_pair(int mesh) const { return static_cast<long long>(mesh) * static_cast<long long>(particles_); }
  std::size_t own_bytes() const { return meshes_.bytes() + clearance_.bytes() + saved_displacements_.bytes(); }

  /// Sets the mask of particles whose path may cross a surface, and returns how many there are. On a device, which
  /// cannot allocate slots later, all of them get slots at all meshes.
  ActiveCount find_crossing_candidates(const Particles<R>& particles) {
    const ActiveMask active = meshes_.masks(1);
    for (int k = 0; k < meshes_.count(); ++k) meshes_.broad_phase(particles, k, -1, active.bits, k > 0);
    return kOnHost ? meshes_.count_active(active) : meshes_.reserve_slots(0, meshes_.count(), active);
  }
  /// Clamps the `active` particles in the mask. Particles that cannot be clamped are few: on the host they alone get
  /// slots, at all meshes.
  void clamp(const Particles<R>& particles, const ActiveCount& active, bool move_with_meshes) {
    const auto query = [&](const EnvironmentView<R>& all, const ActiveMask& staged, const auto& launch) {
      unresolved_.assign(static_cast<std::size_t>(staged.groups), 0);
      launch(ClampTunnelling<R>{{all}, move_with_meshes, staged.bits, unresolved_.data()});
      if (std::ranges::all_of(unresolved_, [](auto bits) { return bits == 0; })) return;
      if constexpr (kOnHost) meshes_.reserve_slots(0, meshes_.count(), {unresolved_.data(), 1, staged.groups});
      launch(RecordTunnelling<R>{{all}, unresolved_.data()});
    };
    meshes_.query_embree(particles, meshes_.masks(1), active, query);
  }

  EnvironmentMeshes<Executor, R> meshes_;
  EnvironmentContacts<Executor, R> contacts_;
  Array<Executor, Clearance> clearance_;
  PointArray<Executor, R> saved_displacements_;  // displacements before resolve_crossings()
  std::vector<Pose> motion_;                     // of each mesh, in resolve_crossings()
  Array<Executor, Pose> poses_;                  // the same, for kernels
  std::vector<unsigned long long> unresolved_;   // mask of particles that clamp() cannot clamp
  std::size_t particles_;
};

}  // namespace malha
