// SPDX-License-Identifier: Apache-2.0
// One projection, written once for every constraint: gather, evaluate, PBD or XPBD update, scatter.
#pragma once
#include "kernels/projection/constraint_kind.h"
#include "kernels/projection/direction.h"
#include "kernels/projection/patch.h"
#include "kernels/projection/patch_memory.h"

namespace malha {

/// Stiff: PBD, dp = -k' w grad C / sum w |grad C|^2 (Müller et al. 2006).
/// Compliant: XPBD, dlambda = (-C - alpha~ lambda) / (sum w |grad C|^2 + alpha~) (Macklin, Müller, Chentanez 2016).
/// Material: the same with a compliance of each constraint's own, alpha~ times the last of its rest values.
/// In all of them particles go along grad C where the substep began, x, and a product grad C(p) . grad C(x) stands in
/// place of the square (SHAKE: Ryckaert, Ciccotti, Berendsen 1977): second order in the substep, and the moments of
/// what is applied are 0 about wherever the body was, converged or not. Where the gradient has turned too far since,
/// they go along that at p, and partly where a constraint carries much (kernels/projection/direction.h).
enum class Update { Stiff, Compliant, Material };

/// Whether a kind's constraints can have compliances of their own: Update::Material.
template <class Kind>
KERNEL constexpr bool takes_material() {
  return Kind::strength.modulus != nullptr && (Kind::strength.free || facts_of(Kind::element).weighed);
}

/// How many rest values a constraint has.
template <class Kind>
KERNEL constexpr int rest_numbers(Update update) {
  return Kind::numbers + (update == Update::Material ? 1 : 0);
}

/// How many multipliers a constraint has: one, or as many as a kind says that has a step of its own for them.
template <class Kind>
KERNEL constexpr int multipliers() {
  if constexpr (requires { Kind::multipliers; })
    return Kind::multipliers;
  else
    return 1;
}

/// A projection is linear: it follows the gradient straight on. Where the gradient does not turn on the way to C = 0 (a
/// length along its line, a fold's vector, a spring to a point) a kind has nothing to say. Where it turns by its own
/// size (an angle) the kind declares how far is too far,
///   static constexpr int per_reach = 1;
/// the place among its rest values of 1 / reach, 1/m: no particle goes farther than its reach in one projection. What
/// is left over stays in C, and XPBD's multiplier holds what was applied, so that a later projection takes it and a
/// balance is where it was. All particles go by the same share of their ways: momenta are kept. Within reach nothing
/// changes, to the bit. Without it stiff angles on meshes of unequal heights gain energy without bound. (Volumes need
/// none: from flattened, inverted and random starts they give back what meeting them gave once. neo_hookean's own
/// step() does not overshoot. What pressure does at a particle has a bound of its own: kernels/forces/pressure.h.)
template <class Kind>
KERNEL constexpr bool has_reach() {
  return requires { Kind::per_reach; };
}
/// The part of the size at rest by which a particle may be moved in one projection: about a twentieth. No multiple of a
/// grid's spacing is half way between two numbers of 8 bits.
inline constexpr double kReach = 3.14159265358979323846 / 64;

/// a to 8 bits: the same for all of a grid, whose places are rounded, so that it is stored once.
template <class S>
KERNEL S round_to_8_bits(const S& a) {
  const S far = a * S(typename RealOf<S>::type(1.0 + (1LL << (sizeof(typename RealOf<S>::type) == 4 ? 16 : 45))));
  return far - (far - a);
}

/// 1 / reach of what is so large at rest (m); 0, no bound, of what has no size.
template <class S>
KERNEL S per_reach_of(const S& size) {
  using R = typename RealOf<S>::type;
  const S zero(R(0)), one(R(1));
  const auto some = size > S(tiny<R>());
  return select(some, round_to_8_bits(one / (S(R(kReach)) * select(some, size, one))), zero);
}

/// The numbers of a set. Lambda is by slot, and so are rest values within a batch; padding has none (NaN).
template <class R>
struct SetView {
  int kind;       // its number among the kinds of a sweep
  Update update;  // how its constraints are met
  int numbers;    // rest values of a constraint
  const LocalIndex* index[kMostParticles];
  const R* rest;                // of every 16 slots the first values, then the second ones, ...
  const R* common;              // of batches where they are all alike
  const unsigned short* valid;  // there, a bit a slot
  R* lambda;                    // with compliance: accumulated over the projections of a substep
  R stiffness;                  // Stiff: k'
  R compliance;                 // otherwise: alpha~ = alpha / dt^2
  bool from_start;              // whether directions are those where the substep began
  R taut;                       // see kTaut (kernels/projection/direction.h)
};

/// The rest values of a pack. Where a lane holds no constraint (padding) every kind answers with a zero gradient: in a
/// run it reads and writes particles of other constraints, finite or not.
template <class S, int numbers>
struct RestOf {
  S value[numbers];
  decltype(S() == S()) valid;
};

/// Where a pack's particles were and are, from the first one's places: differences of what is stored, nearly exact.
template <class S, int n>
struct Places {
  Vector3<S> x[n], p[n];
  /// Not `from_start`: as if the substep began where they are.
  KERNEL Places(const Moving<S> (&q)[n], bool from_start) {
    const S zero(typename RealOf<S>::type(0));
    x[0] = p[0] = {zero, zero, zero};
    for (int j = 1; j < n; ++j) x[j] = q[j].x - q[0].x, p[j] = x[j] + (q[j].d - q[0].d);
    if (!from_start)
      for (int j = 1; j < n; ++j) x[j] = p[j];
  }
};

/// A gradient along a vector of any length, such as a fold's, turns on ways however short, and so does that of an angle
/// whose triangles are crushed. What is across it would stay unmet. The kind says by which cosine it may turn:
///   static constexpr double turns = 0.97;
template <class Kind>
KERNEL constexpr bool gradient_turns() {
  return requires { Kind::turns; };
}

/// What one projection does to the particles of a pack: d += w grad dlambda.
template <class Kind, Update update, class R>
struct Correct {
  static constexpr int n = Kind::particles;
  static constexpr int numbers = rest_numbers<Kind>(update);
  R* lambda;             // from the batch's first slot on
  R number;              // k' or alpha~
  bool first_iteration;  // first projection of a substep: lambda is 0
  bool from_start;
  R taut;

