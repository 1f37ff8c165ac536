// Constraints of the caller's own in a solver. Made only for simulations that are given some.
#pragma once
#include <deque>
#include <vector>

#include "host/base/array.h"
#include "host/model/model.h"
#include "host/model/solver_of.h"
#include "host/solver/own_batches.h"
#include "host/solver/solver.h"
#include "host/solver/state.h"
#include "kernels/compute.h"
#include "kernels/own.h"

namespace malha {

template <class Executor, class R>
class OwnConstraints {
 public:
  OwnConstraints(const Executor& executor, const Model& model, const std::vector<OwnConstraint>& all)
      : executor_(executor), h_(model.scene.solver.dt / model.scene.solver.substeps) {
    const std::vector<int> numbers = solver_of(model.user_of);
    for (const OwnConstraint& one : all) {
      require_sound(one, model.count());
      Set& set = sets_.emplace_back();
      set.of = one, set.batches = make_batches(one, numbers);
      set.list = Array<Executor, int>(set.batches.list);
      set.place = Array<Executor, Vector3<double>>(set.batches.list.size(), Vector3<double>{0, 0, 0});
      set.w = Array<Executor, double>(set.batches.list.size(), 0.0);
      set.lambda.assign(set.batches.number.size(), 0);
    }
  }

  std::vector<OwnFacts> facts() const {
    std::vector<OwnFacts> all;
    for (const Set& set : sets_)
      all.push_back({set.of.name, static_cast<int>(set.batches.number.size()), set.of.arity, set.batches.count()});
    return all;
  }
  /// The solver's numbers.
  std::vector<int> particles() const {
    std::vector<int> all;
    for (const Set& set : sets_) all.insert(all.end(), set.batches.list.begin(), set.batches.list.end());
    return all;
  }

  void project(const Displaced<R>& p, const R* w, bool fresh) {
    for (Set& set : sets_) {
      if (fresh) std::fill(set.lambda.begin(), set.lambda.end(), 0.0);
      for (int b = 0; b < set.batches.count(); ++b) {
        const int first = set.batches.begin[b], number = set.batches.begin[b + 1] - first;
        const std::size_t from = static_cast<std::size_t>(first) * set.of.arity;
        const int particles = number * set.of.arity;
        const std::vector<Vec3> start = gather(set, p.x, w, from, particles);
        std::vector<Vec3> x = gather(set, p, w, from, particles);
        std::vector<double> own(particles);
        Memory<Executor>::copy_out(set.w.data() + from, own.size(), own.data());
        malha::project(set.of, number, &set.batches.number[first], h_, own.data(), &set.lambda[first], start.data(),
                       x.data());
        std::vector<Vector3<double>> there;
        for (const Vec3& a : x) there.push_back({a[0], a[1], a[2]});
        Memory<Executor>::copy_in(there.data(), there.size(), set.place.data() + from);
        parallel_for(executor_, particles, ScatterOwn<R>{p, w, set.list.data() + from, set.place.data() + from});
      }
    }
  }

  /// C of each constraint of a set, as the caller counts them.
  std::vector<double> values(std::size_t index, const Points<R>& x, const R* w) const {
    const Set& set = sets_.at(index);
    const int number = static_cast<int>(set.batches.number.size());
    const std::vector<Vec3> places = gather(set, x, w, 0, number * set.of.arity);
    std::vector<double> C(number, 0), sorted(number);
    std::vector<Vec3> gradient(places.size(), Vec3{0, 0, 0});
    evaluate(set.of, {number, places.data(), set.batches.number.data(), C.data(), gradient.data()});
    for (int c = 0; c < number; ++c) sorted[set.batches.number[c]] = C[c];
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
    OwnConstraint of;
    OwnBatches batches;
    Array<Executor, int> list;
    Array<Executor, Vector3<double>> place;
    Array<Executor, double> w;
    std::vector<double> lambda;
  };

  template <class At>
  std::vector<Vec3> gather(const Set& set, const At& x, const R* w, std::size_t from, int count) const {
    parallel_for(executor_, count,
                 GatherOwn<R, At>{x, w, set.list.data() + from, set.place.data() + from, set.w.data() + from});
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
