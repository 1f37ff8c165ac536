// SPDX-License-Identifier: Apache-2.0
// Collider of all environment meshes of a scene: their contacts with the particles, substep by substep. Made only for
// scenes that have an environment; without one there is no Embree device.
#pragma once
#include <algorithm>
#include <cmath>
#include <deque>
#include <vector>

#include "host/attachments/pose.h"
#include "host/base/array.h"
#include "host/base/point_array.h"
#include "host/environment/clamp_tunnelling.h"
#include "host/environment/contact_cache_storage.h"
#include "host/environment/contact_query_device.h"
#include "host/environment/find_contact.h"
#include "host/environment/host_query_staging.h"
#include "host/measure/solver_stats.h"
#include "host/model/model.h"
#include "kernels/environment/clearance.h"

namespace malha {

template <class Executor, class R>
class EnvironmentCollider {
 public:
  EnvironmentCollider(const Executor& executor, const Model& model)
      : executor_(executor),
        staging_(executor),
        particles_(model.x.size()),
        group_count_(static_cast<int>(groups_of(particles_))) {
    for (const EnvironmentMesh& mesh : model.environment) {
      obstacles_.emplace_back(Surface(device_, mesh.mesh), mesh.spec, model.x.size());
      bounces_ = bounces_ || mesh.spec.restitution > 0;
    }
    const std::size_t masks = kOnHost ? 2 : obstacles_.size() + 2;
    if (!kOnHost) counts_ = Array<Executor, BroadPhaseCounts>(obstacles_.size(), BroadPhaseCounts{});
    bits_ = Array<Executor, unsigned long long>(masks * static_cast<std::size_t>(group_count_), 0ull);
  }

  /// Detects the contacts of the paths from x to p, while the meshes move from their poses at `start` to those at `end`
  /// (s). While the host runs the Embree queries, overlap(mask) may launch device work that does not touch the
  /// particles in the mask.
  template <class Overlap>
  void detect_contacts(const Particles<R>& particles, double start, double end,
                       [[maybe_unused]] const Overlap& overlap) {
    set_poses(start, end);
    for (Obstacle& o : obstacles_) invalidate(o, particles, o.spec.motion.empty() ? o.spec.thickness / 2 : -1);
    if constexpr (kOnHost)
      find_on_host(particles);
    else
      find_on_device(particles, overlap);
  }
  void detect_contacts(const Particles<R>& particles, double start, double end) {
    detect_contacts(particles, start, end, [](const ActiveMask&) {});
  }

  void solve_contacts(const Particles<R>& particles) {
    for (Obstacle& o : obstacles_)
      parallel_for(executor_, o.memory.slots(),
                   ResolveContact<R>{particles.p, o.memory.view().contacts, R(o.spec.friction)});
  }

  /// Final guard after the last iteration: clamps particles whose path crosses a surface, because constraints moved
  /// them farther than predicted.
  void clamp_tunnelling(const Particles<R>& particles) {
    clamp_candidates<ClampTunnelling<R>>(find_crossing_candidates(particles), particles);
  }

  /// Final guard after self-collision: particles that it has moved across a surface move with that mesh instead, from
  /// where the substep began. Without `move_with_meshes` they are clamped in front of it instead. Marks them in `marks`
  /// as owned by their mesh. Returns whether any particle moved.
  bool resolve_crossings(const Particles<R>& particles, const KinematicMarks<R>& marks, bool move_with_meshes) {
    const ActiveCount active = find_crossing_candidates(particles);
    if (active.particles == 0) return false;
    if (saved_displacements_.size() == 0)
      saved_displacements_ = PointArray<Executor, R>(static_cast<std::size_t>(particles.count));
    parallel_for(executor_, particles.count,
                 CopyPoints<R, Points<R>, Points<R>>{particles.p.d, saved_displacements_.points()});
    move_with_meshes ? clamp_candidates<MoveWithMeshes<R>>(active, particles)
                     : clamp_candidates<ClampTunnelling<R>>(active, particles);
    std::vector<Pose> motion;
    append_motion(motion);
    const Array<Executor, Pose> poses(motion);
    const MarkMovedParticles<R> mark{particles, saved_displacements_.points(), marks, poses.data(), count()};
    return parallel_reduce<Sum>(executor_, particles.count, mark).value > 0;
  }
  /// Appends the motion of each mesh in this substep.
  void append_motion(std::vector<Pose>& motion) const {
    for (const MovingSurface& mesh : meshes_) motion.push_back(mesh.motion());
  }
  /// Sets the meshes to rest at their poses at the end of this substep.
  void end_motion() {
    for (MovingSurface& mesh : meshes_) mesh.before = mesh.after;
  }

