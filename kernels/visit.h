// One visit to a patch: its particles come into fast memory, its batches are projected there, and the particles go
// back. Where nothing else happens between prediction and update, the visits do those too, and the predicted positions
// of particles that no other patch visits never leave the fast memory.
#pragma once
#include "kernels/constraint_registry.h"
#include "kernels/cover.h"
#include "kernels/motion.h"
#include "kernels/restrict.h"

namespace malha {

template <class Kind>
inline constexpr int kNumber = number_of<Kind>(ConstraintKinds{});

template <class R>
struct Visit {
  using Shared = void;
  const Patch* patches;
  const Segment* segments;
  const Batch* batches;
  const SetView<R>* sets;
  Particles<R> particles;
  R dt, per_dt;        // s, 1/s
  Vector3<R> gravity;  // m/s^2
  bool predicts;       // the first visit to a particle predicts it
  bool updates;        // the last one updates its state
  bool fresh;          // first iteration of a substep
  bool prefetches;     // the particles do not fit in a core's caches: those of the next patch are asked for early
  int substep;         // 1 ..
  R* kept;             // memories that patches keep from a substep's first iteration to its last, or null
  UpTo<R> up;          // means of the next prediction, for the coarser level: the last visits leave them
  MeansOf<R> down;     // what particles follow on the coarser level, patch by patch: added where they are predicted
  int* lost;           // of each patch: the first substep that left a particle without a finite position, or 0
  R most_speed2;       // m^2/s^2, where speeds are watched
  int* fast;           // of each patch: the last substep that left a particle that is faster; null: nobody asks

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    const Patch& patch = patches[group.index];
    R* memory = kept ? kept + size_t(4) * patch.kept : static_cast<R*>(group.memory);
    if (patch.columns)
      visit(group, patch, Columns<R>::over(memory, patch.slots));
    else
      visit(group, patch, Rows<R>::over(memory, patch.slots));
  }

 private:
  template <class Group, class Local>
  KERNEL void visit(const Group& group, const Patch& patch, const Local& local) const {
    const int begin = patch.segment, end = patch.segment + patch.segments;
    for (int s = begin; s < end; ++s)
      if (predicts || !at_home(segments[s])) bring(group, segments[s], local);
    if (predicts && down.means.begin) add_means(group, down, local);
    for (int b = 0; b < patch.batches;) {
      int next = b + 1;
      while (next < patch.batches && batches[patch.batch + next].set == batches[patch.batch + b].set) ++next;
      project_set(group, patch, b, next, local);
      b = next;
    }
    for (int s = begin; s < end; ++s) {
      if (!segments[s].movable || (!updates && at_home(segments[s]))) continue;
      if (updates && segments[s].last)
        update(group, segments[s], local);
      else
        put_back(group, segments[s], local);
    }
    if (updates && up.means.begin) foresee(group, patch, local);
    if (updates && fast) watch_speed(group, patch);
  }

  template <class Group>
  KERNEL void watch_speed(const Group& group, const Patch& patch) const {
    LargestCovered<R, typename Group::Isa> speed2(R(0));
    for (int s = patch.segment; s < patch.segment + patch.segments; ++s) {
      const Segment& segment = segments[s];
      if (!segment.last || !segment.movable) continue;
      cover<R>(group, segment.count, [&]<class T>(int i, T /*of*/) KERNEL_LAMBDA {
        const Vector3<T> v = load_points<T>(particles.v, segment.global + i);
        speed2.add(dot(v, v));
      });
    }
    if (speed2.value() > most_speed2) fast[group.index] = substep;
  }

  template <class Group, class Local>
  KERNEL void foresee(const Group& group, const Patch& patch, const Local& local) const {
    const Foreseen<R> next{particles.x, particles.v, particles.w, dt, gravity};
    for (int s = patch.segment; s < patch.segment + patch.segments; ++s)
      if (segments[s].last) next.bring(group, segments[s], local);
    restrict_to(group, up, local);
  }

  /// Whether the particles stay in the patch's memory from one iteration to the next: no other patch visits them.
  KERNEL bool at_home(const Segment& segment) const { return kept && segment.first && segment.last; }

  /// The `part` of `parts` of a patch's particles and constraints: memory is to be as busy as the arithmetic, not
  /// before it or after it.
  KERNEL void ask_for(const Patch& patch, int part, int parts) const {
    for (int s = patch.segments * part / parts; s < patch.segments * (part + 1) / parts; ++s)
      ask_for(segments[patch.segment + s]);
    for (int b = patch.batches * part / parts; b < patch.batches * (part + 1) / parts; ++b)
      ask_for(batches[patch.batch + b]);
  }
  template <class T>
  KERNEL static void ask_for(const T* first, int count) {
    for (int i = 0; i < count; i += 64 / int(sizeof(T))) prefetch(first + i);
  }
  KERNEL void ask_for(const Segment& segment) const {
    if (!predicts && at_home(segment)) return;
    const int at = segment.global, count = segment.count;
    ask_for(particles.w + at, count);
    const bool predict = predicts && segment.first;
    const Points<R>& q = predict ? particles.x : particles.p;
    ask_for(q.x + at, count), ask_for(q.y + at, count), ask_for(q.z + at, count);
    const Points<R>& v = particles.v;
    if (predict) ask_for(v.x + at, count), ask_for(v.y + at, count), ask_for(v.z + at, count);
  }
  KERNEL void ask_for(const Batch& batch) const {
    const SetView<R>& set = sets[batch.set];
    if (batch.alike)
      ask_for(set.held + batch.rests, batch.count / kSlotPack + 1);
    else
      ask_for(set.rest + batch.rests, batch.count * set.numbers);
  }

