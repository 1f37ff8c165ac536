// Position Based Dynamics (Müller et al. 2006) with XPBD's compliance (Macklin et al. 2016) and substeps (Macklin et
// al. 2019), for any executor and precision. A pass that the scene does not name does not exist here.
#pragma once
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "host/base/stopwatch.h"
#include "host/collision/collider.h"
#include "host/error.h"
#include "host/solver/batches.h"
#include "host/solver/damping.h"
#include "host/solver/pressure.h"
#include "host/solver/solver.h"
#include "host/solver/state.h"
#include "kernels/integrate.h"
#include "kernels/measure.h"

namespace malha {

template <class Executor, class R>
class Pbd final : public Solver {
 public:
  Pbd(const Model& model, const Executor& executor) : executor_(executor), model_(model) {
    std::vector<Vec4<R>> x(model.count()), v(model.count()), p(model.count());
    for (int i = 0; i < model.count(); ++i) {
      x[i] = {R(model.x[i][0]), R(model.x[i][1]), R(model.x[i][2]), R(0)};
      v[i] = {R(model.v[i][0]), R(model.v[i][1]), R(model.v[i][2]), R(0)};
      p[i] = {x[i].x, x[i].y, x[i].z, R(model.w[i])};
    }
    x_ = Array<Executor, Vec4<R>>(x), v_ = Array<Executor, Vec4<R>>(v), p_ = Array<Executor, Vec4<R>>(p);
    facts_.constraint_seconds = seconds([&] {
      for (const ConstraintSet& set : model.sets) batches_.push_back(make_batches<Executor, R>(executor, model, set));
      for (const PressureSet& set : model.pressures) pressures_.emplace_back(executor, model, set);
    });
    if (!model.environment.empty()) facts_.collision_seconds = seconds([&] { collider_.emplace(executor, model); });
    note_facts();
  }

  void step() override {
    const SolverSpec& solver = model_.scene.solver;
    const double h = solver.dt / solver.substeps;
    for (int s = 0; s < solver.substeps; ++s) substep(time() + s * h, h);
    ++steps_;
  }

  double time() const override { return steps_ * model_.scene.solver.dt; }
  std::int64_t steps() const override { return steps_; }
  std::vector<Vec3> positions() const override { return in_user_order(x_.download(), model_.user_of); }
  std::vector<Vec3> velocities() const override { return in_user_order(v_.download(), model_.user_of); }
  const SolverFacts& facts() const override { return facts_; }
  const std::array<double, kPassNames.size()>& pass_seconds() const override { return seconds_; }
  std::string save() const override {
    return save_state<R>(
        {steps_, x_.download(), v_.download(), collider_ ? collider_->memory() : std::vector<LastSeen>{}});
  }
  void restore(const std::string& bytes) override {
    const State<R> state = load_state<R>(bytes, x_.size(), model_.environment.size() * x_.size());
    steps_ = state.steps;
    x_.upload(state.x);
    v_.upload(state.v);
    if (collider_) collider_->remember(state.seen);
  }
  std::uint64_t state_hash() const override { return hash_state(x_.download(), v_.download(), model_.user_of); }

  Measures measure() const override {
    Measures m;
    const Vec3& g = model_.scene.gravity;
    const Motion motion =
        parallel_reduce<Motion>(executor_, model_.count(), MeasureMotion<R>{particles(), {g[0], g[1], g[2]}});
    std::copy_n(motion.momentum, 3, m.momentum.begin());
    std::copy_n(motion.angular, 3, m.angular_momentum.begin());
    m.kinetic = motion.kinetic, m.potential = motion.potential;
    m.speed_max = std::sqrt(motion.speed2_max);
    Residual lengths;
    for (const auto& batches : batches_) {
      const Residual r = batches->residual(x_.data(), p_.data());
      m.degenerate += static_cast<std::int64_t>(r.degenerate);
      if (batches->compliance() > 0) m.elastic += r.C2 / (2 * batches->compliance());
      if (batches->has_strain()) lengths += r;
    }
    m.has_strain = lengths.count > 0;
    if (m.has_strain) m.strain_rms = std::sqrt(lengths.strain2 / lengths.count), m.strain_max = lengths.strain_max;
    for (const auto& pressure : pressures_) m.volume_ratios.push_back(pressure.volume_ratio(x_.data()));
    if (collider_) {
      m.contacts = collider_->contacts();
      m.penetration_max = collider_->max_penetration(particles(), time());
    }
    return m;
  }

