// SPDX-License-Identifier: Apache-2.0
// User constraints in a solver: sorted into batches that share no particle, and projected.
#pragma once
#include <deque>
#include <vector>

#include "host/base/array.h"
#include "host/measure/solver_stats.h"
#include "host/model/model.h"
#include "host/model/ordering/index_map.h"
#include "kernels/parallel/compute.h"
#include "kernels/projection/user_constraint.h"
#include "malha/user_constraint.h"

namespace malha {

/// Batches of user constraints, which are sorted by them.
struct UserBatches {
  std::vector<int> begin;  // of each batch, and one more: the number of constraints
  std::vector<int> index;  // of each constraint, as the caller counts them
  std::vector<int> list;   // its particles, the solver's numbers, k a constraint
  int count() const { return static_cast<int>(begin.size()) - 1; }
};

/// Throws InputError for constraints that no model of so many particles can have.
void require_sound(const UserConstraint& constraint, int particles);

/// `solver_of`: the solver's number of each of the user's particles. Pinned particles count too, as pins may be
/// released.
UserBatches make_batches(const UserConstraint& constraint, const std::vector<int>& solver_of);

/// Calls the function, and throws InputError if its results are not finite.
void evaluate(const UserConstraint& constraint, const UserBatch& batch);

/// One projection of a batch in a substep of h seconds (XPBD, along the gradients at `start`:
/// kernels/projection/direction.h). `x`: its places (m), moved here; `start`: those where the substep began, `along`:
/// gradients there. `w`: inverse masses (1/kg), likewise k a constraint. `lambda`: of each constraint, 0 in a substep's
/// first iteration.
void project(const UserConstraint& constraint, int count, const int* number, double h, const double* w, double* lambda,
             const Vec3* start, const Vec3* along, Vec3* x);

template <class Executor, class R>
class UserConstraints {
 public:
  UserConstraints(const Executor& executor, const Model& model, const std::vector<UserConstraint>& all)
      : executor_(executor), h_(model.scene.solver.dt / model.scene.solver.substeps) {
    const std::vector<int> numbers = solver_of(model.user_index);
    for (const UserConstraint& one : all) {
      require_sound(one, model.count());
      Set& set = sets_.emplace_back();
      set.of = one, set.batches = make_batches(one, numbers);
      set.list = Array<Executor, int>(set.batches.list);
      set.place = Array<Executor, Vector3<double>>(set.batches.list.size(), Vector3<double>{0, 0, 0});
      set.w = Array<Executor, double>(set.batches.list.size(), 0.0);
      set.lambda.assign(set.batches.index.size(), 0);
    }
  }

  std::vector<UserConstraintStats> facts() const {
    std::vector<UserConstraintStats> all;
    for (const Set& set : sets_)
      all.push_back({set.of.name, static_cast<int>(set.batches.index.size()), set.of.arity, set.batches.count()});
    return all;
  }
  /// The solver's numbers.
  std::vector<int> particles() const {
    std::vector<int> all;
    for (const Set& set : sets_) all.insert(all.end(), set.batches.list.begin(), set.batches.list.end());
    return all;
  }

  /// One iteration: a forward and a backward sweep over all batches but the last, then that one. A batch is solved
  /// exactly by one projection, so that it is projected once where the sweeps turn.
  void project(const Displaced<R>& p, const R* w, bool first_iteration) {
    for (Set& set : sets_) {
      const int last = set.batches.count() - 1;
      if (first_iteration) start(set, p.x, w);
      for (int b = 0; b < last; ++b) project(set, b, p, w);
      for (int b = last - 2; b >= 0; --b) project(set, b, p, w);
      project(set, last, p, w);
    }
  }

  /// C of each constraint of a set, as the caller counts them.
  std::vector<double> values(std::size_t index, const Points<R>& x, const R* w) const {
    const Set& set = sets_.at(index);
    const int number = static_cast<int>(set.batches.index.size());
    const std::vector<Vec3> places = gather(set, x, w, 0, number * set.of.arity);
    std::vector<double> C(number, 0), sorted(number);
    std::vector<Vec3> gradient(places.size(), Vec3{0, 0, 0});
    evaluate(set.of, {number, places.data(), set.batches.index.data(), C.data(), gradient.data()});
    for (int c = 0; c < number; ++c) sorted[set.batches.index[c]] = C[c];
    return sorted;
  }

  /// J in those that have a compliance.
  double energy(const Points<R>& x, const R* w) const {
    double sum = 0;
    for (std::size_t s = 0; s < sets_.size(); ++s)
      if (const double alpha = sets_[s].of.compliance; alpha > 0)
        for (const double C : values(s, x, w)) sum += C * C / (2 * alpha);
    return sum;
  }

 private:
  struct Set {
    UserConstraint of;
    UserBatches batches;
    Array<Executor, int> list;
    Array<Executor, Vector3<double>> place;
    Array<Executor, double> w;
    std::vector<double> lambda;
    std::vector<Vec3> start, along;  // particles where the substep began (m), and gradients there
  };

  /// The constraints of batch b.
  struct Piece {
    int first, count;  // of its constraints
    std::size_t from;  // its first particle in the lists
    int particles;
    Piece(const Set& set, int b)
        : first(set.batches.begin[b]),
          count(set.batches.begin[b + 1] - first),
          from(static_cast<std::size_t>(first) * set.of.arity),
          particles(count * set.of.arity) {}
  };

  void start(Set& set, const Points<R>& x, const R* w) const {
    std::ranges::fill(set.lambda, 0.0);
    set.start = gather(set, x, w, 0, static_cast<int>(set.batches.list.size()));
    set.along.assign(set.start.size(), Vec3{0, 0, 0});
    std::vector<double> C(set.lambda.size(), 0);
    for (int b = 0; b < set.batches.count(); ++b) {
      const Piece of(set, b);
      evaluate(set.of,
               {of.count, &set.start[of.from], &set.batches.index[of.first], &C[of.first], &set.along[of.from]});
    }
  }

  void project(Set& set, int b, const Displaced<R>& p, const R* w) const {
    const Piece of(set, b);
    std::vector<Vec3> x = gather(set, p, w, of.from, of.particles);
    std::vector<double> own(of.particles);
    Memory<Executor>::copy_out(set.w.data() + of.from, own.size(), own.data());
    malha::project(set.of, of.count, &set.batches.index[of.first], h_, own.data(), &set.lambda[of.first],
                   &set.start[of.from], &set.along[of.from], x.data());
    std::vector<Vector3<double>> there;
    for (const Vec3& a : x) there.push_back({a[0], a[1], a[2]});
    Memory<Executor>::copy_in(there.data(), there.size(), set.place.data() + of.from);
    parallel_for(executor_, of.particles,
                 ScatterUserParticles<R>{p, w, set.list.data() + of.from, set.place.data() + of.from});
  }

  template <class At>
  std::vector<Vec3> gather(const Set& set, const At& x, const R* w, std::size_t from, int count) const {
    parallel_for(
        executor_, count,
        GatherUserParticles<R, At>{x, w, set.list.data() + from, set.place.data() + from, set.w.data() + from});
    std::vector<Vector3<double>> there(count);
    Memory<Executor>::copy_out(set.place.data() + from, there.size(), there.data());
    std::vector<Vec3> places;
    for (const Vector3<double>& a : there) places.push_back({a.x, a.y, a.z});
    return places;
  }

  Executor executor_;
  double h_;  // s
  std::deque<Set> sets_;
};

}  // namespace malha
