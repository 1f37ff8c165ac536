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
      obstacles_.emplace_back(Surface(device_, mesh.mesh), mesh.spec);
      bounces_ = bounces_ || mesh.spec.restitution > 0;
    }
    const std::size_t all = obstacles_.size() * model.x.size();
    seen_ = Array<Executor, LastSeen>(all, LastSeen{}), contacts_ = Array<Executor, Contact<R>>(all, Contact<R>{});
  }

  /// Lays the contact constraints for x -> p; the meshes move from their poses at `start` to those at `end` (s).
  void find(const Particles<R>& particles, double start, double end) {
    meshes_.clear();
    for (const Obstacle& o : obstacles_)
      meshes_.push_back(
          {&o.surface, o.spec.sides, o.spec.thickness, pose_at(o.spec.motion, start), pose_at(o.spec.motion, end)});
    for (int k = 0; k < count(); ++k)
      parallel_for(executor_, particles.count, FindContact<R>{surroundings(particles), k}, kGrain);
  }

  void resolve(const Particles<R>& particles) {
    for (int k = 0; k < count(); ++k)
      parallel_for(
          executor_, particles.count,
          ResolveContact<R>{particles.p, particles.x, contacts_of(particles, k), R(obstacles_[k].spec.friction)});
  }

  /// After the last iteration: nothing that was dragged crosses a surface.
  void hold_back(const Particles<R>& particles) {
    parallel_for(executor_, particles.count, HoldBack<R>{surroundings(particles)}, kGrain);
  }

  /// `resting`: the speed that gravity gives in two substeps, below which nothing bounces (m/s).
  void restitute(const Particles<R>& particles, double resting, double h) {
    for (int k = 0; k < count(); ++k) {
      const EnvironmentSpec& spec = obstacles_[k].spec;
      parallel_for(executor_, particles.count,
                   Restitute<R>{particles.x, particles.v, contacts_of(particles, k), R(spec.restitution),
                                R(spec.friction), R(resting), R(1 / h)});
    }
    if (bounces_) parallel_for(executor_, particles.count, HoldBounce<R>{surroundings(particles)}, kGrain);
  }

  /// Contacts that pushed in the last substep.
  int contacts() const {
    return static_cast<int>(
        parallel_reduce<Sum>(executor_, static_cast<int>(contacts_.size()), CountContact<R>{contacts_.data()}).value);
  }

  /// How deep the deepest particle lies below a surface (m) at the given time, or was when it was pressed through one.
  double max_penetration(const Particles<R>& particles, double time) const {
    double deepest = 0;
    for (int k = 0; k < count(); ++k) {
      const Obstacle& o = obstacles_[k];
      const MeasureDepth<R> kernel{&o.surface, o.spec.sides, pose_at(o.spec.motion, time), particles,
                                   seen_.data() + k * particles.count};
      deepest = std::max(deepest, parallel_reduce<Deepest>(executor_, particles.count, kernel, kGrain).depth);
    }
    return deepest;
  }

  std::size_t bytes() const {
    std::size_t sum = seen_.bytes() + contacts_.bytes();
    for (const Obstacle& o : obstacles_) sum += o.surface.bytes();
    return sum;
  }

  /// How many triangles each mesh has.
  std::vector<int> triangles() const {
    std::vector<int> counts;
    for (const Obstacle& o : obstacles_) counts.push_back(o.surface.triangles());
    return counts;
  }

  /// What a later substep depends on, for checkpoints.
  std::vector<LastSeen> memory() const { return seen_.download(); }
  void remember(const std::vector<LastSeen>& all) { seen_.upload(all); }

 private:
  static constexpr int kGrain = 64;  // a query costs about as much as a hundred plain updates
  struct Obstacle {
    Obstacle(Surface s, const EnvironmentSpec& e) : surface(std::move(s)), spec(e) {}
    Surface surface;
    EnvironmentSpec spec;
  };

  int count() const { return static_cast<int>(obstacles_.size()); }
  Contact<R>* contacts_of(const Particles<R>& particles, int k) { return contacts_.data() + k * particles.count; }
  Surroundings<R> surroundings(const Particles<R>& particles) {
    return {meshes_.data(), count(), particles, seen_.data(), contacts_.data()};
  }

  Executor executor_;
  Device device_;
  std::deque<Obstacle> obstacles_;
  std::vector<MovingSurface> meshes_;  // of the present substep
  Array<Executor, LastSeen> seen_;     // of each particle, mesh after mesh
  Array<Executor, Contact<R>> contacts_;
  bool bounces_ = false;
};

}  // namespace malha
