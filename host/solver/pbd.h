// Position Based Dynamics (Müller et al. 2006) with XPBD's compliance (Macklin et al. 2016) and substeps (Macklin et
// al. 2019), for any executor and precision. A pass that the scene does not name does not exist here.
#pragma once
#include <cmath>
#include <optional>
#include <vector>

#include "host/base/point_array.h"
#include "host/base/stopwatch.h"
#include "host/collision/collider.h"
#include "host/error.h"
#include "host/solver/damping.h"
#include "host/solver/pressure.h"
#include "host/solver/solver.h"
#include "host/solver/state.h"
#include "host/solver/sweep.h"
#include "kernels/integrate.h"
#include "kernels/measure.h"

namespace malha {

template <class Executor, class R>
class Pbd final : public Solver {
 public:
  /// `threads`: of the executor.
  Pbd(const Model& model, const Executor& executor, int threads) : executor_(executor), model_(model) {
    facts_.layout_seconds = seconds([&] { lay_out_particles(); });
    facts_.constraint_seconds = seconds([&] {
      sweep_.emplace(executor, model, threads, nothing_between() && model.scene.solver.iterations > 1);
      for (const PressureSet& set : model.pressures) pressures_.emplace_back(executor, model, set);
    });
    facts_.colour_seconds = sweep_->facts().plan_seconds;
    facts_.layout_seconds += facts_.constraint_seconds - facts_.colour_seconds;
    if (!model.environment.empty()) facts_.collision_seconds = seconds([&] { collider_.emplace(executor, model); });
    note_facts();
  }

  void step() override {
    const SolverSpec& solver = model_.scene.solver;
    const double h = solver.dt / solver.substeps;
    if (nothing_between() && model_.damped.empty() && !model_.scene.wind)
      timed(Pass::Visits, [&] { visit_patches(h, solver.substeps); });
    else
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
    State<R> all = state();
    if (collider_) all.seen = collider_->memory();
    return save_state(all);
  }
  void restore(const std::string& bytes) override {
    const State<R> saved = load_state<R>(bytes, x_.size(), model_.environment.size() * x_.size());
    steps_ = saved.steps;
    x_.upload(saved.x);
    v_.upload(saved.v);
    if (collider_) collider_->remember(saved.seen);
  }
  std::uint64_t state_hash() const override { return hash_state(state(), model_.user_of); }

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
    const std::vector<Vec3> x = x_.download();
    for (const ConstraintSet& set : model_.sets)
      for_each_constraint([&]<class Kind>(Kind) {
        if (set.type != Kind::name) return;
        const Residual r =
            parallel_reduce<Residual>(executor_, set.count(),
                                      MeasureResidual<Kind, Vec3>{model_.x.data(), x.data(), model_.w.data(),
                                                                  set.particles.data(), set.parameter});
        m.degenerate += static_cast<std::int64_t>(r.degenerate);
        if (set.compliance.value_or(0) > 0) m.elastic += r.C2 / (2 * *set.compliance);
        if (Kind::has_strain) lengths += r;
      });
    m.has_strain = lengths.count > 0;
    if (m.has_strain) m.strain_rms = std::sqrt(lengths.strain2 / lengths.count), m.strain_max = lengths.strain_max;
    for (const auto& pressure : pressures_) m.volume_ratios.push_back(pressure.volume_ratio(x_.points()));
    if (collider_) {
      m.contacts = collider_->contacts();
      m.penetration_max = collider_->max_penetration(particles(), time());
    }
    return m;
  }

 private:
  void lay_out_particles() {
    x_ = PointArray<Executor, R>(model_.x), v_ = PointArray<Executor, R>(model_.v),
    p_ = PointArray<Executor, R>(model_.x);
    std::vector<R> w(model_.w.begin(), model_.w.end());
    w.resize(w.size() + kSlotPack);  // a pack that starts at the last particle stays inside
    w_ = Array<Executor, R>(w);
  }

  Particles<R> particles() const { return {model_.count(), x_.points(), v_.points(), p_.points(), w_.data()}; }
  State<R> state() const {
    return {steps_, x_.template download<std::array<R, 3>>(), v_.template download<std::array<R, 3>>(), {}};
  }
  /// Without -0, which packs do not keep either.
  static Vector3<R> to_R(const Vec3& a) { return {R(a[0] + 0), R(a[1] + 0), R(a[2] + 0)}; }

  /// Whether the scene asks for anything between prediction and state but batched constraints.
  bool nothing_between() const { return model_.environment.empty() && model_.pressures.empty(); }

