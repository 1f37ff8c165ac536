// What is remembered of particles near an environment mesh from substep to substep: 20 bytes of each, and a slot with
// the rest and its contact for those that are near.
#pragma once
#include "kernels/contact.h"
#include "kernels/pack.h"
#include "kernels/pose.h"

namespace malha {

/// Returns what the number was.
KERNEL int count_up(int* number) {
#if defined(__CUDA_ARCH__)
  return atomicAdd(number, 1);
#else
  return __atomic_fetch_add(number, 1, __ATOMIC_RELAXED);
#endif
}

inline constexpr int kWord = 64;  // particles: a bit each

/// Around where all particles of a word were last seen (m, mesh's frame), for a first test of them all.
struct WordBall {
  float x, y, z, radius;
  float distance;  // from all these places nothing is nearer; 0: not known; below 0: the ball is too near to be of use

  /// Whether it stands for where all particles were seen.
  KERNEL bool keeps_all() const { return distance > 0; }
  /// From its middle nothing is nearer.
  KERNEL float from_middle() const { return 0.99999f * (distance - radius); }
};

/// Where a particle was last seen (m, mesh's frame), and how near nothing is: of a word without a ball.
struct PlaceSeen {
  float x, y, z, distance;
};

/// Of one mesh.
template <class R>
struct Nearby {
  Points<float> at;  // as in LastSeen
  WordBall* balls;
  float* distance;       // nothing is nearer to `at`
  int* slot;             // none: -1
  Contact<R>* contacts;  // of each slot
  Near* near;            // the same
  int *used, *freed;  // slots in all, and how many of them are free; there is room for every particle that is looked at

  KERNEL LastSeen seen(int i) const {
    if (slot[i] >= 0) return near[slot[i]].seen;
    const Vector3<float> a = at[i];
    return {{double(a.x), double(a.y), double(a.z)}, double(distance[i]), -1, {0, 0, 0}};
  }

  KERNEL void see(int i, const LastSeen& last) const {
    const Vector3<float> rounded = in_float(last.at);
    at.set(i, rounded);
    distance[i] = certain_distance(last);
    balls[i / kWord].distance = 0;
    int s = slot[i];
    if (!needs_slot(last)) {
      if (s < 0) return;
      contacts[s].particle = -1, slot[i] = -1;
      count_up(freed);
      return;
    }
    if (s < 0) {
      s = slot[i] = count_up(used);
      let_go(contacts[s]);
      contacts[s].particle = i, near[s].cell = 0, near[s].feature.radius = -1;
    }
    near[s].seen = last;
  }

  /// Whether there is more to remember than a place and a distance in float tell.
  KERNEL static bool needs_slot(const LastSeen& last) {
    const Vector3<double>& passed = last.passed;
    return last.triangle >= 0 || passed.x != 0 || passed.y != 0 || passed.z != 0 ||
           !(certain_distance(last) > 0 || last.distance == -INFINITY);
  }

  KERNEL Contact<R>* contact(int i) const { return slot[i] < 0 ? nullptr : &contacts[slot[i]]; }

