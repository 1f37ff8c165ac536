// SPDX-License-Identifier: Apache-2.0
// Particle handles of interactive simulations: particles on springs to points, or held at them.
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
        accumulates_(model.scene.solver.iterations > 1),
        origin_(1, Vector3<double>{0, 0, 0}) {}

  bool empty() const { return handles_.empty(); }
  std::vector<ParticleHandle> specs() const {
    std::vector<ParticleHandle> list;
    for (const Handle& handle : handles_) list.push_back(handle.spec);
    return list;
  }
  /// The solver's numbers of the particles with handles.
  std::vector<int> particles() const {
    std::vector<int> list;
    for (const Handle& handle : handles_) list.push_back(handle.particle);
    return list;
  }
  bool has(int particle) const { return find(particle) != handles_.end(); }

  /// The solver's number of a handle's particle. fixed_pins: name of the component that was built for a fixed set of
  /// pins, or null. Throws InputError for a particle that does not exist or is pinned, a position that is not finite,
  /// an invalid compliance, and for a held particle if pins are fixed.
  int number_of(const ParticleHandle& spec, const Model& model, const R* w, const char* fixed_pins) const {
    const auto require = [&spec](bool good, const std::string& found, const std::string& allowed) {
      if (!good) throw InputError((spec.is_held() ? "hold: found " : "pull: found ") + found + "; allowed: " + allowed);
    };
    require(spec.particle >= 0 && spec.particle < model.count(), "particle " + std::to_string(spec.particle),
            "0 to " + std::to_string(model.count() - 1));
    for (const double number : spec.to)
      require(std::abs(number) <= 1e18, "a place at " + shown(number), "numbers up to 1e18");
    const double alpha = spec.compliance;
    require(spec.is_held() || (alpha >= 1e-12 && alpha <= 1e12), "compliance " + shown(alpha), "1e-12 to 1e12 m/N");
    const auto found = std::ranges::find(model.user_index, spec.particle);
    const int i = static_cast<int>(found - model.user_index.begin());
    R inverse_mass{};
    Memory<Executor>::copy_out(w + i, 1, &inverse_mass);
    require(inverse_mass > R(0) || has(i), particle_name(model, spec.particle) + ", which is pinned",
            "one that is free");
    require(!spec.is_held() || !fixed_pins, std::string("a solver with ") + (fixed_pins ? fixed_pins : ""), "to pull");
    return i;
  }

  /// Sets the handle of particle i, which is at x (m); replaces an earlier one. A held particle has inverse mass 0
  /// until it is released.
  void add(int i, const ParticleHandle& spec, const Vec3& x, R* w) {
    release(i, w);
    Handle& handle = handles_.emplace_back();
    handle.spec = spec, handle.particle = i, handle.from = x;
    handle.list = Array<Executor, int>(1, i);
    Memory<Executor>::copy_out(w + i, 1, &handle.w);
    if (spec.is_held())
      set(w + i, R(0));
    else if (accumulates_)
      handle.lambda = Array<Executor, Vector3<R>>(1, Vector3<R>{R(0), R(0), R(0)});
  }
  void release(int i, R* w) {
    const auto found = find(i);
    if (found == handles_.end()) return;
    set(w + i, found->w);
    handles_.erase(found);
  }
  void release_all(R* w) {
    for (const Handle& handle : handles_) set(w + handle.particle, handle.w);
    handles_.clear();
  }

  /// Moves held particles at the start of a substep, counted from 0: they reach their targets in the course of a step.
  void move(const Particles<R>& particles, int substep) const {
    for (const Handle& handle : handles_)
      if (handle.spec.is_held())
        parallel_for(
            executor_, 1,
            MoveToTarget<R>{particles, handle.list.data(), origin_.data(), shifted(handle.at(substep + 1, substeps_))});
  }
  /// Sets positions and velocities of held particles at the end of a substep.
  void arrive(const Particles<R>& particles, int substep) {
    for (Handle& handle : handles_) {
      if (!handle.spec.is_held()) continue;
      parallel_for(executor_, 1,
                   ArriveAtTarget<R>{particles, handle.list.data(), origin_.data(), origin_.data(),
                                     shifted(handle.at(substep, substeps_)), shifted(handle.at(substep + 1, substeps_)),
                                     1 / h_});
      if (substep + 1 == substeps_) handle.from = handle.spec.to;
    }
  }

  void project(const Displaced<R>& p, const R* w, bool first_iteration) const {
    for (const Handle& handle : handles_)
      if (!handle.spec.is_held())
        parallel_for(
            executor_, 1,
            SolveAttachment<R>{p, w, handle.list.data(), origin_.data(), shifted(handle.spec.to), handle.lambda.data(),
                               R(1), R(handle.spec.compliance / (h_ * h_)), first_iteration});
  }

  /// Upper bound of the energy (J) that a new handle of particle i, which is at x (m), adds.
  double work(int i, const ParticleHandle& spec, const Vec3& x) const {
    const auto before = find(i);
    return std::max(0.0, energy(spec, x) - (before == handles_.end() ? 0 : energy(before->spec, x)));
  }
  /// Energy of the springs, J.
  double energy(const std::vector<Vec3>& x) const {
    double sum = 0;
    for (const Handle& handle : handles_) sum += energy(handle.spec, x[handle.particle]);
    return sum;
  }

 private:
  struct Handle {
    ParticleHandle spec{};
    int particle = -1;  // the solver's number
    R w{};              // without the handle, 1/kg
    Vec3 from{};        // position before this step, m
    Array<Executor, int> list;
    Array<Executor, Vector3<R>> lambda;
    Vec3 at(int substep, int substeps) const {
      if (substep == substeps) return spec.to;
      const double fraction = double(substep) / substeps;
      Vec3 position;
      for (int k = 0; k < 3; ++k) position[k] = from[k] + (spec.to[k] - from[k]) * fraction;
      return position;
    }
  };

  static double energy(const ParticleHandle& spec, const Vec3& x) {
    return spec.is_held() ? 0 : squared_distance(x, spec.to) / (2 * spec.compliance);
  }
  auto find(int i) const {
    return std::ranges::find_if(handles_, [i](const Handle& handle) { return handle.particle == i; });
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
  bool accumulates_;
  Array<Executor, Vector3<double>> origin_;  // every anchor is the origin of its own frame
  std::deque<Handle> handles_;
};

}  // namespace malha