  template <class T>
  KERNEL Vector3<T> velocity(int i, const T& w) const {
    return accelerated(load_points<T>(particles.v, i), w, Vector3<T>{T(gravity.x), T(gravity.y), T(gravity.z)}, T(dt));
  }

  template <class Group, class Local>
  KERNEL void bring(const Group& group, const Segment& segment, const Local& local) const {
    const bool predict = predicts && segment.first;
    cover<R>(group, segment.count, [&]<class T>(int i, T w) KERNEL_LAMBDA {
      const int at = segment.global + i;
      load(particles.w + at, w);
      const Vector3<T> q = predict ? predicted(load_points<T>(particles.x, at), velocity(at, w), T(dt))
                                   : load_points<T>(particles.p, at);
      local.fill(segment.local + i, q, w);
    });
  }

  template <class Group, class Local>
  KERNEL void put_back(const Group& group, const Segment& segment, const Local& local) const {
    cover<R>(group, segment.count, [&]<class T>(int i, T w) KERNEL_LAMBDA {
      Vector3<T> q;
      local.read(segment.local + i, q, w);
      store_points(particles.p, segment.global + i, q);
    });
  }

  template <class Group, class Local>
  KERNEL void update(const Group& group, const Segment& segment, const Local& local) const {
    using Isa = typename Group::Isa;
    using S = Lane<R, Isa>;
    constexpr int lanes = kLanes<R, Isa>;
    if (lanes == 1 || segment.count < lanes) {
      R zero = R(0);
      group.for_each(segment.count, [&](int i) KERNEL_LAMBDA {
        const State<R> state = moved<R>(segment, i, local);
        zero = zero + zero_if_finite(state.x);
        keep(segment, i, state);
      });
      if (!(zero == R(0))) lose(group);
      return;
    }
    // A last part of a pack is covered by a whole one; what that one reads, it reads before it is overwritten.
    const int packs = segment.count / lanes, rest = segment.count - lanes;
    const State<S> last = moved<S>(segment, rest, local);
    S zero = zero_if_finite(last.x);
    group.for_each(packs, [&](int pack) KERNEL_LAMBDA {
      const State<S> state = moved<S>(segment, pack * lanes, local);
      zero = zero + zero_if_finite(state.x);
      keep(segment, pack * lanes, state);
    });
    if (packs * lanes < segment.count) keep(segment, rest, last);
    R sum = R(0);
    for (int i = 0; i < lanes; ++i) sum += lane(zero, i);
    if (!(sum == R(0))) lose(group);
  }

  template <class Group>
  KERNEL void lose(const Group& group) const {
    if (lost[group.index] == 0) lost[group.index] = substep;
  }

  template <class T>
  struct State {
    Vector3<T> x, v;
  };
  template <class T, class Local>
  KERNEL State<T> moved(const Segment& segment, int i, const Local& local) const {
    Vector3<T> p;
    T w;
    local.read(segment.local + i, p, w);
    const int at = segment.global + i;
    return {p, changed(load_points<T>(particles.x, at), velocity(at, w), p, T(dt), T(per_dt))};
  }
  template <class T>
  KERNEL void keep(const Segment& segment, int i, const State<T>& state) const {
    store_points(particles.x, segment.global + i, state.x);
    store_points(particles.v, segment.global + i, state.v);
  }

  /// The batches begin .. end - 1 of a patch, all of one set: on their own, as they need all registers.
  template <class Kind, Update update, class Group, class Local>
  struct ProjectSet {
    const Visit* visit;
    Group group;
    const Patch* patch;
    Local local;
    const SetView<R>* set;
    KERNEL void operator()(int b) const {
      if (visit->prefetches && group.next >= 0) visit->ask_for(visit->patches[group.next], b, patch->batches);
      project<Kind, update>(group, local, *set, visit->batches[patch->batch + b], visit->fresh);
    }
  };

  template <Update update>
  struct By {
    static constexpr Update value = update;
  };

  /// With the updates that a kind can have, and no others: each is code of its own.
  template <class Group, class Local>
  KERNEL_APART void project_set(const Group& group, const Patch& patch, int begin, int end, const Local& local) const {
    const SetView<R>& set = sets[batches[patch.batch + begin].set];
    for_each_constraint([&]<class Kind>(Kind) KERNEL_LAMBDA {
      if (set.kind != kNumber<Kind>) return;
      const auto by = [&]<class Updated>(Updated) KERNEL_LAMBDA {
        if (set.update == Updated::value)
          group.apart(begin, end, ProjectSet<Kind, Updated::value, Group, Local>{this, group, &patch, local, &set});
      };
      if constexpr (Kind::strength.free) by(By<Update::Stiff>()), by(By<Update::Compliant>());
      if constexpr (takes_material<Kind>())
        by(By<Update::Material>());
      else if constexpr (!Kind::strength.free)
        by(By<Update::Compliant>());
    });
  }
};

}  // namespace malha