 private:
  KERNEL static Vector3<float> in_float(const Vector3<double>& a) { return {float(a.x), float(a.y), float(a.z)}; }
  /// From the rounded place.
  KERNEL static float certain_distance(const LastSeen& last) {
    const Vector3<float> rounded = in_float(last.at);
    const Vector3<double> off{last.at.x - rounded.x, last.at.y - rounded.y, last.at.z - rounded.z};
    const double certain = last.distance - root(dot(off, off));
    const float nearest = float(certain);
    const float below = nearest - 1.2e-7f * fabsf(nearest);
    return double(nearest) > certain ? below : nearest;
  }
};

/// A pose in float, for first tests.
struct FloatPose {
  float r[9], t[3];
  bool moves;
  FloatPose() = default;
  explicit FloatPose(const Pose& pose) : moves(pose.moves) {
    for (int k = 0; k < 9; ++k) r[k] = float(pose.r[k]);
    t[0] = float(pose.t.x), t[1] = float(pose.t.y), t[2] = float(pose.t.z);
  }
  KERNEL Vector3<float> to_world(const Vector3<float>& a) const {
    if (!moves) return a;
    return {r[0] * a.x + r[1] * a.y + r[2] * a.z + t[0], r[3] * a.x + r[4] * a.y + r[5] * a.z + t[1],
            r[6] * a.x + r[7] * a.y + r[8] * a.z + t[2]};
  }
  template <class S>
  KERNEL Vector3<S> to_local(const Vector3<S>& x) const {
    if (!moves) return x;
    const S a = x.x - S(t[0]), b = x.y - S(t[1]), c = x.z - S(t[2]);
    return {S(r[0]) * a + S(r[3]) * b + S(r[6]) * c, S(r[1]) * a + S(r[4]) * b + S(r[7]) * c,
            S(r[2]) * a + S(r[5]) * b + S(r[8]) * c};
  }
};

/// A number or a pack of them, rounded to float.
template <class S>
KERNEL void load_float(const float* from, S& to) {
  load(from, to);
}
template <class S>
KERNEL void load_float(const double* from, S& to) {
  constexpr int lanes = int(sizeof(S) / sizeof(float));
  float rounded[lanes];
  for (int l = 0; l < lanes; ++l) rounded[l] = float(from[l]);
  load(rounded, to);
}
template <class S, class Q>
KERNEL Vector3<S> load_floats(const Points<Q>& from, int i) {
  Vector3<S> a;
  load_float(from.x + i, a.x), load_float(from.y + i, a.y), load_float(from.z + i, a.z);
  return a;
}
template <class S>
KERNEL S sum_of_sizes(const Vector3<S>& a) {
  return magnitude(a.x) + magnitude(a.y) + magnitude(a.z);
}

/// Which particles may have come near enough to be looked at, a bit each: a stream in float, rounded so that none is
/// missed. `reach` < 0: those whose way from x to p may leave the ball around where they were last seen, in which there
/// is no surface; otherwise those whose way may reach the surface, or pass it by `reach` (m). Words that are far off as
/// a whole are told by their balls, which from then on stand for where each of their particles was.
template <class R>
struct MayTouch {
  Points<R> x, p;
  int count;
  Points<float> at;
  float* distance;
  WordBall* balls;
  FloatPose before, after;
  float reach;
  bool add;  // to the bits that there are
  unsigned long long* bits;

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    using S = Lane<float, typename Group::Isa>;
    constexpr int lanes = kLanes<float, typename Group::Isa>;
    const int first = group.index * kWord, n = count - first < kWord ? count - first : kWord;
    unsigned long long word = add ? bits[group.index] : 0;
    WordBall& ball = balls[group.index];
    if (ball.keeps_all()) {
      if (keeps_off<S>(ball, first, n)) {
        bits[group.index] = word;
        return;
      }
      ball.distance = -1;
    }
    float over[kWord];
    int k = 0;
    for (; k + lanes <= n; k += lanes) store(excess<S>(first + k), over + k);
    for (; k < n; ++k) over[k] = excess<float>(first + k);
    for (; k < kWord; ++k) over[k] = -1;
    const unsigned long long touch = not_below_zero(over);
    if (touch == 0 && ball.distance == 0 && reach >= 0) {
      ball = ball_of(first, n);
      if (ball.keeps_all()) stand_for_all(ball, first, n);
    }
    bits[group.index] = word | touch;
  }

