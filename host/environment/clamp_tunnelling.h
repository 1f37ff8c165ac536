// SPDX-License-Identifier: Apache-2.0
// Final guard of a substep against tunnelling: no particle passes through a mesh of the environment. A particle that
// neighbours or other meshes dragged through one, where its predicted path needed no contact, is clamped in front of
// it.
#pragma once
#include "host/environment/find_contact.h"
#include "kernels/environment/edge_detection.h"

namespace malha {

/// Displacement of a point x by a rigid motion of the substep.
template <class R>
KERNEL Vector3<R> rigid_displacement(const Pose& motion, const Vector3<R>& x) {
  return rounded<R>(to_world(motion, in_double(x)) - in_double(x));
}

/// Calls work(i) for the particles of a group that are set in the mask.
template <class Work>
HOST_KERNEL void for_each_in_group(const unsigned long long* bits, int g, const Work& work) {
  for (unsigned long long rest = bits[g]; rest != 0; rest &= rest - 1) work(g * kGroupSize + lowest_bit(rest));
}

/// Paths of particles in the substep, and where they cross the meshes.
template <class R>
struct PathsAcrossMeshes : EnvironmentView<R> {
  Point x(int i) const { return in_double(this->particles.x[i]); }
  Point p(int i) const { return this->particles.p.position_without_low(i); }

  Crossing crossing_of(int i, int k) const {
    const MovingMesh& mesh = this->meshes[k];
    const Point a = to_local(mesh.before, x(i));
    if (this->caches[k].record(i, a).is_path_clear(a, to_local(mesh.after, p(i)))) return {};
    return crossing(mesh, x(i), p(i));
  }

  /// The normal towards the side where the particle comes from; a two-sided sheet may be crossed from behind.
  Point normal(int i, const MovingMesh& mesh, const Crossing& at) const {
    return dot(at.normal, to_local(mesh.after, p(i)) - to_local(mesh.before, x(i))) > 0 ? -at.normal : at.normal;
  }
};

/// Clamps the particles in the mask in front of every mesh; others stay in a ball without surface. Sets the bits of
/// particles for which no position is found in `unresolved`.
template <class R>
struct ClampTunnelling : PathsAcrossMeshes<R> {
  using RunsOnHost = void;
  bool move_with_meshes;  // a particle that crosses a mesh moves with it first, from where the substep began
  const unsigned long long* bits;
  unsigned long long* unresolved;
  template <class Group>
  HOST_KERNEL void operator()(const Group& group) const {
    for_each_in_group(bits, group.index, [this](int i) KERNEL_LAMBDA { clamp(i); });
  }

 private:
  static constexpr int kRounds = 8;  // corners between two walls need two, acute ones more

  void clamp(int i) const {
    if (!(this->particles.w[i] > R(0)) || (move_with_meshes && !move_with_crossed_mesh(i))) return;
    if (clamp_to_all_meshes(i)) return;
    // Each mesh pushes it behind another one: it stays where the substep began, unless a moving mesh pushes it from
    // there.
    this->particles.p.clear_displacement(i);
    if (!clamp_to_all_meshes(i)) unresolved[i / kGroupSize] |= 1ull << i % kGroupSize;
  }

  /// Returns false if the particle crosses no mesh.
  bool move_with_crossed_mesh(int i) const {
    for (int k = 0; k < this->count; ++k)
      if (this->crossing_of(i, k).hit) {
        this->particles.p.d.set(i, rigid_displacement(this->meshes[k].motion(), this->particles.x[i]));
        return true;
      }
    return false;
  }

  /// Clamps a particle in front of every mesh in turn until it crosses none. Returns false if it still does.
  bool clamp_to_all_meshes(int i) const {
    for (int round = 0; round < kRounds; ++round) {
      bool crossed = false;
      for (int k = 0; k < this->count; ++k) crossed = clamp_to_mesh(i, k) || crossed;
      if (!crossed) return true;
    }
    return false;
  }

