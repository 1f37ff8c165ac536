// SPDX-License-Identifier: Apache-2.0
// The pressure constraint of one closed surface (kernels/forces/pressure.h), with its lambda: of a body, or of bodies
// that seams join.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "host/base/array.h"
#include "host/base/point_array.h"
#include "host/mesh/compressed_lists.h"
#include "host/mesh/vectors.h"
#include "host/model/model.h"
#include "host/projection/stiffness.h"
#include "kernels/forces/pressure.h"

namespace malha {

template <class Executor, class R>
class Pressure {
 public:
  Pressure(const Executor& executor, const Model& model, const PressureSet& set) : executor_(executor) {
    const SolverSpec& solver = model.scene.solver;
    const double h = solver.dt / solver.substeps;
    compliant_ = set.compliance.has_value();
    compliance_ = set.compliance.value_or(0), alpha_ = compliance_ / (h * h);
    stiffness_ = stiffness_per_projection(set.stiffness, solver, 1);
    lay_out_fans(model.count(), set);
    const PointArray<Serial, double> rest(model.at_rest(set));
    rest_ = parallel_reduce<Sum>(Serial{}, triangles_,
                                 EnclosedVolume<Points<double>>{rest.points(), corners_on_host_.data(), origin_})
                .value;
    target_ = set.volume_ratio * rest_;
    lay_out_most(model, set);
    if (!set.followers.empty()) lay_out_followers(model.count(), set);
    corners_on_host_ = {};
  }

  /// For filtered pressure: all particles of the body move by it. Returns the index of the body.
  int move_all(const Model& model) {
    const int body = body_of(model, model.user_index[origin_]);
    std::vector<int> members;
    for (int i = 0; i < model.count(); ++i)
      if (body_of(model, model.user_index[i]) == body) members.push_back(i);
    members_ = Array<Executor, int>(members);
    return body;
  }

  /// Computes the gradient at the start of the substep. With a filter spikes do not grow, and it needs no clamp.
  void start_substep(const Displaced<R>& p, const R* w, bool filtered) {
    PressureState* const state = state_.data();
    if (has_followers()) {
      const JoinInverseMasses<R> join{w, particle_.data(), follower_begin_.data(), followers_.data(), joined_w_.data()};
      parallel_for(executor_, items(), join);
      w = joined_w_.data();
    }
    const PressureGradient<R> find{fans(StartPositions<R>{p}), w, particle_.data(), filtered ? nullptr : most_.data(),
                                   grad_.points()};
    parallel_reduce_into(executor_, items(), find, &state->sums);
    if (!filtered)
      parallel_reduce_into(executor_, items(), MeasureInertia<R>{state, p, w, particle_.data(), origin_},
                           &state->inertia);
    parallel_for(executor_, 1, StartPressure{state});
  }

  void project(const Displaced<R>& p, const R* w) {
    if (has_followers()) w = joined_w_.data();
    find_push(p, w, {});
    const ApplyPressure<R> apply{p, w, particle_.data(), grad_.points(), state_.data(), origin_};
    parallel_for(executor_, items(), apply);
    if (has_followers())
      parallel_for(executor_, static_cast<int>(followers_.size()),
                   FollowPressure<R>{apply, leader_item_.data(), followers_.data()});
  }

  /// project() in two parts. Between them the filter maps `force`, the gradient at the start, to displacements `way`
  /// (host/solver/desbrun.h).
  void put(const Points<R>& force) {
    parallel_for(executor_, items(), StorePressureForce<R>{particle_.data(), grad_.points(), force});
  }
  void push(const Displaced<R>& p, const Points<R>& way) {
    find_push(p, nullptr, way);
    parallel_for(executor_, static_cast<int>(members_.size()),
                 ApplyFilteredPressure<R>{p, way, members_.data(), state_.data()});
  }

  /// Enclosed volume over the rest volume.
  double volume_ratio(const Points<R>& x) const { return volume(x) / rest_; }
  /// C^2 / (2 alpha), J; 0 without a compliance.
  double energy(const Points<R>& x) const {
    if (!(compliance_ > 0)) return 0;
    const double C = volume(x) - target_;
    return C * C / (2 * compliance_);
  }
  std::size_t member_bytes() const { return members_.bytes(); }
  std::size_t bytes() const {
    return particle_.bytes() + begin_.bytes() + around_.bytes() + corners_.bytes() + most_.bytes() + grad_.bytes() +
           joined_w_.bytes() + follower_begin_.bytes() + followers_.bytes() + leader_item_.bytes();
  }