  bool moves() const {
    return std::any_of(obstacles_.begin(), obstacles_.end(), [](const Obstacle& o) { return !o.spec.motion.empty(); });
  }

  /// Allocates memory for max_contact_free_speed().
  void allocate_clearance() {
    clearance_ = Array<Executor, Clearance>(static_cast<std::size_t>(group_count_), Clearance{});
  }
  /// Lets particles that are nearer than the thickness now keep their distance until they move away by themselves.
  void keep_overlaps() {
    for (Obstacle& o : obstacles_)
      parallel_for(executor_, o.memory.slots(), KeepOverlap{o.memory.view().near, 2 * o.spec.thickness});
  }

  /// Largest speed (m/s) of particles during the next `substeps` of h seconds at which none comes near enough to a mesh
  /// at rest for a contact or a clamp. 0: contacts must be detected. `g`: gravity, m/s^2.
  double max_contact_free_speed(const Particles<R>& particles, double h, int substeps, double g) {
    const auto rounding =
        static_cast<float>(4e-6 + 4e-7 * substeps);  // two roundings for each substep, some ten in the broad phase
    for (int k = 0; k < count(); ++k) {
      const ContactCacheView<R> cache = obstacles_[k].memory.view();
      for_groups(particles.count > kParticleGrain,
                 MeasureClearance<R>{particles.x, particles.v, particles.w, particles.count, cache,
                                     static_cast<float>(2 * obstacles_[k].spec.thickness), rounding, k == 0,
                                     clearance_.data()});
    }
    const MinClearance all = parallel_reduce<MinClearance>(executor_, group_count_, ReduceClearance{clearance_.data()});
    const double speed = (all.distance - g * h * h) / ((substeps + 1) * h);
    return std::sqrt(all.speed2) + g * h * substeps < speed ? speed : 0;
  }

  /// Invalidates all contacts before substeps without contact detection.
  void invalidate_contacts(const Particles<R>& particles) {
    for (Obstacle& o : obstacles_) invalidate(o, particles, -1);
  }

  /// Clamps particles after a substep of h seconds without contact detection in which some exceeded the speed limit;
  /// the state is that after the substep.
  void clamp_tunnelling_late(const Particles<R>& particles, double start, double h) {
    const PointArray<Executor, R> before(static_cast<std::size_t>(particles.count));
    Particles<R> then = particles;
    then.x = then.p.x = before.points();
    parallel_for(executor_, particles.count, ReconstructPrevious<R>{particles, then.x, R(h)});
    set_poses(start, start + h);
    clamp_tunnelling(then);
    parallel_for(executor_, particles.count, CommitClamped<R>{particles, R(1 / h)});
  }

  /// Applies restitution. `resting_speed`: the speed that gravity gives in two substeps, below which nothing bounces
  /// (m/s).
  void restitute(const Particles<R>& particles, double resting_speed, double h) {
    for (Obstacle& o : obstacles_)
      parallel_for(executor_, o.memory.slots(),
                   ApplyRestitution<R>{particles.p, particles.v, o.memory.view().contacts, R(o.spec.restitution),
                                       R(o.spec.friction), R(resting_speed), R(1 / h)});
    if (!bounces_) return;
    parallel_for(executor_, group_count_, FindRestituted<R>{particles, bits(0)});
    run_on_mask<ClampRestitution<R>>(count_active(0), particles);
  }

  /// Returns true if restitute() may move particles.
  bool bounces() const { return bounces_; }

  /// Number of contacts that pushed in the last substep.
  int contacts() const {
    double sum = 0;
    for (const Obstacle& o : obstacles_)
      sum += parallel_reduce<Sum>(executor_, o.memory.slots(), CountContact<R>{o.memory.view().contacts}).value;
    return static_cast<int>(sum);
  }

  /// Largest depth of a particle below a surface (m) at the given time, or when it was forced through one.
  double max_penetration(const Particles<R>& particles, double time) const {
    double deepest = 0;
    for (const Obstacle& o : obstacles_) {
      const MeasureDepth<R> kernel{&o.surface, o.spec.sides, pose_at(o.spec.motion, time), particles, o.memory.view()};
      deepest = std::max(deepest, parallel_reduce<Deepest>(executor_, particles.count, kernel, kGrain).depth);
    }
    return deepest;
  }

  std::size_t bytes() const {
    std::size_t sum = bits_.bytes() + clearance_.bytes() + staging_.bytes() + saved_displacements_.bytes();
    for (const Obstacle& o : obstacles_) sum += o.memory.bytes() + o.surface.bytes();
    return sum;
  }