 private:
  Particles<R> particles() const { return {model_.count(), x_.data(), v_.data(), p_.data()}; }
  static Vector3<R> to_R(const Vec3& a) { return {R(a[0]), R(a[1]), R(a[2])}; }

  void substep(double start, double h) {
    const Scene& scene = model_.scene;
    const Particles<R> all = particles();
    const int n = model_.count();
    // Gravity is uniform: whether the rigid part of the motion is taken before or after it is the same.
    if (!model_.damped.empty())
      timed(Pass::Damping, [&] {
        for (const DampedIsland& island : model_.damped)
          damp(executor_, all, island.first, island.count,
               stiffness_per_projection(island.damping, scene.solver.substeps));
      });
    timed(Pass::Prediction, [&] {
      if (scene.wind) parallel_for(executor_, n, Drag<R>{all, R(h), R(scene.wind->drag), to_R(scene.wind->velocity)});
      parallel_for(executor_, n, Predict<R>{all, R(h), to_R(scene.gravity)});
    });
    if (collider_) timed(Pass::Collision, [&] { collider_->find(all, start, start + h); });
    for (auto& batches : batches_) batches->start_substep();
    for (auto& pressure : pressures_) pressure.start_substep();
    for (int iteration = 0; iteration < scene.solver.iterations; ++iteration) project(all);
    if (collider_) timed(Pass::Collision, [&] { collider_->hold_back(all, start, start + h); });
    timed(Pass::State, [&] { update_state(all, h); });
    if (collider_)
      timed(Pass::Contact, [&] {
        const Vec3& g = scene.gravity;
        collider_->restitute(all, 2 * h * std::sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]), h);
      });
  }

  /// Contacts last: what leaves the iteration is outside the environment.
  void project(const Particles<R>& all) {
    if (!batches_.empty())
      timed(Pass::Projection, [&] {
        for (auto& batches : batches_) batches->project(all.p);
      });
    if (!pressures_.empty())
      timed(Pass::Pressure, [&] {
        for (auto& pressure : pressures_) pressure.project(all.p);
      });
    if (collider_) timed(Pass::Contact, [&] { collider_->resolve(all); });
  }

  void update_state(const Particles<R>& all, double h) {
    const int bad = parallel_reduce<FirstIndex>(executor_, all.count, UpdateState<R>{all, R(h), R(1 / h)}).index;
    if (bad == FirstIndex{}.index) return;
    throw Diverged("step " + std::to_string(steps_ + 1) + " (t = " + std::to_string(time()) +
                   " s): " + particle_name(model_, model_.user_of[bad]) + " has no finite position any more");
  }

  template <class F>
  void timed(Pass pass, F&& work) {
    seconds_[static_cast<int>(pass)] += seconds(work);
  }

  void note_facts() {
    facts_.particle_bytes = x_.bytes() + v_.bytes() + p_.bytes();
    std::int64_t projections = static_cast<std::int64_t>(pressures_.size());
    for (const auto& batches : batches_) {
      facts_.sets.push_back(batches->facts());
      facts_.constraint_bytes += batches->facts().bytes;
      projections += batches->facts().constraints;
    }
    for (const auto& pressure : pressures_) facts_.constraint_bytes += pressure.bytes();
    if (collider_) facts_.collision_bytes = collider_->bytes();
    facts_.projections_per_step = projections * model_.scene.solver.substeps * model_.scene.solver.iterations;
  }

  Executor executor_;
  const Model& model_;
  Array<Executor, Vec4<R>> x_, v_, p_;
  std::vector<std::unique_ptr<Batches<Executor, R>>> batches_;
  std::vector<Pressure<Executor, R>> pressures_;
  std::optional<Collider<Executor, R>> collider_;
  std::int64_t steps_ = 0;
  SolverFacts facts_;
  std::array<double, kPassNames.size()> seconds_{};
};

}  // namespace malha