  /// Substeps of prediction, projection and state in one parallel region.
  void visit_patches(double h, int substeps) {
    const int iterations = model_.scene.solver.iterations;
    const Visit<R> plain = sweep_->visit(particles(), h, to_R(model_.scene.gravity));
    sweep_->region([&](const auto& team) {
      for (int s = 0; s < substeps; ++s)
        for (int iteration = 0; iteration < iterations; ++iteration) {
          Visit<R> visit = plain;
          visit.predicts = visit.fresh = iteration == 0;
          visit.updates = iteration + 1 == iterations;
          visit.substep = s + 1;
          (*sweep_)(team, visit);
        }
    });
    if (sweep_->lost()) refuse_lost(sweep_->first_lost(x_.download(), model_.user_of));
  }

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
    if (scene.wind)
      timed(Pass::Prediction, [&] {
        parallel_for(executor_, n, Drag<R>{all, R(h), R(scene.wind->drag), to_R(scene.wind->velocity)});
      });
    if (nothing_between()) return timed(Pass::Visits, [&] { visit_patches(h, 1); });
    timed(Pass::Prediction, [&] { parallel_for(executor_, n, Predict<R>{all, R(h), to_R(scene.gravity)}); });
    if (collider_) timed(Pass::Collision, [&] { collider_->find(all, start, start + h); });
    for (auto& pressure : pressures_) pressure.start_substep();
    for (int iteration = 0; iteration < scene.solver.iterations; ++iteration) project(all, h, iteration == 0);
    if (collider_) timed(Pass::Collision, [&] { collider_->hold_back(all, start, start + h); });
    timed(Pass::State, [&] {
      const int lost = parallel_reduce<FirstIndex>(executor_, n, UpdateState<R>{all, R(h), R(1 / h)}).index;
      if (lost != FirstIndex{}.index) refuse_lost(model_.user_of[lost]);
    });
    if (collider_)
      timed(Pass::Contact, [&] {
        const Vec3& g = scene.gravity;
        collider_->restitute(all, 2 * h * std::sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]), h);
      });
  }

  /// Contacts last: what leaves the iteration is outside the environment.
  void project(const Particles<R>& all, double h, bool fresh) {
    if (!model_.sets.empty())
      timed(Pass::Projection, [&] {
        Visit<R> visit = sweep_->visit(all, h, to_R(model_.scene.gravity));
        visit.fresh = fresh;
        sweep_->region([&](const auto& team) { (*sweep_)(team, visit); });
      });
    if (!pressures_.empty())
      timed(Pass::Pressure, [&] {
        for (auto& pressure : pressures_) pressure.project(all.p, all.w);
      });
    if (collider_) timed(Pass::Contact, [&] { collider_->resolve(all); });
  }

  /// `lost`: a particle that is no longer finite, by the user's number.
  void refuse_lost(int lost) const {
    throw Diverged("step " + std::to_string(steps_ + 1) + " (t = " + std::to_string(time()) +
                   " s): " + particle_name(model_, lost) + " has no finite position any more");
  }

  template <class F>
  void timed(Pass pass, F&& work) {
    seconds_[static_cast<int>(pass)] += seconds(work);
  }

  void note_facts() {
    facts_.particle_bytes = x_.bytes() + v_.bytes() + p_.bytes() + w_.bytes();
    facts_.patches = sweep_->facts();
    facts_.fused = nothing_between();
    for_each_isa([&]<class Isa>(Isa) {
      if (executor_.instructions == Isa::value) facts_.instructions = Isa::name;
    });
    facts_.sets = sweep_->set_facts();
    std::int64_t projections = static_cast<std::int64_t>(pressures_.size());
    for (const SetFacts& set : facts_.sets) {
      facts_.constraint_bytes += set.bytes;
      projections += set.constraints;
    }
    for (const auto& pressure : pressures_) facts_.constraint_bytes += pressure.bytes();
    if (collider_) facts_.collision_bytes = collider_->bytes();
    facts_.projections_per_step = projections * model_.scene.solver.substeps * model_.scene.solver.iterations;
  }

  Executor executor_;
  const Model& model_;
  PointArray<Executor, R> x_, v_, p_;
  Array<Executor, R> w_;
  std::optional<Sweep<Executor, R>> sweep_;
  std::vector<Pressure<Executor, R>> pressures_;
  std::optional<Collider<Executor, R>> collider_;
  std::int64_t steps_ = 0;
  SolverFacts facts_;
  std::array<double, kPassNames.size()> seconds_{};
};

}  // namespace malha
