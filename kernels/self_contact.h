// Contact of deformable bodies with themselves and with each other: a particle and a triangle, or two edges, that come
// near. Every contact is an inequality over four particles, C(p) = distance along n - wanted >= 0, with n and weights
// from where they were (x0, where nothing crosses). They are projected all at once: a particle that k contacts push is
// treated as k particles of mass m / k (mass splitting: Tonge, Benevolenski, Voroshilov 2012), which conserves
// momentum, never overshoots, and gives the same bits whatever the order.
#pragma once
#include "kernels/closest.h"
#include "kernels/hash_grid.h"
#include "kernels/sum.h"

namespace malha {

template <class R>
struct SelfContact {
  int i[4];        // one side, then the other
  R weight[4];     // positive on the one side, negative on the other: at the closest points, their sum is 0
  Vector3<R> n;    // from the other side to the one
  R short_of;      // wanted distance less that at x0, m
  R gap;           // between planes of normal n that hold the sides apart at x0, m
  R lambda, slip;  // accumulated push and friction, kg m
  int first;       // particles of the one side: 1 or 2
};

/// Where the sides of a contact lie along its normal: the lowest of the one, the highest of the other.
template <class S>
struct ContactSides {
  S low = S(INFINITY), high = -S(INFINITY);
  /// `at`: of particle j, of which the first `first` are the one side.
  KERNEL void add(int j, int first, S at) {
    if (j < first)
      low = smaller(low, at);
    else
      high = larger(high, at);
  }
};

/// moved = p - x0, where what looks at pairs finds it in one load a particle.
template <class R>
struct StoreMotion {
  Points<R> p;
  ScatteredPoints<R> x0, moved;
  KERNEL void operator()(int i) const { moved.set(i, p[i] - x0[i]); }
};

/// Motions, each with its weight.
struct MeanMotion {
  double sum[3] = {}, weight = 0;
  KERNEL MeanMotion& operator+=(const MeanMotion& o) {
    for (int k = 0; k < 3; ++k) sum[k] += o.sum[k];
    weight += o.weight;
    return *this;
  }
};

/// Sum and number of the motions that are finite.
template <class R>
struct SumMotion {
  ScatteredPoints<R> moved;
  const unsigned char* takes_part;
  KERNEL MeanMotion operator()(int i) const {
    const Vector3<R> d = moved[i];
    if (!takes_part[i] || !((d.x + d.y + d.z) * R(0) == R(0))) return {};
    return {{double(d.x), double(d.y), double(d.z)}, 1.0};
  }
};

/// d = motion beside the common one; none where it is not finite (such a particle ends the run). Counts the particles
/// whose reach may leave the box that the candidates were found with.
template <class R>
struct OwnMotion {
  ScatteredPoints<R> moved, x0;
  Vector3<R> common;
  ScatteredPoints<R> d, x_then, d_then;  // the last two: of the search
  Vector3<R> since;                      // common motion since then, up to x0
  R slack;                               // by which those boxes were wider, m
  KERNEL Sum operator()(int i) const {
    Vector3<R> own = moved[i] - common;
    own = or_zero((own.x + own.y + own.z) * R(0) == R(0), own);
    d.set(i, own);
    const Vector3<R> from = x0[i] - x_then[i] - since, then = d_then[i];
    return {fits(from.x, own.x, then.x) && fits(from.y, own.y, then.y) && fits(from.z, own.z, then.z) ? 0.0 : 1.0};
  }

 private:
  KERNEL bool fits(R from, R own, R then) const {
    const R low = from + smaller(own, R(0)), high = from + larger(own, R(0));
    return low >= smaller(then, R(0)) - slack && high <= larger(then, R(0)) + slack;
  }
};

/// What a search for candidates that shall serve some substeps starts from.
template <class R>
struct StartSearch {
  ScatteredPoints<R> x0, d, x_then, d_then;
  R ahead;  // substeps
  KERNEL void operator()(int i) const {
    x_then.set(i, x0[i]);
    d_then.set(i, d[i] * ahead);
  }
};

/// What decides how contacts are made.
template <class R>
struct ContactRules {
  R thickness;  // m
  R recovery;   // of a distance below the wanted one, this share is made up for in a substep
};

/// Looks at a candidate: whether it is a contact, and which. In double: where a pair lies a thousandth of its size
/// apart, a normal from float's differences leans enough that planes along it let the pair creep through itself.
template <class R>
struct LookAtCandidate {
  const Candidate* candidates;
  Reaches<R> reaches;
  ScatteredPoints<R> rest;  // positions at the start of the scene
  const int* body;          // of each particle
  ContactRules<R> rules;