  KERNEL Correct(const SetView<R>& set, int slot, bool first)
      : lambda(set.lambda + slot * multipliers<Kind>()),
        number(update == Update::Stiff ? set.stiffness : set.compliance),
        first_iteration(first),
        from_start(set.from_start),
        taut(set.taut) {}

  /// C and its gradient come scaled by s > 0, which PBD's update does not notice: XPBD's multiplier is s dlambda.
  template <class S>
  KERNEL void operator()(Moving<S> (&q)[n], const RestOf<S, numbers>& rest, int at) const {
    const Places<S, n> places(q, from_start);
    if constexpr (multipliers<Kind>() > 1)
      step(q, places, rest, at);
    else
      meet(q, places, rest, at);
  }

 private:
  template <class S>
  KERNEL void meet(Moving<S> (&q)[n], const Places<S, n>& places, const RestOf<S, numbers>& rest, int at) const {
    Vector3<S> grad[n], along[n];
    S s, s_along, w[n];
    for (int j = 0; j < n; ++j) w[j] = q[j].w;
    const S C = Kind::evaluate(places.p, rest.value, rest.valid, grad, s);
    Kind::evaluate(places.x, rest.value, rest.valid, along, s_along);
    const S zero(R(0)), one(R(1)), cross = product(w, grad, along);
    // applied / per times `along` is what this correction and those before it in the substep take particles to.
    S alpha = zero, total = zero, wanted = -C, per = cross, applied;
    if constexpr (update == Update::Stiff) {
      wanted = wanted * S(number), applied = abs(wanted);
    } else {
      alpha = S(number);
      if constexpr (update == Update::Material) alpha = alpha * rest.value[Kind::numbers];
      if (!first_iteration) load(lambda + at, total);
      wanted = wanted - s * alpha * total, per = cross + alpha * s * s_along;
      applied = abs(wanted) * s_along + abs(total) * per, per = per * s_along;
    }
    auto near = cross > zero;
    if constexpr (gradient_turns<Kind>()) near = near & has_hardly_turned(Kind::turns, w, grad, along, cross);
    const auto whole = near & goes_within(S(taut), applied, per, w, along, places.x);
    S sum = cross;
    if ((movemask(rest.valid) & ~movemask(whole)) != 0) {  // seldom: a branch costs less than what it leaves out
      // A lane's bits do not hang on the other lanes: those that go all along the start stay as they are.
      const S share = share_within(S(taut), applied, per, w, along, places.x), other = one - share;
      const S now = product(w, grad, grad);
      sum = select(whole, cross, select(near, cross * share + now * other, now));
      s_along = select(whole, s_along, select(near, s_along * share + s * other, s));
      for (int j = 0; j < n; ++j)
        along[j] = either(whole, along[j], either(near, along[j] * share + grad[j] * other, grad[j]));
    }
    S way2 = S(R(0));
    if constexpr (has_reach<Kind>()) way2 = most_way2(w, along);
    // Over `against(wanted, all)` what is wanted of dlambda takes no particle beyond its reach. (NaN, padding: all.)
    const auto against = [&](const S& all) KERNEL_LAMBDA {
      if constexpr (has_reach<Kind>())
        return max(max(wanted, -wanted) * (sqrt(way2) * rest.value[Kind::per_reach]), all);
      else
        return all;
    };

    // No gradient, no movable particle, or padding: skip, never NaN. So are those whose movable particles have a
    // gradient of rounding alone, such as the free corner of a hinge with pins in a line.
    auto moves = sum > S(tiny<R>());
    if constexpr (n > 2) moves = moves & is_told(sum, w, along);
    S dlambda;
    if constexpr (update == Update::Stiff) {
      dlambda = select(moves, wanted / against(sum), zero);
      if constexpr (Kind::inequality) dlambda = max(dlambda, zero);
    } else {
      dlambda = wanted / against(select(moves, sum + alpha * s * s_along, one));
      if constexpr (Kind::inequality) dlambda = max(dlambda, -total / select(moves, s_along, one));
      dlambda = select(moves, dlambda, zero);
      store(total + s_along * dlambda, lambda + at);
    }
    for (int j = 0; j < n; ++j) q[j].d = q[j].d + along[j] * (w[j] * dlambda);
  }

