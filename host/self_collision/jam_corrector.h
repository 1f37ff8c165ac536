// SPDX-License-Identifier: Apache-2.0
// Momenta of jammed bodies, whose displacements the final guard truncates: bodies that nothing holds get them back at
// the end of the substep; where pins or objects push a jam, nothing leaves it much faster than these.
#pragma once
#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include "host/base/array.h"
#include "host/model/ordering/particle_runs.h"
#include "host/model/self_surface.h"
#include "host/self_collision/rigid_momentum_fit.h"

namespace malha {

template <class Executor, class R>
class JamCorrector {
 public:
  JamCorrector(const Executor& executor, const SelfSurface& surface)
      : executor_(executor), count_(static_cast<int>(surface.body.size())) {
    std::vector<int> body = surface.sewn_body;  // of particles that take part
    for (int i = 0; i < count_; ++i)
      bodies_ = std::max(bodies_, body[i] + 1), body[i] = surface.takes_part[i] ? body[i] : -1;
    saved_motion_ = Array<Executor, Vec4<R>>(surface.body.size(), Vec4<R>{});
    const std::vector<ParticleRun> runs = particle_runs(body);
    runs_ = Array<Executor, ParticleRun>(runs);
    sums_ = Array<Executor, TruncationSums>(runs.size(), TruncationSums{});
    motions_ = Array<Executor, TruncatedMotion>(runs.size(), TruncatedMotion{});
    chosen_ = Array<Executor, int>(runs.size(), 0);
    for (const ParticleRun& run : runs) group_.push_back(run.group);
    changed_.reserve(static_cast<std::size_t>(bodies_)), choice_.reserve(runs.size());
  }

  void start_substep() { mode_ = Mode::None; }

  /// Saves the motion before the first truncation of a substep. `driven`: pins or objects act, so that momenta are not
  /// to be restored.
  void save_motion(const Particles<R>& particles, const Trajectories<R>& motions, bool driven) {
    if (mode_ == Mode::None) {
      parallel_for(executor_, count_, SaveMotion<R>{particles.v, motions, saved_motion_.data()}, kGrain);
      mode_ = Mode::RestoreMomenta;
    }
    if (driven) mode_ = Mode::LimitSpeed;
  }
  bool restores_momenta() const { return mode_ == Mode::RestoreMomenta; }

  /// Mean motion of the bodies with Truncating particles, m; 0 where it would round positions by more than
  /// `max_rounding` (m), far from the origin.
  Vector3<double> motion_of_truncated(const Trajectories<R>& motions, const MotionState* states, double max_rounding) {
    parallel_for(executor_, runs(), SumTruncatedMotion<R>{motions, states, runs_.data(), motions_.data()}, 1);
    TruncatedMotion all;
    for (const TruncatedMotion& one : motions_.on_host(staged_motions_))
      all.mean += one.mean, all.farthest = std::max(all.farthest, one.farthest);
    const bool fine = all.farthest * std::numeric_limits<R>::epsilon() < max_rounding;
    return fine ? all.mean.value() : Vector3<double>{0, 0, 0};
  }

  /// Computes how truncation has changed the displacements; call it before velocities are derived from them. `lifts`: a
  /// mesh may have lifted particles that were truncated afterwards; the way back gives them no velocity.
  void note_truncation(const Particles<R>& particles, const Trajectories<R>& motions, bool lifts) {
    if (mode_ == Mode::None) return;  // nothing was truncated
    if (lifts) parallel_for(executor_, count_, RemoveUndoneLift<R>{particles, motions}, kGrain);
    parallel_for(executor_, count_, ComputeTruncationChange<R>{particles.p, motions, saved_motion_.data()}, kGrain);
  }

  /// After a substep of h seconds: gives bodies with truncated particles back the momenta that truncation took, or
  /// limits the speed that kinematic particles (objects: at most `object_speed`, m/s) and the constraints strained by
  /// them would give these bodies.
  void end_substep(const Particles<R>& particles, const Trajectories<R>& motions, double h, double object_speed) {
    if (mode_ == Mode::None) return;
    parallel_for(executor_, runs(),
                 SumTruncation<R>{particles, motions, saved_motion_.data(), 1 / h, runs_.data(), sums_.data()}, 1);
    const std::span<const TruncationSums> sums = sums_.on_host(staged_sums_);
    changed_.assign(static_cast<std::size_t>(bodies_), 0), choice_.clear();
    for (std::size_t r = 0; r < sums.size(); ++r) changed_[group_[r]] |= sums[r].changed;
    TruncationSums all;
    double pins = 0;
    for (std::size_t r = 0; r < sums.size(); ++r) {
      choice_.push_back(changed_[group_[r]]);
      if (choice_.back()) all += sums[r];
      pins = std::max(pins, sums[r].pins);
    }
    chosen_.upload(choice_);
    if (mode_ == Mode::RestoreMomenta) {
      const AddRigidCorrection<R> add{particles, motions, runs_.data(), chosen_.data(), fit_rigid_momentum(all)};
      parallel_for(executor_, this->runs(), add, 1);
    } else if (const double max_speed = kMaxSpeedRatio * std::max(pins / h, object_speed); max_speed > 0) {
      const LimitSpeed<R> limit{particles, saved_motion_.data(), runs_.data(), chosen_.data(), max_speed};
      parallel_for(executor_, this->runs(), limit, 1);
    }
  }

  std::size_t bytes() const {
    return saved_motion_.bytes() + runs_.bytes() + sums_.bytes() + motions_.bytes() + chosen_.bytes();
  }

 private:
  enum class Mode { None, RestoreMomenta, LimitSpeed };  // None: nothing was truncated
  static constexpr int kGrain = 8192;
  static constexpr double kMaxSpeedRatio = 2;  // times the speed of what pushes a jam, if nothing in it was faster

  int runs() const { return static_cast<int>(runs_.size()); }

  Executor executor_;
  int count_, bodies_ = 0;
  Mode mode_ = Mode::None;                 // in this substep
  Array<Executor, Vec4<R>> saved_motion_;  // see SaveMotion
  Array<Executor, ParticleRun> runs_;      // of particles that take part, body by body
  Array<Executor, TruncationSums> sums_;   // this and the following: of each run
  Array<Executor, TruncatedMotion> motions_;
  Array<Executor, int> chosen_;
  // Working memory of the host: the body of each run, whether each body is changed, chosen_, and sums of a device.
  std::vector<int> group_, changed_, choice_;
  std::vector<TruncationSums> staged_sums_;
  std::vector<TruncatedMotion> staged_motions_;
};

}  // namespace malha