 private:
  int items() const { return static_cast<int>(particle_.size()); }
  bool has_followers() const { return followers_.size() > 0; }
  template <class At>
  Fans<R, At> fans(const At& p) const {
    return {p, begin_.data(), around_.data()->data(), origin_};
  }
  void find_push(const Displaced<R>& p, const R* w, const Points<R>& way) {
    PressureState* const state = state_.data();
    parallel_reduce_into(executor_, triangles_, EnclosedVolume<Displaced<R>>{p, corners_.data(), origin_},
                         &state->volume);
    parallel_reduce_into(executor_, items(), SumAlongPressure<R>{fans(p), particle_.data(), grad_.points(), w, way},
                         &state->along);
    parallel_for(executor_, 1, PushPressure{state, target_, compliant_, alpha_, stiffness_});
  }
  double volume(const Points<R>& p) const {
    return parallel_reduce<Sum>(executor_, triangles_, EnclosedVolume<Points<R>>{p, corners_.data(), origin_}).value;
  }

  /// For every particle the pairs (j, k) of its triangles (i, j, k), so that gradients are gathered, not scattered.
  void lay_out_fans(int particles, const PressureSet& set) {
    std::vector<int> item(particles, -1);
    for (std::size_t i = 0; i < set.particles.size(); ++i) item[set.particles[i]] = static_cast<int>(i);
    const CompressedLists<Edge> around(set.particles.size(), [&](const auto& add) {
      for (const Triangle& t : set.triangles)
        for (int k = 0; k < 3; ++k) add(item[t[k]], {t[(k + 1) % 3], t[(k + 2) % 3]});
    });
    for (const Triangle& t : set.triangles) corners_on_host_.insert(corners_on_host_.end(), t.begin(), t.end());
    origin_ = set.particles[0];
    triangles_ = static_cast<int>(set.triangles.size());
    particle_ = Array<Executor, int>(set.particles);
    begin_ = Array<Executor, int>(around.begin);
    around_ = Array<Executor, Edge>(around.list);
    corners_ = Array<Executor, int>(corners_on_host_);
    grad_ = PointArray<Executor, R>(std::vector<Vec3>(set.particles.size()));
    state_ = Array<Executor, PressureState>(1, PressureState{});
  }

  /// The largest gradients: kMaxStretch times those of the faces at rest, scaled to the size at which the body has its
  /// volume.
  void lay_out_most(const Model& model, const PressureSet& set) {
    std::vector<double> around(model.count(), 0);  // m^2 of all faces around a particle
    const std::vector<Vec3>& X = model.at_rest(set);
    for (const Triangle& t : set.triangles)
      for (const int corner : t) around[corner] += area(X[t[0]], X[t[1]], X[t[2]]);
    const double grown = std::cbrt(std::max(1.0, set.volume_ratio));
    std::vector<R> most;
    for (const int i : set.particles) most.push_back(static_cast<R>(kMaxStretch * grown * grown * around[i] / 3));
    most_ = Array<Executor, R>(most);
  }

  void lay_out_followers(int particles, const PressureSet& set) {
    std::vector<int> item(particles, -1), leaders;
    for (std::size_t i = 0; i < set.particles.size(); ++i) item[set.particles[i]] = static_cast<int>(i);
    const CompressedLists<int> of(set.particles.size(), [&](const auto& add) {
      for (const auto& [leader, follower] : set.followers) add(item[leader], follower);
    });
    for (int i = 0; i < items(); ++i) leaders.insert(leaders.end(), of[i].size(), i);
    follower_begin_ = Array<Executor, int>(of.begin), followers_ = Array<Executor, int>(of.list);
    leader_item_ = Array<Executor, int>(leaders), joined_w_ = Array<Executor, R>(particles, R(0));
  }

  Executor executor_;
  Array<Executor, int> particle_, begin_, corners_, members_;
  Array<Executor, Edge> around_;
  Array<Executor, R> most_, joined_w_;  // joined_w_ and the following: of bodies that seams join
  Array<Executor, int> follower_begin_, followers_, leader_item_;
  PointArray<Executor, R> grad_;
  Array<Executor, PressureState> state_;
  std::vector<int> corners_on_host_;
  int origin_ = 0, triangles_ = 0;
  bool compliant_ = false;
  double compliance_ = 0, alpha_ = 0, stiffness_ = 1, target_ = 0, rest_ = 0;
};

}  // namespace malha
