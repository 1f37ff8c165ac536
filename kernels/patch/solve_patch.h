// SPDX-License-Identifier: Apache-2.0
// Solves one patch: loads its particles into fast memory, projects its batches there, and stores the particles. Where
// no other pass lies between prediction and update, the solve does both as well, and displacements of particles that no
// other patch shares never leave the fast memory.
//
// An iteration is a symmetric Gauss-Seidel sweep: forward over all constraints and then backward, in the reverse order,
// with multipliers that are kept from one to the other. A forward sweep alone is not symmetric and adds energy to
// undamped motion, in whatever order it goes. A symmetric sweep does not, and neither do two symmetric sweeps one after
// the other. An iteration therefore is two of them, over the colours of patches. The first goes over all colours but
// the last, forward and backward; where it turns, at the last but one, a solve does both directions. The second one
// goes over the last colour alone, and a solve does both directions too. With one or two colours every patch is
// therefore solved once an iteration.
#pragma once
#include "kernels/constraints/constraint_registry.h"
#include "kernels/forces/integrate.h"
#include "kernels/multilevel/restrict.h"
#include "kernels/simd/for_each_pack.h"
#include "kernels/simd/particles.h"

namespace malha {

template <class Kind>
inline constexpr int kKindIndex = kind_index<Kind>(ConstraintKinds{});

/// The prediction of particles by their first solve in a substep.
template <class R>
struct PatchPrediction {
  Optional<ProlongationView<R>> correction;  // coarse correction, patch by patch, that is added to predicted particles
};

/// The first iteration of a substep: multipliers start at 0.
template <class R>
struct FirstIteration {
  Optional<PatchPrediction<R>> prediction;
};

/// A bound of the speed of particles.
template <class R>
struct SpeedLimit {
  R speed2;       // m^2/s^2
  int* exceeded;  // of each patch: the last substep that left a particle above it
};

/// The update of the state of particles by their last solve in a substep.
template <class R>
struct PatchUpdate {
  int substep;      // from 1 on
  int* non_finite;  // of each patch: the first substep that left a particle without a finite position, or 0
  Optional<RestrictionTarget<R>> restriction;  // particles of the coarser level, for their next prediction
  Optional<SpeedLimit<R>> speed_limit;
};

template <class R>
struct SolvePatch {
  using Shared = void;
  PatchData<R> data;
  Particles<R> particles;
  R dt, per_dt;                       // the substep h, s, and 1 / h
  Vector3<R> gravity;                 // m/s^2
  Optional<FirstIteration<R>> first;  // in a first iteration
  Optional<PatchUpdate<R>> update;    // in a last iteration that updates the state
  Sweeps sweeps;
  R time = R(0);      // s, at the end of the substep; of seams that close
  Points<R> force{};  // N, that a program has set and predictions apply; null: none

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    const Patch& patch = data.patches[group.index];
    with_patch_memory<R>(patch, group.memory, [&](const auto& local) KERNEL_LAMBDA { solve(group, patch, local); });
  }

 private:
  template <class Group, class Local>
  KERNEL void solve(const Group& group, const Patch& patch, const Local& local) const {
    const int begin = patch.segment, end = patch.segment + patch.segments;
    for (int s = begin; s < end; ++s) load_segment(group, data.segments[s], local);
    if (predicts() && first->prediction->correction) prolongate(group, *first->prediction->correction, local);
    if (goes_forward(sweeps))
      for (int b = 0, next; b < patch.batches; b = next) {
        for (next = b + 1; next < patch.batches && set_of(patch, next) == set_of(patch, b);) ++next;
        project_set(group, patch, b, next, true, local);
      }
    if (goes_backward(sweeps))
      for (int next = patch.batches, b; next > 0; next = b) {
        for (b = next - 1; b > 0 && set_of(patch, b - 1) == set_of(patch, b);) --b;
        project_set(group, patch, b, next, false, local);
      }
    for (int s = begin; s < end; ++s) {
      const Segment& segment = data.segments[s];
      if (!segment.movable) continue;
      if (updates() && segment.last_solve)
        update_segment(group, segment, local);
      else
        store_segment(group, segment, local);
    }
    if (updates() && update->restriction) restrict_prediction(group, patch, local);
    if (updates() && update->speed_limit) check_speed(group, patch);
  }

  KERNEL FreeFall<R> fall() const { return {particles.v, dt, gravity, force}; }

