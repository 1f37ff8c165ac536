// SPDX-License-Identifier: Apache-2.0
// Final guard of a substep against tunnelling: no particle passes through a mesh of the environment. What neighbours or
// other meshes dragged through one, past every contact that its own path announced, is put back before it.
#pragma once
#include "host/environment/find_contact.h"
#include "kernels/environment/edge_contact.h"

namespace malha {

/// How far a motion of the substep takes a place of the world.
template <class R>
KERNEL Vector3<R> carried(const Pose& motion, const Vector3<R>& x) {
  return rounded<R>(to_world(motion, in_double(x)) - in_double(x));
}

/// work(i) for the particles that a word of bits names.
template <class Work>
HOST_KERNEL void for_each_of_word(const unsigned long long* bits, int word, const Work& work) {
  for (unsigned long long rest = bits[word]; rest != 0; rest &= rest - 1) work(word * kGroupSize + lowest_bit(rest));
}

/// The particles that a word of bits names: others keep within a ball without surface. Those that nothing holds back
/// are named by `pressed`.
template <class R>
struct PutBeforeMeshes : EnvironmentView<R> {
  using RunsOnHost = void;
  const unsigned long long* bits;
  unsigned long long* pressed;
  template <class Group>
  HOST_KERNEL void operator()(const Group& group) const {
    pressed[group.index] = 0;
    for_each_of_word(bits, group.index, [this](int i) KERNEL_LAMBDA { hold(i); });
  }

 protected:
  static constexpr int kRounds = 8;  // corners of two walls need two, acute ones more

  void hold(int i) const {
    if (!(this->particles.w[i] > R(0)) || settle(i)) return;
    // What puts it before one mesh puts it behind another: it stays where it was, as far as what moves lets it.
    this->particles.p.clear_displacement(i);
    if (!settle(i)) pressed[i / kGroupSize] |= 1ull << i % kGroupSize;
  }

  Point x(int i) const { return in_double(this->particles.x[i]); }
  Point p(int i) const { return this->particles.p.position_without_low(i); }

  /// Puts it before every mesh in turn until it crosses none.
  bool settle(int i) const {
    for (int round = 0; round < kRounds; ++round) {
      bool crossed = false;
      for (int k = 0; k < this->count; ++k) crossed = put_before(i, k) || crossed;
      if (!crossed) return true;
    }
    return false;
  }

  Crossing crossing_of(int i, int k) const {
    const MovingSurface& mesh = this->meshes[k];
    const Point a = to_local(mesh.before, x(i));
    if (this->nearby[k].seen(i, a).is_path_clear(a, to_local(mesh.after, p(i)))) return {};
    return crossing(mesh, x(i), p(i));
  }

  /// Towards where it comes from; a two-sided sheet may be crossed from behind.
  Point normal(int i, const MovingSurface& mesh, const Crossing& at) const {
    return dot(at.normal, to_local(mesh.after, p(i)) - to_local(mesh.before, x(i))) > 0 ? -at.normal : at.normal;
  }

  bool put_before(int i, int k) const {
    const Crossing at = crossing_of(i, k);
    if (!at.hit) return false;
    const MovingSurface& mesh = this->meshes[k];
    const Point n = normal(i, mesh, at);
    const double above = mesh.thickness - this->nearby[k].overlap(i);
    const Point shift = rotate(mesh.after, n) * (above - dot(n, to_local(mesh.after, p(i)) - at.q));
    this->particles.p.add_displacement(i, rounded<R>(shift));
    return true;
  }
};

/// The same after what holds bodies apart has moved them: what crosses a mesh now rests on it, as seen from the mesh.
template <class R>
struct CarryBeforeMeshes : PutBeforeMeshes<R> {
  template <class Group>
  HOST_KERNEL void operator()(const Group& group) const {
    this->pressed[group.index] = 0;
    for_each_of_word(this->bits, group.index, [this](int i) KERNEL_LAMBDA { carry(i); });
  }

 private:
  void carry(int i) const {
    if (!(this->particles.w[i] > R(0))) return;
    for (int k = 0; k < this->count; ++k)
      if (this->crossing_of(i, k).hit) {
        this->particles.p.d.set(i, carried(this->meshes[k].motion(), this->particles.x[i]));
        return this->hold(i);
      }
  }
};

/// How far and whither the particles that bits name were pressed through meshes is remembered.
template <class R>
struct NotePressed : PutBeforeMeshes<R> {
  template <class Group>
  HOST_KERNEL void operator()(const Group& group) const {
    for_each_of_word(this->bits, group.index, [this](int i) KERNEL_LAMBDA { note(i); });
  }

 private:
  void note(int i) const {
    for (int k = 0; k < this->count; ++k)
      if (const Crossing at = this->crossing_of(i, k); at.hit) {
        const MovingSurface& mesh = this->meshes[k];
        const ContactCacheView<R>& known = this->nearby[k];
        const Point n = this->normal(i, mesh, at);
        ClosestPointRecord last = known.seen(i, to_local(mesh.before, this->x(i)));
        last.tunnel_offset = n * dot(n, to_local(mesh.after, this->p(i)) - at.q);
        known.give_places(i / kGroupSize, this->particles, mesh.before);
        known.see(i, last);
        invalidate_place(*known.contact(i));
      }
  }
};

/// Which particles that has moved, and by which mesh: nobody carries what another mesh was in the way of.
template <class R>
struct NoteCarried {
  Particles<R> particles;
  Points<R> before;  // the ways
  HeldByEdges<R> held;
  const Pose* motion;
  int meshes;
  KERNEL Sum operator()(int i) const {
    const Vector3<R> way = particles.p.d[i];
    if (same(way, before[i])) return {};
    if (!held.any()) return {1.0};
    Carrier by = 0;
    while (by < meshes && !same(way, carried(motion[by], particles.x[i]))) ++by;
    held.w[i] = R(0), held.by[i] = by < meshes ? held.number + by : kNobody;
    return {1.0};
  }
};

/// Which particles of a word a bounce carries back, a bit each: from x, where the substep ended, to p.
template <class R>
struct FindBounced {
  Particles<R> particles;
  unsigned long long* bits;
  KERNEL void operator()(int word) const {
    unsigned long long moved = 0;
    for (int bit = 0; bit < kGroupSize && word * kGroupSize + bit < particles.count; ++bit) {
      const int i = word * kGroupSize + bit;
      if (particles.w[i] > R(0) && !same(particles.p.d[i], {R(0), R(0), R(0)})) moved |= 1ull << bit;
    }
    bits[word] = moved;
  }
};

/// What a bounce carries back on its way ends where it would cross a mesh.
template <class R>
struct HoldBounce : EnvironmentView<R> {
  using RunsOnHost = void;
  const unsigned long long* bits;
  template <class Group>
  HOST_KERNEL void operator()(const Group& group) const {
    for_each_of_word(bits, group.index, [this](int i) KERNEL_LAMBDA { hold(i); });
  }

 private:
  void hold(int i) const {
    for (int k = 0; k < this->count; ++k) {
      MovingSurface mesh = this->meshes[k];
      mesh.before = mesh.after;
      if (crossing(mesh, in_double(this->particles.x[i]), this->particles.p.position_without_low(i)).hit)
        return this->particles.p.clear_displacement(i);
    }
  }
};

}  // namespace malha