  bool clamp_to_mesh(int i, int k) const {
    const Crossing at = this->crossing_of(i, k);
    if (!at.hit) return false;
    const MovingMesh& mesh = this->meshes[k];
    const Point n = this->normal(i, mesh, at);
    const double height = mesh.thickness - this->caches[k].overlap(i);
    const Point shift = rotate(mesh.after, n) * (height - dot(n, to_local(mesh.after, this->p(i)) - at.q));
    this->particles.p.add_displacement(i, rounded<R>(shift));
    return true;
  }
};

/// Records the offset by which the particles in the mask were forced through meshes.
template <class R>
struct RecordTunnelling : PathsAcrossMeshes<R> {
  using RunsOnHost = void;
  const unsigned long long* bits;
  template <class Group>
  HOST_KERNEL void operator()(const Group& group) const {
    for_each_in_group(bits, group.index, [this](int i) KERNEL_LAMBDA { record(i); });
  }

 private:
  void record(int i) const {
    for (int k = 0; k < this->count; ++k)
      if (const Crossing at = this->crossing_of(i, k); at.hit) {
        const MovingMesh& mesh = this->meshes[k];
        const ProximityCacheView<R>& cache = this->caches[k];
        const Point n = this->normal(i, mesh, at);
        ClosestPointRecord last = cache.record(i, to_local(mesh.before, this->x(i)));
        last.tunnel_offset = n * dot(n, to_local(mesh.after, this->p(i)) - at.q);
        cache.allocate_entries(i / kGroupSize, this->particles, mesh.before);
        cache.store(i, last);
        invalidate_cached_position(*cache.contact(i));
      }
  }
};

/// Marks the particles that ClampTunnelling has moved as kinematic, with the mesh that they move with
/// as owner; a particle that was clamped otherwise has none. Counts them.
template <class R>
struct MarkMovedParticles {
  Particles<R> particles;
  Points<R> before;  // displacements
  KinematicMarks<R> marks;
  const Pose* motion;
  int meshes;
  KERNEL Sum operator()(int i) const {
    const Vector3<R> displacement = particles.p.d[i];
    if (same(displacement, before[i])) return {};
    if (!marks.is_enabled()) return {1.0};
    KinematicOwner owner = 0;
    while (owner < meshes && !same(displacement, rigid_displacement(motion[owner], particles.x[i]))) ++owner;
    marks.w[i] = R(0), marks.owner[i] = owner < meshes ? marks.number + owner : kNoOwner;
    return {1.0};
  }
};

/// Sets the bits of the particles of a group that restitution moves: from x, where the substep ended, to p.
template <class R>
struct FindRestituted {
  Particles<R> particles;
  unsigned long long* bits;
  KERNEL void operator()(int g) const {
    unsigned long long moved = 0;
    for (int bit = 0; bit < kGroupSize && g * kGroupSize + bit < particles.count; ++bit) {
      const int i = g * kGroupSize + bit;
      if (particles.w[i] > R(0) && !same(particles.p.d[i], {R(0), R(0), R(0)})) moved |= 1ull << bit;
    }
    bits[g] = moved;
  }
};

/// Cancels the motion of particles that restitution would move through a mesh.
template <class R>
struct ClampRestitution : EnvironmentView<R> {
  using RunsOnHost = void;
  const unsigned long long* bits;
  template <class Group>
  HOST_KERNEL void operator()(const Group& group) const {
    for_each_in_group(bits, group.index, [this](int i) KERNEL_LAMBDA { clamp(i); });
  }

 private:
  void clamp(int i) const {
    for (int k = 0; k < this->count; ++k) {
      MovingMesh mesh = this->meshes[k];
      mesh.before = mesh.after;
      if (crossing(mesh, in_double(this->particles.x[i]), this->particles.p.position_without_low(i)).hit)
        return this->particles.p.clear_displacement(i);
    }
  }
};

}  // namespace malha