  ContactStats facts() const {
    ContactStats facts = facts_;
    facts.far_bytes = bits_.bytes() + clearance_.bytes() + staging_.bytes() + saved_displacements_.bytes();
    for (const Obstacle& o : obstacles_) {
      facts.near += o.memory.near();
      facts.far_bytes += o.memory.bytes() - o.memory.near_bytes(), facts.near_bytes += o.memory.near_bytes();
      facts.cell_bytes += o.surface.cell_bytes(), facts.full_queries += o.surface.queries();
    }
    return facts;
  }

  /// The contact cache of a mesh, valid until the next detect_contacts or clamp_tunnelling.
  ContactCacheView<R> cache(int mesh) const { return obstacles_[static_cast<std::size_t>(mesh)].memory.view(); }

  /// Number of triangles of each mesh.
  std::vector<int> triangles() const {
    std::vector<int> counts;
    for (const Obstacle& o : obstacles_) counts.push_back(o.surface.triangles());
    return counts;
  }

  /// Passes on the state that later substeps depend on, for checkpoints, as ContactMemory does, but mesh by mesh: one
  /// copy of the caches of 1,000 meshes may be as large as everything else.
  template <class F>
  void for_each_part(const F& f) const {
    for (const Obstacle& o : obstacles_) f(o.memory.boxes());
    for (const Obstacle& o : obstacles_) f(o.memory.entries());
    for (std::size_t k = 0; k < obstacles_.size(); ++k) f(obstacles_[k].memory.pair_records(first_pair(k)));
  }
  std::size_t box_count() const { return obstacles_.size() * groups_of(particles_); }
  std::size_t near_count() const {
    std::size_t sum = 0;
    for (const Obstacle& o : obstacles_) sum += static_cast<std::size_t>(o.memory.near());
    return sum;
  }
  std::size_t max_entries() const {
    std::size_t sum = 0;
    for (const Obstacle& o : obstacles_) sum += o.memory.max_entries();
    return sum;
  }
  void restore_state(const ContactMemory& all) {
    const std::size_t for_groups = groups_of(particles_);
    const CacheEntry* entry = all.entries.data();
    const PairRecord *from = all.near.data(), *const last = from + all.near.size();
    for (std::size_t k = 0; k < obstacles_.size(); ++k) {
      const PairRecord* const end =
          std::find_if(from, last, [&](const auto& a) { return a.pair >= first_pair(k + 1); });
      ContactCacheStorage<Executor, R>& memory = obstacles_[k].memory;
      if (all.boxes.empty()) {
        memory.clear(executor_);
      } else {
        const GroupBox* const first = all.boxes.data() + k * for_groups;
        memory.restore_state(executor_, {first, first + for_groups}, entry, from, static_cast<std::size_t>(end - from),
                             first_pair(k));
        entry += count_entries(first, particles_);
      }
      from = end;
    }
  }

 private:
  static constexpr bool kOnHost = Memory<Executor>::kOnHost;
  static constexpr int kGrain = 64;          // a query of a whole mesh costs about as much as a hundred plain updates
  static constexpr int kThreadGrain = 1024;  // fewer queries are faster without a second thread if cores are shared
  struct Obstacle {
    Obstacle(Surface s, const EnvironmentSpec& e, std::size_t particles)
        : surface(std::move(s)), spec(e), memory(particles) {}
    Surface surface;
    EnvironmentSpec spec;
    ContactCacheStorage<Executor, R> memory;
  };

  int count() const { return static_cast<int>(obstacles_.size()); }
  long long first_pair(std::size_t mesh) const { return static_cast<long long>(mesh * particles_); }

  /// `max_path`: see InvalidateContacts. Paths of at most half the thickness never need a sweep (needs_sweep()),
  /// whatever the distance from the mesh, so that a contact with such a path may be reused.
  void invalidate(Obstacle& o, const Particles<R>& particles, double max_path) {
    parallel_for(executor_, o.memory.slots(), InvalidateContacts<R>{o.memory.view().contacts, particles.p, max_path});
  }

  void set_poses(double start, double end) {
    meshes_.clear(), caches_.clear();
    for (Obstacle& o : obstacles_) {
      meshes_.push_back(
          {&o.surface, o.spec.sides, o.spec.thickness, pose_at(o.spec.motion, start), pose_at(o.spec.motion, end)});
      o.surface.reset_if_full();
      caches_.push_back(o.memory.view());
    }
  }
  EnvironmentView<R> environment_view(const Particles<R>& particles) {
    return {meshes_.data(), count(), particles, caches_.data()};
  }