  /// Tell whether this solve predicts particles, and whether it updates their state: those that no other patch solves
  /// before it, or after it.
  KERNEL bool predicts() const { return first && first->prediction && goes_forward(sweeps); }
  KERNEL bool updates() const { return update && goes_backward(sweeps); }

  template <class Group>
  KERNEL void check_speed(const Group& group, const Patch& patch) const {
    PackMax<R, typename Group::Isa> speed2(R(0));
    for (int s = patch.segment; s < patch.segment + patch.segments; ++s) {
      const Segment& segment = data.segments[s];
      if (!segment.last_solve || !segment.movable) continue;
      for_each_pack<R>(group, segment.count, [&]<class T>(int i, T /*of*/) KERNEL_LAMBDA {
        const Vector3<T> v = load_points<T>(particles.v, segment.global + i);
        speed2.add(dot(v, v));
      });
    }
    const SpeedLimit<R>& limit = *update->speed_limit;
    if (speed2.value() > limit.speed2) limit.exceeded[group.index] = update->substep;
  }

  template <class Group, class Local>
  KERNEL void restrict_prediction(const Group& group, const Patch& patch, const Local& local) const {
    const RestrictedParticles<R> next{particles.p, particles.w, fall()};
    restrict_to(group, data, patch, next, *update->restriction, local);
  }

  KERNEL int set_of(const Patch& patch, int b) const { return data.batches[patch.batch + b].set; }

  /// Prefetches the `part` of `parts` of a patch's particles and constraints, so that memory transfers are spread over
  /// the arithmetic.
  KERNEL void prefetch_patch(const Patch& patch, int part, int parts) const {
    for (int s = patch.segments * part / parts; s < patch.segments * (part + 1) / parts; ++s)
      prefetch_patch(data.segments[patch.segment + s]);
    for (int b = patch.batches * part / parts; b < patch.batches * (part + 1) / parts; ++b)
      prefetch_patch(data.batches[patch.batch + b]);
  }
  template <class T>
  KERNEL static void prefetch_patch(const T* first, int count) {
    for (int i = 0; i < count; i += 64 / int(sizeof(T))) prefetch(first + i);
  }
  KERNEL void prefetch_patch(const Segment& segment) const {
    const int at = segment.global, count = segment.count;
    prefetch_patch(particles.w + at, count), prefetch_patch(particles.x, at, count);
    if constexpr (kCompensated<R>) prefetch_patch(particles.p.low, at, count);
    prefetch_patch(predicts() && segment.first_solve ? particles.v : particles.p.d, at, count);
  }
  KERNEL static void prefetch_patch(const Points<R>& points, int at, int count) {
    prefetch_patch(points.x + at, count), prefetch_patch(points.y + at, count), prefetch_patch(points.z + at, count);
  }
  KERNEL void prefetch_patch(const Batch& batch) const {
    const SetView<R>& set = data.sets[batch.set];
    if (batch.uniform_rest)
      prefetch_patch(set.valid + batch.rests, batch.count / kSlotPack + 1);
    else
      prefetch_patch(set.rest + batch.rests, batch.count * set.rest_values);
  }

  template <class T>
  KERNEL Vector3<T> velocity(int i, const T& w) const {
    return fall().velocity(i, w);
  }

  template <class Group, class Local>
  KERNEL void load_segment(const Group& group, const Segment& segment, const Local& local) const {
    const bool predict = predicts() && segment.first_solve && segment.movable;
    const Vector3<R> origin = particles.x[segment.origin];
    for_each_pack<R>(group, segment.count, [&]<class T>(int i, T) KERNEL_LAMBDA {
      const int at = segment.global + i;
      PatchParticle<T> q;
      load(particles.w + at, q.w);
      q.x = load_start(particles.p, at, origin, T());
      q.d = predict ? velocity(at, q.w) * T(dt) : load_points<T>(particles.p.d, at);
      local.store_particle(segment.local + i, q);
    });
  }

  template <class Group, class Local>
  KERNEL void store_segment(const Group& group, const Segment& segment, const Local& local) const {
    for_each_pack<R>(group, segment.count, [&]<class T>(int i, T) KERNEL_LAMBDA {
      store_points(particles.p.d, segment.global + i, local.template load_displacement<T>(segment.local + i));
    });
  }

