// SPDX-License-Identifier: Apache-2.0
// Projection of a batch of constraints, written once for every kind: gather, evaluate, PBD or XPBD update, scatter.
#pragma once
#include "kernels/projection/constraint_kind.h"
#include "kernels/projection/direction.h"
#include "kernels/projection/patch.h"
#include "kernels/projection/patch_memory.h"

namespace malha {

/// Stiff: PBD, dp = -k' C w grad C / sum w |grad C|^2 (Müller et al. 2006).
/// Compliant: XPBD, dlambda = (-C - alpha~ lambda) / (sum w |grad C|^2 + alpha~) (Macklin, Müller, Chentanez 2016).
/// Material: XPBD with a compliance for each constraint, alpha~ times the last of its rest values.
/// All of them move particles along grad C(x), the gradient at the start of the substep, and the product
/// grad C(p) . grad C(x) replaces the square (SHAKE: Ryckaert, Ciccotti, Berendsen 1977). This is second order in the
/// substep, and the corrections have no torque about the body's position then, converged or not. Where the gradient has
/// turned too far since, particles are moved along that at p, and partly so where a constraint's force is large
/// (kernels/projection/direction.h).
enum class Update { Stiff, Compliant, Material };

/// Tells whether constraints of a kind can have a compliance each, Update::Material: those of a mesh, on which a map
/// may multiply their stiffness.
template <class Kind>
KERNEL constexpr bool takes_material() {
  return !facts_of(Kind::element).sewn;
}

/// Tells whether they have no other update: those of a modulus whose elements have a weight each.
template <class Kind>
KERNEL constexpr bool needs_material() {
  return !Kind::strength.accepts_stiffness && facts_of(Kind::element).weighed;
}

/// Number of rest values of a constraint.
template <class Kind>
KERNEL constexpr int rest_value_count(Update update) {
  return Kind::rest_values + (update == Update::Material ? 1 : 0);
}

/// Number of multipliers of a constraint: one, or `multipliers` of a kind that has a step().
template <class Kind>
KERNEL constexpr int multipliers() {
  if constexpr (requires { Kind::multipliers; })
    return Kind::multipliers;
  else
    return 1;
}

/// Tells whether a kind bounds the step of a projection. A projection is linear: it moves particles in a straight line
/// along the gradient. A kind whose gradient keeps its direction up to C = 0 (a length along its line, a fold's vector,
/// a spring to a point) needs no bound. A kind whose gradient turns by its own size (an angle) declares one,
///   static constexpr int per_max_step = 1;
/// the index among its rest values of 1 / bound, 1/m: no particle moves farther than that in one projection. The rest
/// of the violation stays in C, and XPBD's multiplier has what was applied, so that a later projection corrects it and
/// equilibria stay where they are. All particles move by the same share of their corrections, which conserves momenta.
/// Within the bound nothing changes, to the bit. Without it stiff angles on meshes of unequal heights gain energy
/// without bound. (Volumes need none: from flattened, inverted and random starts they return the energy that the first
/// projection gave them. The step() of neo_hookean does not overshoot. Pressure has a bound of its own:
/// kernels/forces/pressure.h.)
template <class Kind>
KERNEL constexpr bool has_max_step() {
  return requires { Kind::per_max_step; };
}
/// The bound of a step over the element's size at rest, about a twentieth. 1 / bound is rounded to 8 bits, below. With
/// this value, no multiple of a grid's spacing gives a number that is half way between two numbers of 8 bits, where the
/// rounding errors of positions would decide which of the two is taken.
inline constexpr double kMaxStep = 3.14159265358979323846 / 64;

/// a rounded to 8 bits: the same for all elements of a grid in spite of rounded positions, so that it is stored once.
template <class S>
KERNEL S round_to_8_bits(const S& a) {
  const S split = a * S(typename RealOf<S>::type(1.0 + (1LL << (sizeof(typename RealOf<S>::type) == 4 ? 16 : 45))));
  return split - (split - a);
}

/// 1 / bound for an element of this size at rest (m); 0, no bound, for one without size.
template <class S>
KERNEL S per_max_step_of(const S& size) {
  using R = typename RealOf<S>::type;
  const S zero(0), one(1);
  const auto some = size > S(tiny<S>());
  return select(some, round_to_8_bits(one / (S(R(kMaxStep)) * select(some, size, one))), zero);
}

/// Tells whether the rest length of a kind, its first rest value, shrinks with time: kinds that declare
///   static constexpr bool closes = true;
/// are joints whose gap at the start closes.
template <class Kind>
KERNEL constexpr bool closes() {
  return requires { Kind::closes; };
}
/// The factor of the gap at a time (s), for a rate of closing in 1/s; 1 with a rate of 0.
template <class S>
KERNEL S closing_factor(S per_closing, S time) {
  return max(S(0), S(1) - per_closing * time);
}

/// The data of a constraint set. Multipliers are stored by slot, and rest values by slot within a batch; those of
/// padding are NaN.
template <class R>
struct SetView {
  int kind;         // index among the kinds of a sweep
  Update update;    // how its constraints are projected
  int rest_values;  // number of them, for each constraint
  const LocalIndex* index[kMostParticles];
  const R* rest;                // in blocks of 16 slots: the first values of the 16, their second values, ...
  const R* common;              // rest values of uniform batches
  const unsigned short* valid;  // of uniform batches, one bit for each slot: not padding
  R* lambda;                    // multipliers, accumulated over the projections of a substep; unused if stiff
  R stiffness;                  // Stiff: k'
  R compliance;                 // otherwise: alpha~ = alpha / dt^2
  bool from_start;              // whether directions are gradients at the start of the substep
  R max_start_step, max_compressed_start_step;  // see kernels/projection/direction.h
  R per_closing;                                // 1/s, of kinds that close
};

/// The rest values of a pack. In a lane without constraint (padding) every kind returns a zero gradient: in a run such
/// a lane loads and stores particles of other constraints, finite or not.
template <class S, int rest_values>
struct RestOf {
  S value[rest_values];
  decltype(S() == S()) valid;
};

/// Positions of a pack's particles at the start of the substep and now, relative to the first one: differences of
/// stored numbers, nearly exact.
template <class S, int n>
struct Places {
  Vector3<S> x[n], p[n];
  /// Without `from_start` the start is the current position.
  KERNEL Places(const PatchParticle<S> (&q)[n], bool from_start) {
    const S zero(0);
    x[0] = p[0] = {zero, zero, zero};
    for (int j = 1; j < n; ++j) x[j] = q[j].x - q[0].x, p[j] = x[j] + (q[j].d - q[0].d);
    if (!from_start)
      for (int j = 1; j < n; ++j) x[j] = p[j];
  }
};

/// Tells whether a kind limits the angle between its gradients at the start of the substep and now. The gradient along
/// a vector of any length, such as a fold's, can turn in displacements however short, and so can that of an angle whose
/// triangles are crushed. A violation across the old gradient would never be corrected. The kind declares the cosine
/// of the largest angle:
///   static constexpr double min_turn_cosine = 0.97;
template <class Kind>
KERNEL constexpr bool limits_turn() {
  return requires { Kind::min_turn_cosine; };
}

/// The factor of the gap of kinds that close; other kinds have none.
template <class Kind, class R>
struct Closing {
  KERNEL Closing(const SetView<R>&, R) {}
  template <class Rest>
  KERNEL const Rest& apply(const Rest& rest) const {
    return rest;
  }
};
template <class Kind, class R>
requires(closes<Kind>()) struct Closing<Kind, R> {
  R factor;
  KERNEL Closing(const SetView<R>& set, R time) : factor(closing_factor(set.per_closing, time)) {}
  template <class Rest>
  KERNEL Rest apply(Rest rest) const {
    rest.value[0] = rest.value[0] * factor;
    return rest;
  }
};

/// One projection of a pack of constraints: d += w grad dlambda.
template <class Kind, Update update, class R>
struct ProjectPack : Closing<Kind, R> {
  static constexpr int n = Kind::particles;
  static constexpr int rest_values = rest_value_count<Kind>(update);
  R* lambda;             // from the batch's first slot on
  R k_or_alpha;          // k' or alpha~
  bool first_iteration;  // first projection of a substep: lambda is 0
  bool from_start;
  R max_start_step, max_compressed_start_step;

