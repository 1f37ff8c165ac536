// On a device: of the particles that may touch an environment mesh, those are answered that need no more than the
// mesh's lists. The others are left to the host, which asks Embree (find_contact.h). Both leave the same.
#pragma once
#include "host/collision/contact_look.h"

namespace malha {

/// The bit `bit` of a word is no longer set.
KERNEL void clear_bit(unsigned long long* word, int bit) {
#if defined(__CUDA_ARCH__)
  atomicAnd(word, ~(1ull << bit));
#else
  __atomic_fetch_and(word, ~(1ull << bit), __ATOMIC_RELAXED);
#endif
}

template <class R>
struct AnswerByLists : ContactLook<R> {
  using Look = typename ContactLook<R>::Look;
  bool alone;                // there is no other mesh, through which it could be lifted
  unsigned long long* bits;  // of the particles, a word for each kWord of them

  AnswerByLists(const ContactLook<R>& look, bool is_alone, unsigned long long* those)
      : ContactLook<R>(look), alone(is_alone), bits(those) {}

  KERNEL void operator()(int i) const {
    unsigned long long* const word = bits + i / kWord;
    if (!(*word >> i % kWord & 1)) return;
    if (!(this->particles.w[i] > R(0)) || answers(i)) clear_bit(word, i % kWord);
  }

 private:
  KERNEL bool answers(int i) const {
    const SurfaceView& surface = this->surface;
    Look look;
    if (!this->begin(i, look)) return true;
    if (const NearFeature* const feature = this->feature_of(look)) {
      const ClosestPoint near = surface.of_feature(*feature, look.a);
      return leaves(look, near.distance) || answers(look, near, near.distance);
    }
    look.cell = surface.cell_of(look.a, look.cell);
    if (look.cell == 0) return false;
    look.near = surface.template nearest<OneLane>(look.a, look.cell);
    if (look.near.triangle < 0) return false;
    if (leaves(look, look.near.distance)) return true;
    if (!answers(look, surface.of_feature(surface.feature(look.near), look.a), look.near.distance)) return false;
    this->keep_feature(look, [&](double wall, double error) KERNEL_LAMBDA { return holds_within(look, wall, error); });
    return true;
  }

  /// Whether a coarse bound tells that it cannot touch, although nothing of the lists is in reach.
  KERNEL bool leaves(const Look& look, double distance) const {
    if (distance <= look.reach || look.depth > 0) return false;
    const double least = this->surface.known_least(look.a);
    if (!(least > look.reach)) return false;
    this->see_beyond(look, least);
    return true;
  }

  /// `distance`: of the nearest, as it was compared.
  KERNEL bool answers(const Look& look, const ClosestPoint& near, double distance) const {
    if (!(distance <= look.reach) && !(look.depth > 0) && this->surface.known_least(look.a) < 0)
      return false;  // the host finds out
    if (!(distance < look.radius)) {
      this->see_beyond(look, look.radius);
      return true;
    }
    if (asks_the_side(look)) return false;
    const Point outward = this->towards(near, look.a);
    if (asks_more(look, near, this->signed_distance(near, look.a, outward))) return false;
    const auto lift = [this](const Look& of, const Point&, const Point& n, LastSeen& last) KERNEL_LAMBDA {
      this->shift(of, this->shift_to_rim(n, last.distance), n, last);
      return true;
    };
    this->finish(look, near, outward, lift, [](int, const Point&) KERNEL_LAMBDA {});
    return true;
  }

  /// As NearPairs::holds_within: one triangle of the list after the other.
  KERNEL double holds_within(const Look& look, double wall, double error) const {
    const NearMesh& mesh = this->surface.cells;
    const NearCell& cell = mesh.cells[look.cell];
    const Point p = this->surface.in_near_mesh(look.a);
    const HoldsWithin holds(mesh, p, look.near, error);
    double radius = wall - error;
    for (int k = cell.first; k < cell.first + cell.count && radius > 0; ++k) {
      const Point q = nearest_of_listed(mesh, p, mesh.lists + k, 1).q, d = p - q;
      const double margin = holds.of(mesh.lists[k], q, dot(d, d), radius);
      if (!(margin >= radius)) radius = margin > 0 ? margin : -1;
    }
    return radius;
  }

  /// Whether it may have been dragged through.
  KERNEL bool asks_the_side(const Look& look) const {
    return this->sides == Sides::TwoSided && look.last.distance > -INFINITY && look.last.distance < INFINITY &&
           look.moved >= look.last.distance;
  }
  /// Whether the rim, or a way that goes far, is to be looked at: what finish() would do where it is not.
  KERNEL bool asks_more(const Look& look, const ClosestPoint& near, double distance) const {
    if (distance > look.reach || (distance < 0 && near.boundary)) return false;
    return (distance < this->thickness && (!alone || !this->is_free(distance))) || this->goes_far(look, distance);
  }
};

}  // namespace malha