  template <class Group, class Local>
  KERNEL void update_segment(const Group& group, const Segment& segment, const Local& local) const {
    using Isa = typename Group::Isa;
    using S = Lane<R, Isa>;
    constexpr int lanes = kLanes<R, Isa>;
    if (lanes == 1 || segment.count < lanes) {
      R zero = R(0);
      group.for_each(segment.count, [&](int i) KERNEL_LAMBDA {
        const State<R> state = new_state<R>(segment, i, local);
        zero = zero + zero_if_finite(state.x);
        store_state(segment, i, state);
      });
      if (!(zero == R(0))) mark_non_finite(group);
      return;
    }
    // The particles behind the last whole pack are updated by one more pack, which ends with the last particle and
    // overlaps the whole pack before it. It is computed first, because an update overwrites what it reads.
    const int packs = segment.count / lanes, rest = segment.count - lanes;
    const State<S> last = new_state<S>(segment, rest, local);
    S zero = zero_if_finite(last.x);
    group.for_each(packs, [&](int pack) KERNEL_LAMBDA {
      const State<S> state = new_state<S>(segment, pack * lanes, local);
      zero = zero + zero_if_finite(state.x);
      store_state(segment, pack * lanes, state);
    });
    if (packs * lanes < segment.count) store_state(segment, rest, last);
    R sum = R(0);
    for (int i = 0; i < lanes; ++i) sum += lane(zero, i);
    if (!(sum == R(0))) mark_non_finite(group);
  }

  template <class Group>
  KERNEL void mark_non_finite(const Group& group) const {
    int& substep = update->non_finite[group.index];
    if (substep == 0) substep = update->substep;
  }

  template <class T>
  struct State {
    Vector3<T> x, low, v;
  };
  template <class T, class Local>
  KERNEL State<T> new_state(const Segment& segment, int i, const Local& local) const {
    const Vector3<T> d = local.template load_displacement<T>(segment.local + i);
    const int at = segment.global + i;
    T w;
    load(particles.w + at, w);
    const Vector3<T> x = load_points<T>(particles.x, at);
    State<T> state;
    if constexpr (kCompensated<R>) {
      const Vector3<T> offset = d + load_points<T>(particles.p.low, at);
      state.x = x + offset, state.low = rounding_error(x, offset, state.x);
    } else {
      state.x = x + d;
    }
    state.v = velocity_from_positions(velocity(at, w), d, T(dt), T(per_dt));
    return state;
  }
  template <class T>
  KERNEL void store_state(const Segment& segment, int i, const State<T>& state) const {
    const int at = segment.global + i;
    store_points(particles.x, at, state.x), store_points(particles.v, at, state.v);
    if constexpr (kCompensated<R>) store_points(particles.p.low, at, state.low);
  }

  /// Projects the batches begin .. end - 1 of a patch, all of one set, in either order. It is compiled as a function of
  /// its own because it needs all registers.
  template <class Kind, Update by, class Group, class Local>
  struct ProjectSet {
    const SolvePatch* solve;
    Group group;
    const Patch* patch;
    Local local;
    const SetView<R>* set;
    int last;  // last batch of a backward sweep; below 0: forward
    KERNEL void operator()(int b) const {
      const bool forward = last < 0;
      const PatchData<R>& data = solve->data;
      if (data.prefetches && group.next >= 0 && (forward || !goes_forward(solve->sweeps)))
        solve->prefetch_patch(data.patches[group.next], b, patch->batches);
      const Batch& batch = data.batches[patch->batch + (forward ? b : last - b)];
      project<Kind, by>(group, local, *set, batch, solve->first && forward, solve->time);
    }
  };

  template <Update update>
  struct By {
    static constexpr Update value = update;
  };

  /// Instantiates only the updates that a kind can have.
  template <class Group, class Local>
  KERNEL_NOINLINE void project_set(const Group& group, const Patch& patch, int begin, int end, bool in_order,
                                   const Local& local) const {
    const SetView<R>& set = data.sets[set_of(patch, begin)];
    for_each_constraint([&]<class Kind>(Kind) KERNEL_LAMBDA {
      if constexpr (std::is_same_v<Kind, Projected<Kind>>) {
        if (set.kind != kKindIndex<Kind>) return;
        const auto by = [&]<class Updated>(Updated) KERNEL_LAMBDA {
          if (set.update == Updated::value)
            group.call_outlined(begin, end,
                                ProjectSet<Kind, Updated::value, Group, Local>{this, group, &patch, local, &set,
                                                                               in_order ? -1 : begin + end - 1});
        };
        if constexpr (Kind::strength.accepts_stiffness) by(By<Update::Stiff>());
        if constexpr (!needs_material<Kind>()) by(By<Update::Compliant>());
        if constexpr (takes_material<Kind>()) by(By<Update::Material>());
      }
    });
  }
};

}  // namespace malha