  KERNEL ProjectPack(const SetView<R>& set, int slot, bool first, R time)
      : Closing<Kind, R>(set, time),
        lambda(set.lambda + slot * multipliers<Kind>()),
        k_or_alpha(update == Update::Stiff ? set.stiffness : set.compliance),
        first_iteration(first),
        from_start(set.from_start),
        max_start_step(set.max_start_step),
        max_compressed_start_step(set.max_compressed_start_step) {}

  /// evaluate() scales C and its gradient by s > 0, which PBD does not notice. XPBD's multiplier grows by s dlambda.
  template <class S>
  KERNEL void operator()(PatchParticle<S> (&q)[n], const RestOf<S, rest_values>& at_start, int at) const {
    const Places<S, n> places(q, from_start);
    const auto& rest = this->apply(at_start);
    if constexpr (multipliers<Kind>() > 1)
      step(q, places, rest, at);
    else
      project_one(q, places, rest, at);
  }

 private:
  template <class S>
  KERNEL void project_one(PatchParticle<S> (&q)[n], const Places<S, n>& places, const RestOf<S, rest_values>& rest,
                          int at) const {
    Vector3<S> grad[n], along[n];
    S s, s_along, w[n];
    for (int j = 0; j < n; ++j) w[j] = q[j].w;
    const S C = Kind::evaluate(places.p, rest.value, rest.valid, grad, s);
    Kind::evaluate(places.x, rest.value, rest.valid, along, s_along);
    const S zero(0), one(1), grad_dot_along = weighted_dot(w, grad, along);
    // applied / denominator is an upper bound of the magnitude of the substep's total multiplier, this projection
    // included: times `along` it bounds the total correction.
    S alpha = zero, total = zero, wanted = -C, denominator = grad_dot_along, applied, multiplier;
    if constexpr (update == Update::Stiff) {
      wanted = wanted * S(k_or_alpha), applied = abs(wanted), multiplier = wanted;
    } else {
      alpha = S(k_or_alpha);
      if constexpr (update == Update::Material) alpha = alpha * rest.value[Kind::rest_values];
      if (!first_iteration) load(lambda + at, total);
      wanted = wanted - s * alpha * total, denominator = grad_dot_along + alpha * s * s_along;
      applied = abs(wanted) * s_along + abs(total) * denominator;
      multiplier = wanted * s_along + total * denominator, denominator = denominator * s_along;
    }
    auto near = grad_dot_along > zero;
    if constexpr (limits_turn<Kind>()) near = near & is_aligned(Kind::min_turn_cosine, w, grad, along, grad_dot_along);
    auto whole = near & moves_within(S(max_start_step), applied, denominator, w, along, places.x);
    S sum = grad_dot_along;
    if ((movemask(rest.valid) & ~movemask(whole)) != 0) {  // rare: the branch costs less than the work that it saves
      const S bound = start_step_bound(S(max_start_step), S(max_compressed_start_step), multiplier, along, places.x);
      if constexpr (n == 2) whole = near & moves_within(bound, applied, denominator, w, along, places.x);
      // A lane's bits do not depend on other lanes: those that go wholly along the old gradient stay as they are.
      const S share = share_within(bound, applied, denominator, w, along, places.x), other = one - share;
      const S now = weighted_dot(w, grad, grad);
      sum = select(whole, grad_dot_along, select(near, grad_dot_along * share + now * other, now));
      s_along = select(whole, s_along, select(near, s_along * share + s * other, s));
      for (int j = 0; j < n; ++j)
        along[j] = select_vector(whole, along[j], select_vector(near, along[j] * share + grad[j] * other, grad[j]));
    }
    S step2 = S(0);  // of a multiplier of 1
    if constexpr (has_max_step<Kind>()) step2 = max_displacement2(w, along);
    // Enlarges the denominator of dlambda = wanted / denominator until no particle moves farther than the kind's bound.
    // In padding the first argument of max() is NaN, so that max() returns the second.
    const auto bounded = [&](const S& unbounded) KERNEL_LAMBDA {
      if constexpr (has_max_step<Kind>())
        return max(max(wanted, -wanted) * (sqrt(step2) * rest.value[Kind::per_max_step]), unbounded);
      else
        return unbounded;
    };

    // Constraints without gradient or movable particle, and padding, are skipped, never NaN. So are constraints whose
    // movable particles have a gradient of rounding errors alone, such as the free corner of a hinge with collinear
    // pins.
    auto moves = sum > S(tiny<S>());
    if constexpr (n > 2) moves = moves & exceeds_rounding(sum, w, along);
    S dlambda;
    if constexpr (update == Update::Stiff) {
      dlambda = select(moves, wanted / bounded(sum), zero);
      if constexpr (Kind::inequality) dlambda = max(dlambda, zero);
    } else {
      dlambda = wanted / bounded(select(moves, sum + alpha * s * s_along, one));
      if constexpr (Kind::inequality) dlambda = max(dlambda, -total / select(moves, s_along, one));
      dlambda = select(moves, dlambda, zero);
      store(total + s_along * dlambda, lambda + at);
    }
    for (int j = 0; j < n; ++j) q[j].d = q[j].d + along[j] * (w[j] * dlambda);
  }

