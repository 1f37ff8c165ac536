// SPDX-License-Identifier: Apache-2.0
// Trajectories of the particles in a substep: start positions, in which nothing intersects, and the displacements
// since. In float the positions are relative to an origin that follows the bodies, so that they are rounded little.
#pragma once
#include <algorithm>
#include <limits>
#include <vector>

#include "host/base/point_array.h"
#include "host/self_collision/self_contacts.h"
#include "host/self_collision/self_memory.h"
#include "kernels/environment/edge_truncate.h"
#include "kernels/self_collision/contact_distance.h"

namespace malha {

template <class Executor, class R>
class ParticleTrajectories {
 public:
  /// `x`: positions at the start, in double. `leader`: the particle that the origin follows. `factor`: of the thickness
  /// of each particle; empty: 1. `max_rounding`: of positions far from the origin, m.
  ParticleTrajectories(const Executor& executor, const Particles<R>& particles, const std::vector<Vec3>& x,
                       std::size_t leader, double thickness, const std::vector<double>& factor, double max_rounding)
      : executor_(executor),
        count_(particles.count),
        leader_(leader),
        thickness_(R(thickness)),
        max_rounding_(max_rounding),
        x0_(x.size() + 1),  // a row of padding
        moved_(x.size() + 1),
        nearest_(x.size() + 1, R(0)),
        factor_(std::vector<R>(factor.begin(), factor.end())) {
    if (!x.empty()) move_origin_to({x[leader][0], x[leader][1], x[leader][2]});
    start_from(particles);
  }

  Trajectories<R> view() const { return {x0_.points().of, moved_.points().of, rounded<R>(origin_)}; }
  const Vector3<double>& origin() const { return origin_; }
  double max_rounding() const { return max_rounding_; }
  /// Start positions relative to the origin, m.
  std::vector<Vec3> start_positions() const { return without_padding(x0_.download()); }

  /// Computes the displacements from the particles' positions.
  void load(const Particles<R>& particles) {
    parallel_for(executor_, count_, ComputeDisplacements<R>{particles.p, particles.w, view()}, kGrain);
  }
  /// Sets the positions of particles that were displaced otherwise.
  void store(const Particles<R>& particles) const {
    parallel_for(executor_, count_, ApplyDisplacements<R>{view(), particles.p}, kGrain);
  }
  /// Starts from the particles' positions.
  void start_from(const Particles<R>& particles) {
    parallel_for(executor_, count_, CopyPoints<R, FromOrigin<R>>{{particles.p, rounded<R>(origin_)}, x0_.points()});
  }
  /// Moves the origin along with the bodies. Returns whether it moved; what is relative to the old one is invalid then.
  bool update_origin(const Particles<R>& particles) {
    if constexpr (!kCompensated<R>) return false;
    const Vec3 leader = x0_.get(leader_);
    if (!move_origin_to(Vector3<double>{leader[0], leader[1], leader[2]} + origin_)) return false;
    start_from(particles);
    return true;
  }

  /// Pairs that are nearer than the thickness now keep their distance until they separate by themselves.
  void keep_overlaps() {
    parallel_for(executor_, count_, ResetContactDistances<R>{x0_.points().of, thickness_}, kGrain);
    distances_grow_ = true;
  }
  /// The same where bodies do not intersect any more. `crosses`: where they do, or null.
  void mark_crossing(const CrossingBodies* crosses) {
    parallel_for(executor_, count_, MarkCrossingBodies<R>{x0_.points().of, thickness_, crosses}, kGrain);
    distances_grow_ = true;
  }
  /// Grows contact distances to those of the nearest pairs, as long as any is below the thickness.
  void grow_contact_distances(const SelfContacts<Executor, R>& contacts) {
    if (!distances_grow_) return;
    R* const nearest = nearest_.data();
    Memory<Executor>::fill(nearest, count_ + 1, R(INFINITY));
    const auto grow = [&]<bool mapped>() {
      contacts.in_colours(FindNearestPairs<R, mapped>{view(), contacts.pairs(), nearest, thickness_, factor_.data()});
      const GrowContactDistances<R, mapped> kernel{x0_.points().of, thickness_, nearest, factor_.data()};
      distances_grow_ = parallel_reduce<Sum>(executor_, count_, kernel, kGrain).value > 0;
    };
    factor_.size() > 0 ? grow.template operator()<true>() : grow.template operator()<false>();
  }

  /// The state that later substeps depend on, for checkpoints.
  void save(SelfMemory<R>& memory) const {
    memory.x0 = without_padding(x0_.template download<std::array<R, 3>>());
    memory.contact_distance = x0_.download_fourth(count_);
    memory.origin = {origin_};
  }
  void restore(const SelfMemory<R>& memory) {
    std::vector<std::array<R, 3>> x0 = memory.x0;
    x0.push_back({});
    x0_.upload(x0), x0_.upload_fourth(memory.contact_distance);
    origin_ = memory.origin.at(0), distances_grow_ = true;
  }
  std::size_t bytes() const { return x0_.bytes() + moved_.bytes() + nearest_.bytes() + factor_.bytes(); }

 private:
  static constexpr int kGrain = 8192;
  static constexpr double kNearOrigin = 0.25;  // of the distance from the origin at which rounding reaches its limit

  template <class T>
  static std::vector<T> without_padding(std::vector<T> list) {
    list.pop_back();
    return list;
  }
  /// Moves the origin to a particle that is too far from it. Returns whether it did. Types that are not compensated
  /// keep origin 0.
  bool move_origin_to(const Vector3<double>& particle) {
    const Vector3<double> way = particle - origin_;
    const double apart = max(abs(way.x), max(abs(way.y), abs(way.z))),
                 most = kNearOrigin * max_rounding_ / std::numeric_limits<R>::epsilon();
    if (!kCompensated<R> || !(apart > most) || !(apart < double(std::numeric_limits<R>::max()))) return false;
    const Vector3<double> before = origin_;
    origin_ = in_double(rounded<R>(particle));
    return !same(origin_, before);
  }

  Executor executor_;
  int count_;
  std::size_t leader_;
  R thickness_;
  double max_rounding_;
  ScatteredArray<Executor, R> x0_, moved_;  // m; w: contact distance, inverse mass
  Vector3<double> origin_{0, 0, 0};         // m, of x0
  bool distances_grow_ = true;              // whether contact distances may be below the thickness
  Array<Executor, R> nearest_;              // see FindNearestPairs
  Array<Executor, R> factor_;               // of the thickness of each particle; empty: 1
};

}  // namespace malha