  /// The kind's own, of all its multipliers at once; of every 16 slots the first ones, then the second ones, ...
  template <class S>
  KERNEL void step(Moving<S> (&q)[n], const Places<S, n>& places, const RestOf<S, numbers>& rest, int at) const {
    constexpr int m = multipliers<Kind>();
    R* const sums = lambda + at / kSlotPack * kSlotPack * m + at % kSlotPack;
    S sum[m], w[n];
    for (int j = 0; j < n; ++j) w[j] = q[j].w;
    for (int k = 0; k < m; ++k) {
      sum[k] = S(R(0));
      if (!first_iteration) load(sums + k * kSlotPack, sum[k]);
    }
    Vector3<S> move[n];
    S alpha(update == Update::Stiff ? R(0) : number);
    if constexpr (update == Update::Material) alpha = alpha * rest.value[Kind::numbers];
    Kind::step(places.p, places.x, w, rest.value, rest.valid, alpha, S(taut), sum, move);
    for (int k = 0; k < m; ++k) store(sum[k], sums + k * kSlotPack);
    for (int j = 0; j < n; ++j) q[j].d = q[j].d + move[j] * w[j];
  }
};

/// The rest values of a batch, from its first slot on: those of each slot,
template <class R, int numbers>
struct RestOfEach {
  const R* rest;
  template <class S>
  KERNEL RestOf<S, numbers> read(int at) const {
    RestOf<S, numbers> of;
    const R* from = rest + at / kSlotPack * kSlotPack * numbers + at % kSlotPack;
    for (int k = 0; k < numbers; ++k) load(from + k * kSlotPack, of.value[k]);
    of.valid = of.value[0] == of.value[0];
    return of;
  }
};
/// or the same for all that are not padding, as in a grid: a 32nd of the memory.
template <class R, int numbers>
struct RestOfAll {
  R rest[numbers];
  const unsigned short* valid;
  KERNEL RestOfAll(const R* common, const unsigned short* bits) : valid(bits) {
    for (int k = 0; k < numbers; ++k) rest[k] = common[k];
  }
  template <class S>
  KERNEL RestOf<S, numbers> read(int at) const {
    RestOf<S, numbers> of;
    for (int k = 0; k < numbers; ++k) of.value[k] = S(rest[k]);
    of.valid = mask_from_bits<S>(valid[at / kSlotPack] >> at % kSlotPack);
    return of;
  }
};

/// Projects the packs of a run in a patch's memory.
template <class Kind, Update update, class R, class Isa, class Local, class Rest>
struct ProjectRun {
  static constexpr int n = Kind::particles;
  static constexpr int lanes = kLanes<R, Isa>;
  using S = Lane<R, Isa>;
  Correct<Kind, update, R> correct;
  Rest rest;
  Local end[n];  // the memory from where each end begins