  /// The kind's step() for all its multipliers at once, which are stored as rest values are.
  template <class S>
  KERNEL void step(PatchParticle<S> (&q)[n], const Places<S, n>& places, const RestOf<S, rest_values>& rest,
                   int at) const {
    constexpr int m = multipliers<Kind>();
    R* const sums = lambda + at / kSlotPack * kSlotPack * m + at % kSlotPack;
    S sum[m], w[n];
    for (int j = 0; j < n; ++j) w[j] = q[j].w;
    for (int k = 0; k < m; ++k) {
      sum[k] = S(0);
      if (!first_iteration) load(sums + k * kSlotPack, sum[k]);
    }
    Vector3<S> move[n];
    S alpha(update == Update::Stiff ? R(0) : k_or_alpha);
    if constexpr (update == Update::Material) alpha = alpha * rest.value[Kind::rest_values];
    Kind::step(places.p, places.x, w, rest.value, rest.valid, alpha, S(max_start_step), sum, move);
    for (int k = 0; k < m; ++k) store(sum[k], sums + k * kSlotPack);
    for (int j = 0; j < n; ++j) q[j].d = q[j].d + move[j] * w[j];
  }
};

/// Rest values of a batch by slot.
template <class R, int rest_values>
struct RestOfEach {
  const R* rest;
  template <class S>
  KERNEL RestOf<S, rest_values> read(int at) const {
    RestOf<S, rest_values> of;
    const R* from = rest + at / kSlotPack * kSlotPack * rest_values + at % kSlotPack;
    for (int k = 0; k < rest_values; ++k) load(from + k * kSlotPack, of.value[k]);
    of.valid = of.value[0] == of.value[0];
    return of;
  }
};
/// Rest values of a uniform batch, such as a grid's, which all constraints share. A slot takes one bit of memory, which
/// tells whether it has a constraint, instead of a number of 32 bits.
template <class R, int rest_values>
struct RestOfAll {
  R rest[rest_values];
  const unsigned short* valid;
  KERNEL RestOfAll(const R* common, const unsigned short* bits) : valid(bits) {
    for (int k = 0; k < rest_values; ++k) rest[k] = common[k];
  }
  template <class S>
  KERNEL RestOf<S, rest_values> read(int at) const {
    RestOf<S, rest_values> of;
    for (int k = 0; k < rest_values; ++k) of.value[k] = S(rest[k]);
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
  ProjectPack<Kind, update, R> project_pack;
  Rest rest;
  Local end[n];  // memory from the first particle of each corner on

  KERNEL void operator()(int pack) const {
    const int first = pack * lanes;
    PatchParticle<S> q[n];
    for (int j = 0; j < n; ++j) end[j].load_particle(first, q[j]);
    project_pack(q, rest.template read<S>(first), first);
    for (int j = 0; j < n; ++j) end[j].store_displacement(first, q[j].d);
  }
};

/// Projects the packs of a gathered batch without pins.
template <class Kind, Update update, class R, class Isa, class Local>
struct ProjectGathered {
  static constexpr int n = Kind::particles;
  static constexpr int lanes = kLanes<R, Isa>;
  using S = Lane<R, Isa>;
  struct Corners {
    PatchParticle<S> q[n];
  };
  Local local;
  ProjectPack<Kind, update, R> project_pack;
  RestOfEach<R, rest_value_count<Kind>(update)> rest;
  const LocalIndex* index[n];