 private:
  /// A bit for each number that is not below 0, or no number.
  KERNEL static unsigned long long not_below_zero(const float* a) {
    unsigned char flags[kWord];
    for (int k = 0; k < kWord; ++k) flags[k] = !(a[k] < 0);
    unsigned long long bits = 0;
    for (int k = 0; k < kWord; k += 8) {
      unsigned long long eight;  // bytes, of which the product gathers the lowest bits in the highest byte
      __builtin_memcpy(&eight, flags + k, sizeof eight);
      bits |= (eight * 0x0102040810204080ull >> 56) << k;
    }
    return bits;
  }
  /// Around its box; of use where it is farther off than it is large.
  KERNEL WordBall ball_of(int first, int n) const {
    const auto middle = [&](const float* a) KERNEL_LAMBDA {
      float least = a[first], most = least;
      for (int i = first + 1; i < first + n; ++i) least = a[i] < least ? a[i] : least, most = a[i] > most ? a[i] : most;
      return (least + most) / 2;
    };
    const Vector3<float> c{middle(at.x), middle(at.y), middle(at.z)};
    float most = 0, nearest = distance[first];
    for (int i = first; i < first + n; ++i) {
      const Vector3<float> d = at[i] - c;
      most = larger(most, dot(d, d)), nearest = distance[i] < nearest ? distance[i] : nearest;
    }
    const float radius = 1.00001f * root(most);
    return {c.x, c.y, c.z, radius, nearest > 4 * radius ? nearest : -1};
  }

  /// All particles as if seen in its middle: a state holds the ball alone.
  KERNEL void stand_for_all(const WordBall& ball, int first, int n) const {
    for (int i = first; i < first + n; ++i) {
      at.set(i, {ball.x, ball.y, ball.z});
      distance[i] = ball.from_middle();
    }
  }

  /// Whether no particle of the word can have come near: all are in a ball around where all were seen.
  template <class S>
  KERNEL bool keeps_off(const WordBall& ball, int first, int n) const {
    const Vector3<float> c{ball.x, ball.y, ball.z};
    const float start = farthest<S>(x, before.to_world(c), first, n), end = farthest<S>(p, after.to_world(c), first, n);
    const float m = start + ball.radius, l = reach < 0 ? end + ball.radius : start + end;
    const float slack = 1e-5f * (sum_of_sizes(c) + start + end + shift());
    return (reach < 0 ? larger(m, l) : m + l + reach) + slack < ball.distance;  // not a number: false
  }
  /// Of the particles from c; not a number where one of them is not.
  template <class S>
  KERNEL float farthest(const Points<R>& points, const Vector3<float>& c, int first, int n) const {
    constexpr int lanes = int(sizeof(S) / sizeof(float));
    S most(0.0f), sum(0.0f);
    const Vector3<S> centre{S(c.x), S(c.y), S(c.z)};
    float all = 0, sums = 0;
    int k = 0;
    for (; k + lanes <= n; k += lanes) {
      const Vector3<S> d = load_floats<S>(points, first + k) - centre;
      const S d2 = dot(d, d);
      most = larger(most, d2), sum = sum + d2;
    }
    for (; k < n; ++k) {
      const Vector3<float> d = load_floats<float>(points, first + k) - c;
      all = larger(all, dot(d, d)), sums += dot(d, d);
    }
    float each[lanes], added[lanes];
    store(most, each), store(sum, added);
    for (int half = lanes / 2; half > 0; half /= 2)
      for (int l = 0; l < half; ++l) each[l] = larger(each[l], each[l + half]), added[l] += added[l + half];
    all = larger(all, each[0]), sums += added[0];
    return sums < INFINITY ? root(all) : NAN;
  }

  /// How far off the mesh's frame is, before and after.
  KERNEL float shift() const {
    return fabsf(before.t[0]) + fabsf(before.t[1]) + fabsf(before.t[2]) + fabsf(after.t[0]) + fabsf(after.t[1]) +
           fabsf(after.t[2]);
  }

  /// By how much it may come too near; below 0: it cannot.
  template <class S>
  KERNEL S excess(int i) const {
    const Vector3<S> start = load_floats<S>(x, i), end = load_floats<S>(p, i), seen = load_floats<S>(at, i);
    const Vector3<S> a = before.to_local(start), b = after.to_local(end);
    const Vector3<S> moved = a - seen, way = reach < 0 ? b - seen : b - a;
    S known;
    load(distance + i, known);
    const S m = root(dot(moved, moved)), l = root(dot(way, way));
    // Some ten roundings of each coordinate on its way.
    const S slack = (sum_of_sizes(start) + sum_of_sizes(end) + S(shift())) * S(4e-6f);
    return (reach < 0 ? larger(m, l) : m + l + S(reach)) + slack - known;
  }
};