  /// Weights at the closest points of the four x.
  KERNEL static void weigh(int first, const Vector3<double>* x, double* weight) {
    if (first == 1) {
      const Vector3<double> w = closest_on_triangle(x[2] - x[1], x[3] - x[1], x[0] - x[1]);
      weight[0] = 1, weight[1] = -w.x, weight[2] = -w.y, weight[3] = -w.z;
    } else {
      const SegmentPoints<double> at = closest_on_segments(x[1] - x[0], x[3] - x[2], x[2] - x[0]);
      weight[0] = 1 - at.s, weight[1] = at.s, weight[2] = at.t - 1, weight[3] = -at.t;
    }
  }

  /// From the other side's closest point to the one's. Weighted differences: nothing cancels far from the origin.
  KERNEL static Vector3<double> between(const Vector3<double>* x, const double* weight) {
    return (x[1] - x[0]) * weight[1] + (x[2] - x[0]) * weight[2] + (x[3] - x[0]) * weight[3];
  }

  KERNEL bool operator()(const Candidate& c, SelfContact<R>& contact) const {
    contact.first = c.are_edges() ? 2 : 1;
    for (int j = 0; j < 4; ++j) contact.i[j] = c.particle(j), contact.weight[j] = R(0);
    contact.n = {R(0), R(0), R(0)}, contact.lambda = contact.slip = R(0);
    Vector3<double> x[4];
    double weight[4];
    places(reaches.x, contact, x);
    weigh(contact.first, x, weight);
    const Vector3<double> apart = between(x, weight);
    const double exact = root(dot(apart, apart));
    const R distance = R(exact);
    if (!(distance > R(0))) return false;  // they touch: neither side is known
    for (int j = 0; j < 4; ++j) contact.weight[j] = R(weight[j]);
    contact.n = {R(apart.x / exact), R(apart.y / exact), R(apart.z / exact)};

    // None leaves its reach, so that the sides come no nearer than this.
    R nearing = R(0), receding = R(0);
    const Vector3<R> n = contact.n;
    for (int j = 0; j < 4; ++j) {
      const Vector3<R> d = reaches.d[contact.i[j]];
      if (j < contact.first)
        nearing = larger(nearing, positive(-n.x * d.x) + positive(-n.y * d.y) + positive(-n.z * d.z));
      else
        receding = larger(receding, positive(n.x * d.x) + positive(n.y * d.y) + positive(n.z * d.z));
    }
    const R aside = reaches.margin *
                    (positive(n.x) + positive(-n.x) + positive(n.y) + positive(-n.y) + positive(n.z) + positive(-n.z));
    if (distance - nearing - receding > larger(rules.thickness, R(2) * aside)) return false;

    ContactSides<double> sides;
    for (int j = 0; j < 4; ++j) sides.add(j, contact.first, dot(in_double(contact.n), x[j] - x[0]));
    contact.gap = R(sides.low - sides.high);
    const R wanted = smaller(rules.thickness, most_wanted(contact));
    contact.short_of = distance < wanted ? rules.recovery * (wanted - distance) : wanted - distance;
    return true;
  }

  /// Whether their particles can reach each other.
  KERNEL bool may_meet(const Candidate& c) const {
    const Box<R>* const of = reaches.boxes;
    const Box<R> first = of[c.particle(0)], second = of[c.i[1]], others = around(of[c.i[2]], of[c.i[3]]);
    return c.are_edges() ? overlap(around(first, second), others) : overlap(first, around(others, second));
  }

 private:
  KERNEL static R positive(R a) { return larger(a, R(0)); }
  KERNEL static Vector3<double> in_double(const Vector3<R>& a) { return {double(a.x), double(a.y), double(a.z)}; }
  KERNEL static void places(const ScatteredPoints<R>& of, const SelfContact<R>& c, Vector3<double>* x) {
    for (int j = 0; j < 4; ++j) x[j] = in_double(of[c.i[j]]);
  }

