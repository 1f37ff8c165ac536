// Particles without constraints against one environment mesh, substep by substep, as the solver does it.
#pragma once
#include <cmath>
#include <vector>

#include "host/collision/collider.h"
#include "host/mesh/generate.h"
#include "kernels/integrate.h"
#include "tests/numbers.h"

namespace malha {

template <class Executor, class R>
class ContactBench {
 public:
  ContactBench(const Executor& executor, const EnvironmentSpec& spec, const std::vector<Point>& x,
               const std::vector<Point>& v)
      : executor_(executor), model_(model_of(spec, x)), collider_(executor, model_) {
    std::vector<Vec4<R>> at, speed, predicted;
    for (std::size_t i = 0; i < x.size(); ++i) {
      at.push_back({R(x[i].x), R(x[i].y), R(x[i].z), R(0)});
      speed.push_back({R(v[i].x), R(v[i].y), R(v[i].z), R(0)});
      predicted.push_back({R(0), R(0), R(0), R(1)});
    }
    x_ = Array<Executor, Vec4<R>>(at), v_ = Array<Executor, Vec4<R>>(speed), p_ = Array<Executor, Vec4<R>>(predicted);
  }

  void substep(double h, const Point& gravity = {0, 0, 0}, int iterations = 1) {
    const Particles<R> all = particles();
    const int n = all.count;
    parallel_for(executor_, n, Predict<R>{all, R(h), {R(gravity.x), R(gravity.y), R(gravity.z)}});
    collider_.find(all, time_, time_ + h);
    for (int i = 0; i < iterations; ++i) collider_.resolve(all);
    parallel_reduce<FirstIndex>(executor_, n, UpdateState<R>{all, R(h), R(1 / h)});
    collider_.restitute(all, 2 * h * norm(gravity), h);
    time_ += h;
  }

  Particles<R> particles() const { return {static_cast<int>(x_.size()), x_.data(), v_.data(), p_.data()}; }
  int count() const { return static_cast<int>(x_.size()); }
  Point x(int i) const { return to_double(x_.data()[i].xyz()); }
  Point v(int i) const { return to_double(v_.data()[i].xyz()); }
  double time() const { return time_; }
  Collider<Executor, R>& collider() { return collider_; }
  const Collider<Executor, R>& collider() const { return collider_; }
  void forget() { collider_.remember(std::vector<LastSeen>(x_.size())); }

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
  Collider<Executor, R> collider_;
  Array<Executor, Vec4<R>> x_, v_, p_;
  double time_ = 0;
};

}  // namespace malha