/// Bits of words, array after array.
struct Questions {
  const unsigned long long* bits;
  int count, words;
  KERNEL unsigned long long of(int question, int word) const { return bits[size_t(question) * words + word]; }
  /// In any of them.
  KERNEL unsigned long long asked(int word) const {
    unsigned long long any = 0;
    for (int q = 0; q < count; ++q) any |= of(q, word);
    return any;
  }
};

/// How many the last of the questions names; of all of them how many words have one, and how many particles no slot;
/// and how many slots there are, the free ones among them.
struct Tested {
  int all = 0, words = 0, without_slot = 0, used = 0, freed = 0;
  KERNEL Tested& operator+=(const Tested& o) {
    all += o.all, words += o.words, without_slot += o.without_slot, used += o.used, freed += o.freed;
    return *this;
  }
};
struct CountTested {
  Questions questions;
  const int *slot, *used, *freed;
  KERNEL Tested operator()(int word) const {
    Tested sum;
    if (word == 0) sum.used = *used, sum.freed = *freed;
    const unsigned long long last = questions.of(questions.count - 1, word);
    unsigned long long rest = questions.asked(word);
    sum.words = rest != 0;
    for (; rest != 0; rest &= rest - 1) {
      const int bit = lowest_bit(rest);
      sum.all += int(last >> bit & 1);
      sum.without_slot += slot[word * kWord + bit] < 0;
    }
    return sum;
  }
};

/// Free slots are taken out, here or on the way to other memory. One item: each has the place that those before leave.
/// One thread of a device would take longer than the way to the host.
template <class R>
struct TakeOutFree {
  using AsksTheHost = void;
  Nearby<R> nearby;
  Near* near_to;
  Contact<R>* contacts_to;
  KERNEL void operator()(int) const {
    int kept = 0;
    for (int s = 0; s < *nearby.used; ++s) {
      if (nearby.contacts[s].particle < 0) continue;
      near_to[kept] = nearby.near[s], contacts_to[kept] = nearby.contacts[s];
      nearby.slot[contacts_to[kept].particle] = kept;
      ++kept;
    }
    *nearby.used = kept, *nearby.freed = 0;
  }
};

/// Of a slot: what was known of its cell.
struct ForgetCells {
  Near* near;
  KERNEL void operator()(int s) const { near[s].cell = 0; }
};

/// What was seen of those that are near, from a checkpoint. One item: slots are given in the order of particles.
template <class R>
struct SeeAll {
  using AsksTheHost = void;
  Nearby<R> nearby;
  const SeenOfPair* seen;
  int count;
  long long first;  // pair of the mesh
  KERNEL void operator()(int) const {
    for (int k = 0; k < count; ++k) nearby.see(int(seen[k].pair - first), seen[k].seen);
  }
};

/// Before contacts are laid: what there was is gone. But what comes again to where its contact was laid for, not
/// farther than `way` (m; below 0: to a mesh that moves), would find the same.
template <class R>
struct LetGo {
  Contact<R>* contacts;
  Points<R> x, p;
  double way;
  KERNEL void operator()(int s) const {
    Contact<R>& contact = contacts[s];
    const int i = contact.particle;
    if (i < 0 || way < 0 || !same(x[i], contact.laid_for)) return let_go(contact);
    const Vector3<double> path = in_double(p[i]) - in_double(x[i]);
    if (!(dot(path, path) <= way * way)) return let_go(contact);
    contact.lambda = R(0);
    contact.slip = {R(0), R(0), R(0)};
    contact.surface.w = R(dot(in_double(contact.plane.xyz()), path));
  }
};

}  // namespace malha
