// SPDX-License-Identifier: Apache-2.0
// Particles without constraints in contact with one environment mesh, substep by substep, as the solver takes them.
#pragma once
#include <cmath>
#include <vector>

#include "host/environment/mesh_collider.h"
#include "host/mesh/generate.h"
#include "kernels/forces/integrate.h"
#include "tests/mesh/point_list.h"
#include "tests/numbers.h"

namespace malha {

template <class Executor, class R>
class ContactBench {
 public:
  ContactBench(const Executor& executor, const EnvironmentSpec& spec, const std::vector<Point>& x,
               const std::vector<Point>& v)
      : executor_(executor), model_(model_of(spec, x)), collider_(executor, model_) {
    for (std::size_t i = 0; i < x.size(); ++i) {
      x_.push_back(x[i]), v_.push_back(v[i]);
      low_.push_back(x[i] - to_double(x_[static_cast<int>(i)]));
    }
    d_ = PointList<R>(x.size()), w_.assign(x.size(), R(1));
  }

  void substep(double h, const Point& gravity = {0, 0, 0}, int iterations = 1) {
    const Particles<R> all = particles();
    const int n = all.count;
    parallel_for(executor_, n, Predict<R>{all, R(h), {R(gravity.x), R(gravity.y), R(gravity.z)}});
    collider_.set_poses(time_, time_ + h);
    collider_.detect_contacts(all);
    for (int i = 0; i < iterations; ++i) collider_.solve_contacts(all);
    parallel_reduce<FirstIndex>(executor_, n, UpdateState<R>{all, R(h), R(1 / h)});
    collider_.restitute(all, 2 * h * norm(gravity), h);
    if (collider_.bounces()) {
      collider_.clamp_restitution(all);
      parallel_for(executor_, n, AdvanceAll<R>{all.p});
    }
    time_ += h;
  }

  Particles<R> particles() {
    return {count(), x_.points(), v_.points(), {x_.points(), d_.points(), low_.points()}, w_.data()};
  }
  int count() const { return x_.size(); }
  Point x(int i) const { return to_double(x_[i]) + to_double(low_[i]); }
  Point v(int i) const { return to_double(v_[i]); }
  void pin(int i) { w_[i] = R(0); }
  void push(int i, const Point& v) { v_.set(i, {R(v.x), R(v.y), R(v.z)}); }
  double time() const { return time_; }
  MeshCollider<Executor, R>& collider() { return collider_; }
  const MeshCollider<Executor, R>& collider() const { return collider_; }
  /// The proximity record that the contact cache has of a particle close to the mesh.
  ProximityRecord& near(int i) {
    const ProximityCacheView<R> cache = collider_.cache(0);
    return cache.near[cache.slot(i)];
  }
  void forget() { collider_.restore_state({}); }

 private:
  static Model model_of(const EnvironmentSpec& spec, const std::vector<Point>& x) {
    Model model;
    EnvironmentMesh mesh{spec, generate(spec.shape)};
    apply(spec.transform, mesh.mesh);
    model.environment.push_back(mesh);
    for (const Point& a : x) model.x.push_back({a.x, a.y, a.z});
    return model;
  }

  Executor executor_;
  Model model_;
  MeshCollider<Executor, R> collider_;
  PointList<R> x_, low_, v_, d_;  // low_: the rounding errors of x_
  std::vector<R> w_;
  double time_ = 0;
};

}  // namespace malha
