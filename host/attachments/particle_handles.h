// SPDX-License-Identifier: Apache-2.0
// Particles that are taken by hand: on springs to points, or held. Made only for simulations that allow it.
#pragma once
#include <algorithm>
#include <cmath>
#include <deque>
#include <string>
#include <vector>

#include "host/base/array.h"
#include "host/mesh/vectors.h"
#include "host/model/model.h"
#include "kernels/attachments/attachment.h"
#include "malha/error.h"
#include "malha/particle_handle.h"
#include "malha/text.h"

namespace malha {

template <class Executor, class R>
class ParticleHandles {
 public:
  ParticleHandles(const Executor& executor, const Model& model)
      : executor_(executor),
        substeps_(model.scene.solver.substeps),
        h_(model.scene.solver.dt / substeps_),
        remembers_(model.scene.solver.iterations > 1),
        origin_(1, Vector3<double>{0, 0, 0}) {}

  bool empty() const { return all_.empty(); }
  std::vector<ParticleHandle> taken() const {
    std::vector<ParticleHandle> list;
    for (const One& one : all_) list.push_back(one.taken);
    return list;
  }
  /// The solver's numbers.
  std::vector<int> particles() const {
    std::vector<int> list;
    for (const One& one : all_) list.push_back(one.particle);
    return list;
  }
  bool has(int particle) const { return find(particle) != all_.end(); }

  /// The solver's number of what is to be taken. `laid_out`: what of the solver knows beforehand what is pinned; null:
  /// nothing. Throws InputError for a particle that is not there or that is pinned, a place that is no number, a
  /// compliance that no spring has, and for what cannot be held.
  int number_of(const ParticleHandle& taken, const Model& model, const R* w, const char* laid_out) const {
    const auto require = [&taken](bool good, const std::string& found, const std::string& allowed) {
      if (!good)
        throw InputError((taken.is_held() ? "hold: found " : "pull: found ") + found + "; allowed: " + allowed);
    };
    require(taken.particle >= 0 && taken.particle < model.count(), "particle " + std::to_string(taken.particle),
            "0 to " + std::to_string(model.count() - 1));
    for (const double number : taken.to)
      require(std::abs(number) <= 1e18, "a place at " + shown(number), "numbers up to 1e18");
    const double alpha = taken.compliance;
    require(taken.is_held() || (alpha >= 1e-12 && alpha <= 1e12), "compliance " + shown(alpha), "1e-12 to 1e12 m/N");
    const auto found = std::find(model.user_index.begin(), model.user_index.end(), taken.particle);
    const int i = static_cast<int>(found - model.user_index.begin());
    R own{};
    Memory<Executor>::copy_out(w + i, 1, &own);
    require(own > R(0) || has(i), particle_name(model, taken.particle) + ", which is pinned", "one that is free");
    require(!taken.is_held() || !laid_out, std::string("a solver with ") + (laid_out ? laid_out : ""), "to pull");
    return i;
  }

  /// Particle i, which is at x (m), and has 1/w of mass as long as nothing holds it. Again: to another place.
  void take(int i, const ParticleHandle& taken, const Vec3& x, R* w) {
    release(i, w);
    One& one = all_.emplace_back();
    one.taken = taken, one.particle = i, one.from = x;
    one.list = Array<Executor, int>(1, i);
    Memory<Executor>::copy_out(w + i, 1, &one.w);
    if (taken.is_held())
      set(w + i, R(0));
    else if (remembers_)
      one.lambda = Array<Executor, Vector3<R>>(1, Vector3<R>{R(0), R(0), R(0)});
  }
  void release(int i, R* w) {
    const auto found = find(i);
    if (found == all_.end()) return;
    set(w + i, found->w);
    all_.erase(found);
  }
  void release_all(R* w) {
    for (const One& one : all_) set(w + one.particle, one.w);
    all_.clear();
  }

  /// What is held goes to its place in the course of a step. At the start of a substep, counted from 0;
  void place(const Particles<R>& particles, int substep) const {
    for (const One& one : all_)
      if (one.taken.is_held())
        parallel_for(executor_, 1,
                     MoveToTarget<R>{particles, one.list.data(), origin_.data(), shifted(one.at(substep + 1, substeps_))});
  }
  /// and at its end.
  void arrive(const Particles<R>& particles, int substep) {
    for (One& one : all_) {
      if (!one.taken.is_held()) continue;
      parallel_for(executor_, 1,
                   ArriveAtTarget<R>{particles, one.list.data(), origin_.data(), shifted(one.at(substep, substeps_)),
                             shifted(one.at(substep + 1, substeps_)), 1 / h_});
      if (substep + 1 == substeps_) one.from = one.taken.to;
    }
  }

  void project(const Displaced<R>& p, const R* w, bool first_iteration) const {
    for (const One& one : all_)
      if (!one.taken.is_held())
        parallel_for(executor_, 1,
                     SolveAttachment<R>{p, w, one.list.data(), origin_.data(), shifted(one.taken.to), one.lambda.data(), R(1),
                               R(one.taken.compliance / (h_ * h_)), first_iteration});
  }

  /// J that a hand gives at the most where it takes particle i, which is at x (m), so from now on.
  double work(int i, const ParticleHandle& taken, const Vec3& x) const {
    const auto before = find(i);
    return std::max(0.0, energy(taken, x) - (before == all_.end() ? 0 : energy(before->taken, x)));
  }
  /// J in the springs.
  double energy(const std::vector<Vec3>& x) const {
    double sum = 0;
    for (const One& one : all_) sum += energy(one.taken, x[one.particle]);
    return sum;
  }

 private:
  struct One {
    ParticleHandle taken{};
    int particle = -1;  // the solver's number
    R w{};              // its own, 1/kg
    Vec3 from{};        // where it was before this step, m
    Array<Executor, int> list;
    Array<Executor, Vector3<R>> lambda;
    Vec3 at(int substep, int substeps) const {
      if (substep == substeps) return taken.to;
      const double part = double(substep) / substeps;
      Vec3 place;
      for (int k = 0; k < 3; ++k) place[k] = from[k] + (taken.to[k] - from[k]) * part;
      return place;
    }
  };

  static double energy(const ParticleHandle& taken, const Vec3& x) {
    return taken.is_held() ? 0 : squared_distance(x, taken.to) / (2 * taken.compliance);
  }
  auto find(int i) const {
    return std::find_if(all_.begin(), all_.end(), [i](const One& one) { return one.particle == i; });
  }
  static Pose shifted(const Vec3& to) {
    Pose pose;
    pose.t = {to[0], to[1], to[2]}, pose.moves = true;
    return pose;
  }
  static void set(R* at, R number) { Memory<Executor>::copy_in(&number, 1, at); }

  Executor executor_;
  int substeps_;
  double h_;  // s
  bool remembers_;
  Array<Executor, Vector3<double>> origin_;  // the place of each in a frame of its own
  std::deque<One> all_;
};

}  // namespace malha