  /// What lies near in the scene's rest state (the next but one in a fine mesh) is wanted no further than half as far
  /// apart as there.
  KERNEL R most_wanted(const SelfContact<R>& contact) const {
    if (body[contact.i[0]] != body[contact.i[3]]) return R(INFINITY);
    Vector3<double> x[4];
    double weight[4];
    places(rest, contact, x);
    weigh(contact.first, x, weight);
    const Vector3<double> apart = between(x, weight);
    return R(0.5 * root(dot(apart, apart)));
  }
};

/// 1 where the candidate is worth a look.
template <class R>
struct CountMeetings {
  LookAtCandidate<R> look;
  int* meets;
  KERNEL void operator()(int c) const { meets[c] = look.may_meet(look.candidates[c]) ? 1 : 0; }
};

/// Looks at those. What proves to be no contact stays as one that nothing ever reaches, and has no ends.
template <class R>
struct LayContacts {
  LookAtCandidate<R> look;
  const int* place;  // of each candidate
  int count, total;  // of candidates, of places
  SelfContact<R>* contacts;
  int* ends;  // of each contact: how many
  KERNEL void operator()(int c) const {
    const int at = place[c], next = c + 1 < count ? place[c + 1] : total;
    if (next == at) return;
    const bool is_contact = look(look.candidates[c], contacts[at]);
    if (!is_contact) contacts[at].short_of = contacts[at].gap = -R(INFINITY);
    ends[at] = is_contact ? 4 : 0;
  }
};

/// The particles of the contacts, for sorting.
template <class R>
struct EnterEnds {
  const SelfContact<R>* contacts;
  const int* place;  // of their ends
  Keyed* ends;       // particle, and 4 contact + slot
  KERNEL void operator()(int k) const {
    if (!(contacts[k].gap > -R(INFINITY))) return;
    for (int j = 0; j < 4; ++j) ends[place[k] + j] = {unsigned(contacts[k].i[j]), 4 * k + j};
  }
};

/// Motion of the one side at the closest points relative to the other's.
template <class R>
KERNEL Vector3<R> relative_motion(const SelfContact<R>& c, const ScatteredPoints<R>& moved) {
  Vector3<R> sum{R(0), R(0), R(0)};
  for (int j = 0; j < 4; ++j) sum = sum + moved[c.i[j]] * c.weight[j];
  return sum;
}

/// Whether it pushes or has pushed.
template <class R>
struct MarkActive {
  ScatteredPoints<R> moved;
  const SelfContact<R>* contacts;
  unsigned char* active;
  KERNEL void operator()(int k) const {
    const SelfContact<R>& c = contacts[k];
    active[k] = c.lambda > R(0) || dot(c.n, relative_motion(c, moved)) < c.short_of;
  }
};

/// moved's w = the inverse mass of each of the parts into which its active contacts split a particle.
template <class R>
struct SplitMasses {
  const R* w;
  const Keyed* ends;
  const int* begin;
  const unsigned char* active;
  ScatteredPoints<R> moved;
  KERNEL void operator()(int i) const {
    int count = 0;
    for (int e = begin[i]; e < begin[i + 1]; ++e) count += active[ends[e].value / 4];
    moved.of[i].w = w[i] * R(count);
  }
};

/// What a contact gives to its particles.
template <class R>
struct Push {
  Vec4<R> impulse;  // on the one side, kg m; w: 0 where it gives none
  R weight[4];
};

/// The impulse of each active contact (times dt): a push, and friction on positions as in kernels/contact.h.
template <class R>
struct PushContacts {
  ScatteredPoints<R> moved;
  SelfContact<R>* contacts;
  const unsigned char* active;
  R friction;
  Push<R>* pushes;
  KERNEL void operator()(int k) const {
    Push<R>& push = pushes[k];
    push.impulse.w = R(0);
    if (!active[k]) return;
    SelfContact<R>& c = contacts[k];
    R W = R(0);
    for (int j = 0; j < 4; ++j) W += c.weight[j] * c.weight[j] * moved.of[c.i[j]].w;
    if (!(W > tiny<R>())) return;
    const Vector3<R> motion = relative_motion(c, moved);
    const R along = dot(c.n, motion);
    const R dlambda = larger((c.short_of - along) / W, -c.lambda);
    c.lambda += dlambda;
    const Vector3<R> slide = motion - c.n * along;
    const R length = root(dot(slide, slide));
    const R budget = larger(friction * c.lambda - c.slip, R(0));
    const R taken = smaller(length / W, budget);
    c.slip += taken;
    Vector3<R> impulse = c.n * dlambda;
    if (taken > R(0)) impulse = impulse - slide * (taken / length);
    push.impulse = {impulse.x, impulse.y, impulse.z, R(1)};
    for (int j = 0; j < 4; ++j) push.weight[j] = c.weight[j];
  }
};

/// Every particle takes its share of its contacts' impulses, in their order.
template <class R>
struct GatherPushes {
  Points<R> p;
  const R* w;
  const Keyed* ends;
  const int* begin;
  const Push<R>* pushes;
  KERNEL void operator()(int i) const {
    Vector3<R> sum{R(0), R(0), R(0)};
    for (int e = begin[i]; e < begin[i + 1]; ++e) {
      const Push<R>& push = pushes[ends[e].value / 4];
      if (push.impulse.w > R(0)) sum = sum + push.impulse.xyz() * push.weight[ends[e].value % 4];
    }
    if (w[i] > R(0) && begin[i] < begin[i + 1]) p.set(i, p[i] + sum * w[i]);
  }
};

/// Contacts that pushed in the last substep.
template <class R>
struct CountPushing {
  const SelfContact<R>* contacts;
  KERNEL Sum operator()(int k) const { return {contacts[k].lambda > R(0) ? 1.0 : 0.0}; }
};

}  // namespace malha