  void find_on_host(const Particles<R>& particles) {
    for (int k = 0; k < count(); ++k) {
      broad_phase(particles, k, contact_range(k), bits(0), false);
      const int queries = reserve_slots(k, k + 1, {bits(0), 1, group_count_}).particles;
      facts_.closest_point_queries += queries;
      for_groups_interleaved(queries, FindContact<R>{environment_view(particles), k, bits(0)});
    }
  }
  /// Queries all meshes in one pass. Depenetration on the device is limited to particles near a single mesh, and to
  /// less than their distance from the others.
  template <class Overlap>
  void find_on_device(const Particles<R>& particles, const Overlap& overlap) {
    for (int k = 0; k < count(); ++k) broad_phase(particles, k, contact_range(k), bits(k), false);
    const int queries = reserve_slots(0, count(), {bits(0), count(), group_count_}).particles;
    facts_.closest_point_queries += queries;
    if (queries == 0) return;
    const EnvironmentView<R> view = environment_view(particles);
    const ActiveMask active{bits(0), count(), group_count_};
    unsigned long long *const single_mesh = bits(count()), *const lifted = bits(count() + 1);
    parallel_for(executor_, group_count_, FindSingleMeshParticles{active, single_mesh, lifted});
    for (int k = 0; k < count(); ++k) {
      double max_lift = INFINITY;
      for (int other = 0; other < count(); ++other)
        if (other != k) max_lift = std::min(max_lift, double(contact_range(other)));
      const QueryMasks masks_of_mesh{bits(k), k > 0 ? bits(k - 1) : nullptr, single_mesh, lifted};
      parallel_for(executor_, group_count_, AllocateEntries<R>(query_for(view, k), masks_of_mesh));
      parallel_for(executor_, particles.count, QueryOctree<R>(query_for(view, k), masks_of_mesh, max_lift));
    }
    const ActiveCount left = parallel_reduce<ActiveCount>(executor_, group_count_, CountActive{active});
    if (left.particles == 0) return;
    const auto query = [&](const auto& all, const auto& buffer) {
      for (int k = 0; k < count(); ++k)
        parallel_for_interleaved(executor_, buffer.groups, FindContact<R>{all, k, buffer.bits(k)});
    };
    staging_.run(view, active, left, query, overlap);
  }

  /// Sets the bits of particles whose path may cross a surface, and returns how many there are. On a device, which
  /// cannot allocate slots later, all of them get slots at all meshes.
  ActiveCount find_crossing_candidates(const Particles<R>& particles) {
    for (int k = 0; k < count(); ++k) broad_phase(particles, k, -1, bits(0), k > 0);
    if constexpr (kOnHost)
      return count_active(0);
    else
      return reserve_slots(0, count(), {bits(0), 1, group_count_});
  }
  ActiveCount count_active(int mask) {
    return parallel_reduce<ActiveCount>(executor_, group_count_, CountActive{{bits(mask), 1, group_count_}});
  }

  /// Distance (m) beyond its path at which a particle may get a contact with mesh k; ContactQuery has the same.
  float contact_range(int k) const { return static_cast<float>(2 * meshes_[k].thickness); }
  unsigned long long* bits(int mask) const { return bits_.data() + mask * group_count_; }

  /// Broad phase of mesh k (see BroadPhaseTest).
  void broad_phase(const Particles<R>& particles, int k, float contact_range, unsigned long long* bits, bool add) {
    const MovingSurface& mesh = meshes_[k];
    const ContactCacheStorage<Executor, R>& memory = obstacles_[k].memory;
    const SurfaceView& surface = mesh.surface->view();
    const FloatBox box{rounded<float>(surface.centre), rounded<float>(surface.half)};
    for_groups(particles.count > kParticleGrain || memory.slots() > kThreadGrain,
               BroadPhaseTest<R>{particles, memory.view(), FloatPose(mesh.before), FloatPose(mesh.after), box,
                                 contact_range, add, bits});
  }
  /// Reserves contact slots at meshes first .. last - 1 for all particles that passed the broad phase. With one mask it
  /// holds for all meshes. With a mask for each mesh, mesh k has slots for the particles in masks 0 to k, because a
  /// particle that an earlier mesh moves is queried at the later ones too. Returns how many particles and groups
  /// passed.
  ActiveCount reserve_slots(int first, int last, const ActiveMask& masks) {
    const auto counting = [&](int k) {
      return CountBroadPhase<R>{{masks.bits, std::min(k + 1, masks.count), group_count_}, obstacles_[k].memory.view()};
    };
    std::vector<BroadPhaseCounts> counts;
    if constexpr (kOnHost) {
      for (int k = first; k < last; ++k)
        counts.push_back(parallel_reduce<BroadPhaseCounts>(executor_, group_count_, counting(k)));
    } else {
      for (int k = first; k < last; ++k) parallel_reduce_into(executor_, group_count_, counting(k), counts_.data() + k);
      counts = counts_.download();
    }
    ActiveCount active;
    for (int k = first; k < last; ++k) {
      const BroadPhaseCounts& at = counts[k - first];
      obstacles_[k].memory.reserve_slots(executor_, at.without_slot, at.slots, at.without_entries, at.entries);
      caches_[k] = obstacles_[k].memory.view();
      active = {at.groups, masks.count > 1 ? active.particles + at.particles : at.particles};
    }
    return active;
  }

