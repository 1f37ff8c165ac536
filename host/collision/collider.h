// All environment meshes of a scene: their contacts with the particles, substep by substep. Made only for scenes that
// have an environment; without one there is no Embree device.
#pragma once
#include <cmath>
#include <cstring>
#include <deque>
#include <vector>

#include "host/base/array.h"
#include "host/collision/find_contact.h"
#include "host/collision/hold_back.h"
#include "host/model/model.h"

namespace malha {

template <class Executor, class R>
class Collider {
 public:
  Collider(const Executor& executor, const Model& model) : executor_(executor) {
    for (const EnvironmentMesh& mesh : model.environment) {
      Obstacle& obstacle = obstacles_.emplace_back(Surface(device_, mesh.mesh), mesh.spec);
      obstacle.seen = Array<Executor, LastSeen>(model.x.size(), LastSeen{});
      obstacle.contacts = Array<Executor, Contact<R>>(model.x.size(), Contact<R>{});
    }
  }

  /// Lays the contact constraints for x -> p; the meshes move from their poses at `start` to those at `end` (s).
  void find(const Particles<R>& particles, double start, double end) {
    for (Obstacle& o : obstacles_) {
      const FindContact<R> kernel{o.moving(start, end), particles, o.seen.data(), o.contacts.data()};
      parallel_for(executor_, particles.count, kernel, kGrain);
    }
  }

  void resolve(const Particles<R>& particles) {
    for (Obstacle& o : obstacles_)
      parallel_for(executor_, particles.count,
                   ResolveContact<R>{particles.p, particles.x, o.contacts.data(), R(o.spec.friction)});
  }

  /// After the last iteration: nothing that was dragged crosses a surface.
  void hold_back(const Particles<R>& particles, double start, double end) {
    for (Obstacle& o : obstacles_)
      parallel_for(executor_, particles.count, HoldBack<R>{o.moving(start, end), particles, o.seen.data()}, kGrain);
  }

  /// `resting`: the speed that gravity gives in two substeps, below which nothing bounces (m/s).
  void restitute(const Particles<R>& particles, double resting, double h) {
    for (Obstacle& o : obstacles_)
      parallel_for(executor_, particles.count,
                   Restitute<R>{particles.x, particles.v, o.contacts.data(), R(o.spec.restitution), R(o.spec.friction),
                                R(resting), R(1 / h)});
  }

  /// Contacts that pushed in the last substep.
  int contacts() const {
    Sum pushed;
    for (const Obstacle& o : obstacles_)
      pushed +=
          parallel_reduce<Sum>(executor_, static_cast<int>(o.contacts.size()), CountContact<R>{o.contacts.data()});
    return static_cast<int>(pushed.value);
  }

  /// How deep the deepest particle lies below a surface (m) at the given time. Two-sided sheets have no inside.
  double max_penetration(const Particles<R>& particles, double time) const {
    double deepest = 0;
    for (const Obstacle& o : obstacles_) {
      if (o.spec.sides == Sides::TwoSided) continue;
      const MeasureDepth<R> kernel{&o.surface, o.spec.sides, pose_at(o.spec.motion, time), particles};
      deepest = std::max(deepest, parallel_reduce<Deepest>(executor_, particles.count, kernel, kGrain).depth);
    }
    return deepest;
  }

  std::size_t bytes() const {
    std::size_t sum = 0;
    for (const Obstacle& o : obstacles_) sum += o.surface.bytes() + o.seen.bytes() + o.contacts.bytes();
    return sum;
  }

  /// What a later substep depends on, for checkpoints.
  std::vector<LastSeen> memory() const {
    std::vector<LastSeen> all;
    for (const Obstacle& o : obstacles_) {
      const auto part = o.seen.download();
      all.insert(all.end(), part.begin(), part.end());
    }
    return all;
  }
  void remember(const std::vector<LastSeen>& all) {
    auto from = all.begin();
    for (Obstacle& o : obstacles_) {
      const auto to = from + static_cast<std::ptrdiff_t>(o.seen.size());
      o.seen.upload({from, to});
      from = to;
    }
  }

 private:
  static constexpr int kGrain = 64;  // a query costs about as much as a hundred plain updates
  struct Obstacle {
    Obstacle(Surface s, const EnvironmentSpec& e) : surface(std::move(s)), spec(e) {}
    MovingSurface moving(double start, double end) const {
      return {&surface, spec.sides, spec.thickness, pose_at(spec.motion, start), pose_at(spec.motion, end)};
    }
    Surface surface;
    EnvironmentSpec spec;
    Array<Executor, LastSeen> seen;
    Array<Executor, Contact<R>> contacts;
  };

  Executor executor_;
  Device device_;
  std::deque<Obstacle> obstacles_;
};

}  // namespace malha