  KERNEL void operator()(int pack) const {
    const int first = pack * lanes;
    Moving<S> q[n];
    for (int j = 0; j < n; ++j) end[j].read(first, q[j]);
    correct(q, rest.template read<S>(first), first);
    for (int j = 0; j < n; ++j) end[j].write(first, q[j].d);
  }
};

/// Projects the packs of a gathered batch without pins.
template <class Kind, Update update, class R, class Isa, class Local>
struct ProjectGathered {
  static constexpr int n = Kind::particles;
  static constexpr int lanes = kLanes<R, Isa>;
  using S = Lane<R, Isa>;
  struct Ends {
    Moving<S> q[n];
  };
  Local local;
  Correct<Kind, update, R> correct;
  RestOfEach<R, rest_numbers<Kind>(update)> rest;
  const LocalIndex* index[n];

  // Addresses are cheaper computed again than kept: there are more than registers.
  KERNEL Ends read(int pack) const {
    Ends ends;
    for (int j = 0; j < n; ++j) local.gather(unknown(index[j]) + pack * lanes, ends.q[j]);
    return ends;
  }
  KERNEL void compute(int pack, Ends& ends) const {
    correct(ends.q, rest.template read<S>(pack * lanes), pack * lanes);
  }
  KERNEL void write(int pack, const Ends& ends) const {
    for (int j = 0; j < n; ++j) local.scatter(unknown(index[j]) + pack * lanes, ends.q[j].d);
  }
};

/// Projects the packs of one with pins: of its `count` constraints only the movable particles (w > 0) are written back,
/// because pinned ones may be shared.
template <class Kind, Update update, class R, class Isa, class Local>
struct ProjectCarefully {
  using Kernel = ProjectGathered<Kind, update, R, Isa, Local>;
  Kernel kernel;
  int count;

  KERNEL void operator()(int pack) const {
    typename Kernel::Ends ends = kernel.read(pack);
    kernel.compute(pack, ends);
    const int first = pack * Kernel::lanes, last = count - first < Kernel::lanes ? count - first : Kernel::lanes;
    for (int j = 0; j < Kernel::n; ++j)
      for (int i = 0; i < last; ++i) {
        const Moving<typename Kernel::S>& q = ends.q[j];
        if (lane(q.w, i) > R(0))
          kernel.local.write(kernel.index[j][first + i] / kIndexScale<R>,
                             Vector3<R>{lane(q.d.x, i), lane(q.d.y, i), lane(q.d.z, i)});
      }
  }
};

/// Projects one batch of a patch.
template <class Kind, Update update, class R, class Group, class Local>
KERNEL void project(const Group& group, const Local& local, const SetView<R>& set, const Batch& batch,
                    bool first_iteration) {
  using Isa = typename Group::Isa;
  constexpr int n = Kind::particles, lanes = kLanes<R, Isa>, numbers = rest_numbers<Kind>(update);
  const int packs = (batch.count + lanes - 1) / lanes;
  const Correct<Kind, update, R> correct(set, batch.slot, first_iteration);
  if constexpr (Local::side_by_side) {
    const auto project_run = [&]<class Rest>(const Rest& rest) KERNEL_LAMBDA {
      ProjectRun<Kind, update, R, Isa, Local, Rest> kernel{correct, rest, {}};
      for (int j = 0; j < n; ++j) kernel.end[j] = local.from(batch.from[j]);
      group.for_each(packs, kernel);
    };
    if (batch.uniform_rest)
      return project_run(RestOfAll<R, numbers>(set.common + batch.common, set.valid + batch.rests));
    if (batch.run) return project_run(RestOfEach<R, numbers>{set.rest + batch.rests});
  }
  ProjectGathered<Kind, update, R, Isa, Local> kernel{local, correct, {set.rest + batch.rests}, {}};
  for (int j = 0; j < n; ++j) kernel.index[j] = set.index[j] + batch.index;
  if constexpr (!Local::side_by_side) {
    if (!batch.pins) return group.for_each_ahead(packs, kernel);
  }
  group.for_each(packs, ProjectCarefully<Kind, update, R, Isa, Local>{kernel, batch.count});
}

}  // namespace malha