  // Addresses are cheaper to recompute than to keep: there are more of them than registers.
  KERNEL Corners read(int pack) const {
    Corners corners;
    for (int j = 0; j < n; ++j) local.gather(opaque(index[j]) + pack * lanes, corners.q[j]);
    return corners;
  }
  KERNEL void compute(int pack, Corners& corners) const {
    project_pack(corners.q, rest.template read<S>(pack * lanes), pack * lanes);
  }
  KERNEL void write(int pack, const Corners& corners) const {
    for (int j = 0; j < n; ++j) local.scatter(opaque(index[j]) + pack * lanes, corners.q[j].d);
  }
};

/// Projects the packs of a gathered batch with pins: only the movable particles (w > 0) of its `count` constraints are
/// stored, because constraints may share pinned ones.
template <class Kind, Update update, class R, class Isa, class Local>
struct ProjectWithPins {
  using Kernel = ProjectGathered<Kind, update, R, Isa, Local>;
  Kernel kernel;
  int count;

  KERNEL void operator()(int pack) const {
    typename Kernel::Corners corners = kernel.read(pack);
    kernel.compute(pack, corners);
    const int first = pack * Kernel::lanes, last = count - first < Kernel::lanes ? count - first : Kernel::lanes;
    for (int j = 0; j < Kernel::n; ++j)
      for (int i = 0; i < last; ++i) {
        const PatchParticle<typename Kernel::S>& q = corners.q[j];
        if (lane(q.w, i) > R(0))
          kernel.local.store_displacement(kernel.index[j][first + i] / kIndexScale<R>,
                                          Vector3<R>{lane(q.d.x, i), lane(q.d.y, i), lane(q.d.z, i)});
      }
  }
};

/// Projects one batch of a patch. `time`: that at the end of the substep (s), of kinds that close.
template <class Kind, Update update, class R, class Group, class Local>
KERNEL void project(const Group& group, const Local& local, const SetView<R>& set, const Batch& batch,
                    bool first_iteration, R time = R(0)) {
  using Isa = typename Group::Isa;
  constexpr int n = Kind::particles, lanes = kLanes<R, Isa>, rest_values = rest_value_count<Kind>(update);
  const int packs = (batch.count + lanes - 1) / lanes;
  const ProjectPack<Kind, update, R> project_pack(set, batch.slot, first_iteration, time);
  if constexpr (Local::is_soa) {
    const auto project_run = [&]<class Rest>(const Rest& rest) KERNEL_LAMBDA {
      ProjectRun<Kind, update, R, Isa, Local, Rest> kernel{project_pack, rest, {}};
      for (int j = 0; j < n; ++j) kernel.end[j] = local.from(batch.from[j]);
      group.for_each(packs, kernel);
    };
    if (batch.uniform_rest)
      return project_run(RestOfAll<R, rest_values>(set.common + batch.common, set.valid + batch.rests));
    if (batch.run) return project_run(RestOfEach<R, rest_values>{set.rest + batch.rests});
  }
  ProjectGathered<Kind, update, R, Isa, Local> kernel{local, project_pack, {set.rest + batch.rests}, {}};
  for (int j = 0; j < n; ++j) kernel.index[j] = set.index[j] + batch.index;
  if constexpr (!Local::is_soa) {
    if (!batch.pins) return group.for_each_ahead(packs, kernel);
  }
  group.for_each(packs, ProjectWithPins<Kind, update, R, Isa, Local>{kernel, batch.count});
}

}  // namespace malha
