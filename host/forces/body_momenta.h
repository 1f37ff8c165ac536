// SPDX-License-Identifier: Apache-2.0
// Momenta of bodies, measured over ranges of particles and kept in the executor's memory, without synchronisation; and
// what uses them, damping and momentum correction.
#pragma once
#include <algorithm>
#include <vector>

#include "host/base/array.h"
#include "host/model/model.h"
#include "host/projection/stiffness.h"
#include "kernels/forces/momenta.h"
#include "malha/mesh.h"

namespace malha {

template <class Executor, class R>
class BodyMomenta {
 public:
  /// `islands`: bodies of the consecutive particles first .. first + count - 1.
  template <class Island>
  BodyMomenta(const Executor& executor, const std::vector<Island>& islands)
      : executor_(executor), count_(static_cast<int>(islands.size())) {
    std::vector<ParticleRange> ranges;
    for (int b = 0; b < count_; ++b) {
      const Island& island = islands[static_cast<std::size_t>(b)];
      MeasuredBody body{};
      body.begin = static_cast<int>(ranges.size());
      for (int i = 0; i < island.count; i += kRangeSize)
        ranges.push_back({island.first + i, std::min(kRangeSize, island.count - i), b, island.first});
      body.end = static_cast<int>(ranges.size());
      start_.push_back(body);
    }
    ranges_ = Array<Executor, ParticleRange>(ranges);
    sums_ = Array<Executor, MomentaSum>(ranges.size(), MomentaSum{});
    bodies_ = Array<Executor, MeasuredBody>(start_);
    motions_ = Array<Executor, RigidMotion<R>>(islands.size(), RigidMotion<R>{});
    memory_ = Array<Executor, char>(kBytes * threads_of(executor), 0);
  }

  /// `gained`: change of velocity by gravity since the start, m/s. `h`: length of the projected substep, s.
  template <class N, bool projected, bool inertia>
  void measure(const Particles<R>& particles, Measured what, double h = 1, const Vec3& gained = {}) {
    using Measure = MeasureMomenta<R, N, projected, inertia>;
    const Measure sum{particles, ranges_.data(), sums_.data(), N(h), N(1 / h)};
    const StoreMomenta note{sums_.data(), bodies_.data(), Measure::n, what, {gained[0], gained[1], gained[2]}};
    region([&](const auto& team, int ranges) {
      parallel_groups(team, 0, ranges, {memory_.data(), kBytes}, sum);
      parallel_groups(team, 0, count_, {}, note);
    });
  }
  /// Computes the motion of each body by `find`, and runs `use` on all ranges.
  template <class Find, class Use>
  void move(const Find& find, const Use& use) {
    parallel_for(executor_, count_, find);
    region([&](const auto& team, int ranges) { parallel_groups(team, 0, ranges, {}, use); });
  }
  /// Clears the measurements.
  void exclude(const std::vector<bool>& bodies) {
    for (int b = 0; b < count_; ++b) start_[b].excluded = bodies[b] ? 1 : 0;
    bodies_.upload(start_);
  }

  const ParticleRange* ranges() const { return ranges_.data(); }
  MeasuredBody* bodies() const { return bodies_.data(); }
  RigidMotion<R>* motions() const { return motions_.data(); }
  std::size_t bytes() const {
    return ranges_.bytes() + sums_.bytes() + bodies_.bytes() + motions_.bytes() + memory_.bytes();
  }

 private:
  static constexpr int kRangeSize = 1024;  // particles of a range: many ranges for threads, but few sums
  static constexpr std::size_t kBytes = MeasureMomenta<R, double, false, true>::kBytes;  // the most

  template <class Work>
  void region(const Work& work) const {
    const int ranges = static_cast<int>(ranges_.size());
    parallel_region(executor_, ranges, [&](const auto& team) { work(team, ranges); });
  }

  Executor executor_;
  int count_;
  std::vector<MeasuredBody> start_;
  Array<Executor, ParticleRange> ranges_;
  Array<Executor, MomentaSum> sums_;
  Array<Executor, MeasuredBody> bodies_;
  Array<Executor, RigidMotion<R>> motions_;
  Array<Executor, char> memory_;  // of each thread
};

/// Damping of connected bodies that preserves rigid motion: one measurement, a 3 x 3 solve per body, one pass.
template <class Executor, class R>
class Damping {
 public:
  /// Damping of each body in [0, 1], per step of so many substeps. Pinned particles neither count nor move.
  Damping(const Executor& executor, const std::vector<DampedIsland>& islands, int substeps)
      : bodies_(executor, islands) {
    std::vector<R> k;
    for (const DampedIsland& island : islands) k.push_back(R(stiffness_per_projection(island.damping, substeps)));
    k_ = Array<Executor, R>(k);
  }

  /// Damps v in a substep. Sums are in double: in float they would change momenta.
  void damp(const Particles<R>& particles) {
    bodies_.template measure<double, false, true>(particles, Measured::Now);
    bodies_.move(ComputeRigidMotion<R>{bodies_.bodies(), bodies_.motions()},
                 DampTowardsRigid<R>{particles, bodies_.ranges(), bodies_.motions(), k_.data()});
  }

  std::size_t bytes() const { return bodies_.bytes() + k_.bytes(); }

 private:
  BodyMomenta<Executor, R> bodies_;
  Array<Executor, R> k_;
};

/// Momentum correction of free bodies: restores the momenta that projections of constraints change. They change angular
/// momentum where a correction is too large for the gradient at the start of the substep
/// (kernels/projection/direction.h), or follows Desbrun's filter, and both momenta by rounding.
template <class Executor, class R>
class MomentumCorrector {
 public:
  MomentumCorrector(const Executor& executor, const Model& model) : islands_(model.free), bodies_(executor, islands_) {}

  /// Only internal forces, and gravity, may act between before() and after(), which may be called any number of times
  /// in a step. Both measure the state x and v.
  void before(const Particles<R>& particles) { bodies_.template measure<R, false, false>(particles, Measured::Start); }
  /// `gained`: change of velocity by gravity since before(), m/s.
  void after(const Particles<R>& particles, const Vec3& gained) {
    bodies_.template measure<R, false, true>(particles, Measured::Loss, 1, gained);
  }
  /// The same within a substep of h seconds, measured at p.
  void before_projection(const Particles<R>& particles, double h) {
    bodies_.template measure<R, true, false>(particles, Measured::Start, h);
  }
  void after_projection(const Particles<R>& particles, double h) {
    bodies_.template measure<R, true, false>(particles, Measured::Loss, h);
  }

  /// Excludes the bodies of these particles, on which external forces or constraints act. Called between steps.
  void exclude(const std::vector<int>& particles) {
    std::vector<bool> out;
    for (const FreeIsland& island : islands_)
      out.push_back(
          std::ranges::any_of(particles, [&](int i) { return i >= island.first && i < island.first + island.count; }));
    bodies_.exclude(out);
  }

  /// Restores the momenta that were lost since the last call. `known`: the last measurement was after().
  void restore_momenta(const Particles<R>& particles, bool known) {
    if (!known) bodies_.template measure<R, false, true>(particles, Measured::Now);
    bodies_.move(ComputeMomentumCorrection<R>{bodies_.bodies(), bodies_.motions()},
                 AddRigidMotion<R>{particles, bodies_.ranges(), bodies_.motions()});
  }

  std::size_t bytes() const { return bodies_.bytes(); }

 private:
  std::vector<FreeIsland> islands_;
  BodyMomenta<Executor, R> bodies_;
};

}  // namespace malha