  /// Runs a kernel on all groups of particles.
  template <class Kernel>
  void for_groups(bool parallel, const Kernel& kernel) {
    if (!parallel) return parallel_groups(single_threaded(executor_), 0, group_count_, {}, kernel);
    parallel_region(executor_, group_count_,
                    [&](const auto& team) { parallel_groups(team, 0, group_count_, {}, kernel); });
  }
  /// Runs a kernel on all groups, interleaved over threads: a group may have many queries or none.
  template <class Kernel>
  void for_groups_interleaved(int queries, const Kernel& kernel) {
    if (queries <= kThreadGrain) return parallel_for_interleaved(single_threaded(executor_), group_count_, kernel);
    parallel_region(executor_, group_count_,
                    [&](const auto& team) { parallel_for_interleaved(team, group_count_, kernel); });
  }

  /// Runs a clamping kernel on the `active` particles of the first mask. Particles that it cannot clamp are few: on the
  /// host they alone get slots, at all meshes.
  template <class Kernel>
  void clamp_candidates(const ActiveCount& active, const Particles<R>& particles) {
    if constexpr (kOnHost) {
      for_groups_interleaved(active.particles, Kernel{environment_view(particles), bits(0), bits(1)});
      const ActiveCount unresolved = active.particles > 0 ? count_active(1) : ActiveCount{};
      if (unresolved.particles == 0) return;
      reserve_slots(0, count(), {bits(1), 1, group_count_});
      for_groups_interleaved(unresolved.particles, RecordTunnelling<R>{environment_view(particles), bits(1), nullptr});
    } else if (active.particles > 0) {
      Memory<Executor>::fill(bits(1), static_cast<std::size_t>(group_count_), 0ull);
      const auto query = [&](const auto& all, const auto& buffer) {
        parallel_for_interleaved(executor_, buffer.groups, Kernel{all, buffer.bits(0), buffer.bits(1)});
        const unsigned long long* const unresolved = buffer.bits(1);
        if (std::any_of(unresolved, unresolved + buffer.groups, [](auto mask) { return mask != 0; }))
          parallel_for_interleaved(executor_, buffer.groups, RecordTunnelling<R>{all, unresolved, nullptr});
      };
      staging_.run(environment_view(particles), {bits(0), 2, group_count_}, active, query, [](const ActiveMask&) {});
    }
  }

  /// Launches an Embree kernel on the particles set in the mask.
  template <class Kernel>
  void run_on_mask(const ActiveCount& active, const Particles<R>& particles) {
    const EnvironmentView<R> view = environment_view(particles);
    if constexpr (kOnHost)
      for_groups_interleaved(active.particles, Kernel{view, bits(0)});
    else if (active.particles > 0)
      staging_.run(
          view, {bits(0), 1, group_count_}, active,
          [&](const auto& all, const auto& buffer) {
            parallel_for_interleaved(executor_, buffer.groups, Kernel{all, buffer.bits(0)});
          },
          [](const ActiveMask&) {});
  }

  Executor executor_;
  HostQueryStaging<Executor, R> staging_;
  Array<Executor, BroadPhaseCounts> counts_;  // of each mesh, on a device
  Device device_;
  std::deque<Obstacle> obstacles_;
  std::vector<MovingSurface> meshes_;         // of the present substep
  std::vector<ContactCacheView<R>> caches_;   // of each mesh
  Array<Executor, unsigned long long> bits_;  // masks of particles; on a device one for each mesh, and two more
  Array<Executor, Clearance> clearance_;
  PointArray<Executor, R> saved_displacements_;  // displacements before resolve_crossings()
  ContactStats facts_;
  std::size_t particles_;
  int group_count_;
  bool bounces_ = false;
};

}  // namespace malha
