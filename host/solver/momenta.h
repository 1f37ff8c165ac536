// Gives free bodies back the momenta that their constraints' projections take: angular momentum, because a projection
// acts where it moves a particle to (of first order in the substep), and in float both, by rounding places.
#pragma once
#include <algorithm>
#include <vector>

#include "host/base/array.h"
#include "host/model/model.h"
#include "host/solver/damping.h"
#include "kernels/momenta.h"

namespace malha {

template <class Executor, class R>
class Momenta {
 public:
  Momenta(const Executor& executor, const Model& model) : executor_(executor), bodies_(model.free.size()) {
    std::vector<Stretch> stretches;
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      const FreeIsland& island = model.free[b];
      for (int i = 0; i < island.count; i += kStretch)
        stretches.push_back(
            {island.first + i, std::min(kStretch, island.count - i), static_cast<int>(b), island.first});
    }
    body_of_.reserve(stretches.size());
    for (const Stretch& stretch : stretches) body_of_.push_back(stretch.body);
    stretches_ = Array<Executor, Stretch>(stretches);
    sums_ = Array<Executor, MomentaSum>(stretches.size(), MomentaSum{});
    motions_ = Array<Executor, RigidMotion<R>>(bodies_.size(), RigidMotion<R>{});
  }

  /// Between before() and after(), which may be called any number of times in a step, internal forces act, and gravity
  /// on every particle alike. The particles have their state x and v,
  void before(const Particles<R>& particles) { start<false>(particles, 1); }
  void after(const Particles<R>& particles, const Vec3& gained) { note_loss<false>(particles, 1, gained); }
  /// or are in a substep of h seconds, at p.
  void before_projection(const Particles<R>& particles, double h) { start<true>(particles, h); }
  void after_projection(const Particles<R>& particles, double h) { note_loss<true>(particles, h, {0, 0, 0}); }

  /// Bodies of these particles get nothing back: something outside acts on them, or holds them.
  void leave_out(const std::vector<int>& particles) {
    for (Body& body : bodies_) body.left_out = false;
    const std::vector<Stretch> stretches = stretches_.download();
    for (const Stretch& stretch : stretches)
      for (const int i : particles)
        if (i >= stretch.first && i < stretch.first + stretch.count) bodies_[stretch.body].left_out = true;
  }

  /// Gives back what was lost since the last time. `known`: the last that was called is after().
  void give_back(const Particles<R>& particles, bool known) {
    if (!known) measure<false, true>(particles, 1);
    std::vector<RigidMotion<R>> motions;
    for (Body& body : bodies_) {
      if (body.left_out) {
        motions.push_back({}), body.lost = {};
        continue;
      }
      SpinSum spin;
      std::copy_n(body.lost.spin, 3, spin.L), std::copy_n(body.now.inertia, 6, spin.I);
      const Vector3<double> omega = angular_velocity(spin);
      const auto to_R = [](const double* a, double per) {
        return Vector3<R>{R(a[0] * per), R(a[1] * per), R(a[2] * per)};
      };
      motions.push_back({to_R(body.now.place, 1),
                         to_R(body.now.centre, 1),
                         to_R(body.lost.linear, 1 / body.now.mass),
                         {R(omega.x), R(omega.y), R(omega.z)}});
      body.lost = {};
    }
    motions_.upload(motions);
    launch(AddRigidMotion<R>{particles, stretches_.data(), motions_.data()});
  }

  std::size_t bytes() const { return stretches_.bytes() + sums_.bytes() + motions_.bytes(); }

 private:
  static constexpr int kStretch = 1024;  // particles: stretches for many threads, and few sums

  struct Rigid {
    double mass = 0, place[3] = {}, centre[3] = {};  // kg; m; m, from that place
    double linear[3] = {}, spin[3] = {};             // kg m/s; kg m^2/s about the centre of mass
    double inertia[6] = {};                          // kg m^2 about it
  };
  struct Body {
    Rigid start, now, lost;
    bool left_out = false;
  };

  template <class Kernel>
  void launch(const Kernel& kernel) const {
    const int count = static_cast<int>(stretches_.size());
    parallel_region(executor_, count, [&](const auto& team) { parallel_groups(team, 0, count, {}, kernel); });
  }

  template <bool projected>
  void start(const Particles<R>& particles, double h) {
    measure<projected, false>(particles, h);
    for (Body& body : bodies_) body.start = body.now;
  }

  /// `gained`: velocity by gravity since the start.
  template <bool projected>
  void note_loss(const Particles<R>& particles, double h, const Vec3& gained) {
    measure<projected, !projected>(particles, h);
    for (Body& body : bodies_)
      for (int k = 0; k < 3; ++k) {
        body.lost.linear[k] += body.start.linear[k] + body.now.mass * gained[k] - body.now.linear[k];
        body.lost.spin[k] += body.start.spin[k] - body.now.spin[k];
      }
  }

  /// What every body has now.
  template <bool projected, bool inertia>
  void measure(const Particles<R>& particles, double h) {
    launch(MeasureMomenta<R, projected, inertia>{particles, stretches_.data(), sums_.data(), R(h), R(1 / h)});
    const std::vector<MomentaSum> sums = sums_.download();
    for (std::size_t s = 0, end; s < sums.size(); s = end) {
      MomentaSum all = sums[s];
      for (end = s + 1; end < sums.size() && body_of_[end] == body_of_[s]; ++end)
        for (int k = 0; k < MomentaSum::kAll; ++k) all.number[k] += sums[end].number[k];
      bodies_[body_of_[s]].now = about_the_centre(all);
    }
  }

  static Rigid about_the_centre(const MomentaSum& sum) {
    Rigid now;
    const double m = sum.m(), *r = sum.r(), *u = sum.u();
    const double c[3] = {r[0] / m, r[1] / m, r[2] / m};
    now.mass = m;
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      now.place[k] = sum.place[k], now.centre[k] = c[k];
      now.linear[k] = u[k] + m * sum.velocity[k];
      now.spin[k] = sum.L()[k] - (c[i] * u[j] - c[j] * u[i]);
      now.inertia[k] = sum.I()[k] - (r[i] * c[i] + r[j] * c[j]);
    }
    now.inertia[3] = sum.I()[3] + r[0] * c[1];
    now.inertia[4] = sum.I()[4] + r[0] * c[2];
    now.inertia[5] = sum.I()[5] + r[1] * c[2];
    return now;
  }

  Executor executor_;
  std::vector<Body> bodies_;
  std::vector<int> body_of_;  // of each stretch
  Array<Executor, Stretch> stretches_;
  Array<Executor, MomentaSum> sums_;
  Array<Executor, RigidMotion<R>> motions_;
};

}  // namespace malha
