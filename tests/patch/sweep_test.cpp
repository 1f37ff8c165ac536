// SPDX-License-Identifier: Apache-2.0
#include "host/patch/sweep.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "host/base/point_array.h"
#include "kernels/forces/integrate.h"
#include "tests/constraints/some_material.h"
#include "tests/scene_builders.h"
#include "tests/self_collision/tangles.h"

namespace malha {
namespace {

/// A model's particles in the solver's form: positions, their rounding errors, and displacements of the substep.
template <class Executor, class R>
struct PlacedParticles {
  PointArray<Executor, R> x, low, d;
  PlacedParticles(const std::vector<Vec3>& places, const std::vector<Vec3>& ways)
      : x(places), low(places.size()), d(ways) {
    std::vector<Vec3> lacks = places;
    for (std::size_t i = 0; i < places.size(); ++i)
      for (int k = 0; k < 3; ++k) lacks[i][k] = kCompensated<R> ? places[i][k] - double(R(places[i][k])) : 0;
    low.upload(lacks);
  }
  Displaced<R> p() const { return {x.points(), d.points(), low.points()}; }
};

/// Reference: the same sweep, there and back, one constraint at a time in plain scalars, on particles of its own: the
/// formulas of Müller et al. 2006 and Macklin et al. 2016 along the gradients where the substep began (Ryckaert et al.
/// 1977), in the order of the plan. C and its gradient are scaled by s.
template <class R>
class ScalarSweep {
 public:
  explicit ScalarSweep(const Model& model) : model_(model), plan_(plan_patches(model)) {
    const SolverSpec& solver = model.scene.solver;
    const double h = solver.dt / solver.substeps;
    for (std::size_t s = 0; s < model.sets.size(); ++s) {
      const ConstraintSet& set = model.sets[s];
      k_.push_back(R(1 - std::pow(1 - set.stiffness, 1.0 / (2 * solver.substeps * solver.iterations))));
      alpha_.push_back(R(set.compliance.value_or(0) / (h * h)));
      lambda_.emplace_back(3 * set.count(), R(0));  // as many as the kind with the most has
      rest_.emplace_back();
      with_kind(set.type, [&]<class Kind>(Kind) {
        for (int c = 0; c < set.count(); ++c) {
          double rest[Kind::rest_values];
          rest_values<Kind>(rest_positions(model, set), c, material_of<Kind>(set, c), rest);
          rest_[s].insert(rest_[s].end(), rest, rest + Kind::rest_values);
        }
      });
    }
  }

  /// The sweep goes through all colours but the last there and back, and then through the last.
  void operator()(const PlacedParticles<Serial, R>& particles) {
    const Displaced<R> p = particles.p();
    const int last = plan_.colours() - 1;
    for (int colour = 0; colour < last; ++colour) project_colour(p, colour, true);
    for (int colour = last - 1; colour >= 0; --colour) project_colour(p, colour, false);
    project_colour(p, last, true), project_colour(p, last, false);
  }

  void start_substep() {
    for (auto& lambda : lambda_) std::fill(lambda.begin(), lambda.end(), R(0));
  }

  const PatchPlan& plan() const { return plan_; }

 private:
  /// The patches of one colour share no particles, so that their order does not matter.
  void project_colour(const Displaced<R>& p, int colour, bool there) {
    for (int k = plan_.colour_begin[colour]; k < plan_.colour_begin[colour + 1]; ++k)
      project_patch(p, plan_.patches[k], there);
  }

  void project_patch(const Displaced<R>& p, const Patch& patch, bool there) {
    origin_.assign(model_.x.size(), -1);
    for (int s = patch.segment; s < patch.segment + patch.segments; ++s)
      std::fill_n(origin_.begin() + plan_.segments[s].global, plan_.segments[s].count, plan_.segments[s].origin);
    for (int n = 0; n < patch.batches; ++n) {
      const Batch& batch = plan_.batches[patch.batch + (there ? n : patch.batches - 1 - n)];
      with_kind(model_.sets[batch.set].type, [&]<class Kind>(Kind) {
        for (int n = 0; n < batch.count; ++n)
          if (const int c = plan_.sets[batch.set].constraint[batch.slot + n]; c >= 0) project<Kind>(p, batch.set, c);
      });
    }
  }

  template <class Kind>
  void project(const Displaced<R>& all, int s, int c) {
    constexpr int n = Kind::particles;
    const ConstraintSet& set = model_.sets[s];
    const int* of = &set.particles[c * n];
    Vector3<R> x[n], p[n], d[n], grad[n], along[n];
    R w[n], scale, scale_along;
    for (int j = 0; j < n; ++j) {
      const int i = of[j];
      x[j] = all.x[i] - all.x[origin_[i]], d[j] = all.d[i], w[j] = R(model_.w[i]);
      if (kCompensated<R>) x[j] = x[j] + all.low[i];
    }
    // Gradients are computed from positions relative to the first particle.
    for (int j = n - 1; j >= 0; --j) x[j] = x[j] - x[0], p[j] = x[j] + (d[j] - d[0]);
    const R* const rest = &rest_[s][c * Kind::rest_values];
    R max_start_step = R(max_start_step_of(set.pressed, model_.scene.solver.iterations));
    const R alpha = set.softness.empty() ? alpha_[s] : alpha_[s] * R(set.softness[c]);
    const auto go = [&](const Vector3<R>(&by)[n], R times) {
      for (int j = 0; j < n; ++j)
        if (w[j] > R(0)) all.d.set(of[j], d[j] + by[j] * (w[j] * times));
    };
    if constexpr (multipliers<Kind>() > 1) {
      constexpr int m = multipliers<Kind>();
      R sums[m];
      std::copy_n(&lambda_[s][m * c], m, sums);
      Kind::step(p, x, w, rest, true, alpha, max_start_step, sums, grad);
      std::copy(sums, sums + m, &lambda_[s][m * c]);
      return go(grad, R(1));
    }
    const R C = Kind::evaluate(p, rest, true, grad, scale);
    Kind::evaluate(x, rest, true, along, scale_along);
    const auto product = [&](const Vector3<R>(&a)[n], const Vector3<R>(&b)[n]) {
      if (n == 2) return (w[0] + w[1]) * dot(a[0], b[0]);  // both gradients are opposite
      R sum = w[0] * dot(a[0], b[0]);
      for (int j = 1; j < n; ++j) sum = sum + w[j] * dot(a[j], b[j]);
      return sum;
    };
    R sum = product(grad, along);
    bool turned = false;
    if constexpr (limits_turn<Kind>())
      turned = !(R(Kind::min_turn_cosine * Kind::min_turn_cosine) * product(grad, grad) * product(along, along) <=
                 sum * sum);
    R& lambda = lambda_[s][c];  // a stiffness has no multiplier
    const R wanted = set.compliance ? -C - scale * alpha * lambda : -C * k_[s];
    // As in kernels/projection/direction.h: applied / denominator times `along`; for two particles without the size,
    // which `along` has.
    R denominator = sum, applied = std::abs(wanted), multiplier = wanted;
    if (set.compliance) {
      denominator = sum + alpha * scale * scale_along, multiplier = wanted * scale_along + lambda * denominator;
      applied = applied * scale_along + std::abs(lambda) * denominator, denominator = denominator * scale_along;
    }
    if (n == 2 && multiplier * dot(along[1], x[1]) > R(0))  // compressed
      max_start_step = R(max_compressed_start_step_of(set.pressed, model_.scene.solver.iterations));
    const R size2 = n == 2 ? R(1) : size2_of(x);
    const R step2 = n == 2 ? R(0) : max_displacement2(w, along), max_w = std::max(w[0], w[1]);
    const bool whole =
        n == 2 ? applied * max_w <= max_start_step * denominator
               : applied * applied * step2 <= max_start_step * max_start_step * size2 * denominator * denominator;
    if (turned || !(sum > R(0))) {
      sum = product(grad, grad), scale_along = scale;
      std::copy(grad, grad + n, along);
    } else if (!whole) {
      const R displacement = n == 2 ? applied * max_w : applied * std::sqrt(step2);
      const R share = max_start_step * denominator * std::sqrt(size2) / displacement, other = R(1) - share;
      sum = sum * share + product(grad, grad) * other, scale_along = scale_along * share + scale * other;
      for (int j = 0; j < n; ++j) along[j] = along[j] * share + grad[j] * other;
    }
    if (!(sum > tiny<R>())) return;
    R heaviest = 0, max_grad2 = 0;
    for (int j = 0; j < n; ++j)
      heaviest = std::max(heaviest, w[j]), max_grad2 = std::max(max_grad2, dot(along[j], along[j]));
    const R rounding = 16 * std::numeric_limits<R>::epsilon();
    if (n > 2 && !(sum > rounding * rounding * heaviest * max_grad2)) return;
    R against = set.compliance ? sum + alpha * scale * scale_along : sum;
    if constexpr (has_max_step<Kind>()) {
      R step2 = 0;
      for (int j = 0; j < n; ++j) step2 = std::max(step2, w[j] * w[j] * dot(along[j], along[j]));
      against = std::max(against, std::abs(wanted) * (std::sqrt(step2) * rest[Kind::per_max_step]));
    }
    R dlambda = wanted / against;
    if (Kind::inequality) dlambda = std::max(dlambda, set.compliance ? -lambda / scale_along : R(0));
    lambda = lambda + scale_along * dlambda;
    go(along, dlambda);
  }

  const Model& model_;
  const PatchPlan plan_;
  std::vector<R> k_, alpha_;
  std::vector<std::vector<R>> rest_, lambda_;
  std::vector<int> origin_;  // of each particle of a patch
};

/// A model's particles and its sweep, in the solver's form.
template <class Executor, class R>
struct Bench {
  const Model& model;
  Executor executor;
  PlacedParticles<Executor, R> held;
  PointArray<Executor, R> v;
  Array<Executor, R> w;
  Sweep<Executor, R> sweep;

  Bench(const Model& of, const Executor& on, int threads, const std::vector<Vec3>& ways)
      : model(of), executor(on), held(of.x, ways), v(of.v), w(weights(of)), sweep(on, of, threads) {}
  Bench(const Model& of, const Executor& on, int threads)
      : Bench(of, on, threads, std::vector<Vec3>(of.x.size(), Vec3{0, 0, 0})) {}

  static std::vector<R> weights(const Model& model) {
    std::vector<R> all(model.w.begin(), model.w.end());
    all.resize(all.size() + kSlotPack, R(0));
    return all;
  }
  double h() const { return model.scene.solver.dt / model.scene.solver.substeps; }
  Vector3<R> gravity() const {
    const Vec3& g = model.scene.gravity;
    return {R(g[0]), R(g[1]), R(g[2])};
  }
  Particles<R> particles() const { return {model.count(), held.x.points(), v.points(), held.p(), w.data()}; }
  SolvePatch<R> make_solve() const { return sweep.make_solve(particles(), h(), gravity()); }
  void run(const SolvePatch<R>& solve) const {
    sweep.region([&](const auto& team) { sweep(team, solve); });
  }
};

/// Calls f(executor, threads, name) for all executors of the host, with all instruction sets that it has.
template <class F>
void for_each_executor(const F& f) {
  for_each_isa([&]<class Isa>(Isa) {
    f(Serial{Isa::value}, 1, std::string(Isa::name) + ", serial");
    for (const int threads : {1, 2, 3})
      f(OpenMP{threads, Isa::value}, threads, std::string(Isa::name) + ", " + std::to_string(threads) + " threads");
  });
}

/// Coordinates of pins are -0: adding even a zero would change their bits.
std::vector<Vec3> random_ways(const Model& model, double size, unsigned seed) {
  Random random(seed);
  std::vector<Vec3> ways;
  for (int i = 0; i < model.count(); ++i) {
    const Vector3<double> d = random.in_cube(size);
    ways.push_back(model.w[i] > 0 ? Vec3{d.x, d.y, d.z} : Vec3{-0.0, -0.0, -0.0});
  }
  return ways;
}

void give_velocities(Model& model, double size) {
  Random random(5);
  for (int i = 0; i < model.count(); ++i) {
    const Vector3<double> v = random.in_cube(size);
    if (model.w[i] > 0) model.v[i] = {v.x, v.y, v.z};
  }
}

SolverSpec some_solver(int substeps, int iterations) {
  SolverSpec solver;
  solver.dt = 0.1, solver.substeps = substeps, solver.iterations = iterations;
  return solver;
}

/// Patches in rows (AoS): tangles with hubs and pins, with a set of each kind.
Model tangled_model(std::optional<double> compliance) {
  Random random(1);
  constexpr int particles = 800;
  std::vector<ConstraintSet> sets;
  for_each_constraint([&]<class Kind>(Kind) {
    ConstraintSet set = set_of(Kind::particles, tangle(particles, Kind::particles, particles, random, 100));
    set.type = Kind::name;
    set.parameter = Kind::parameter.default_value, set.orthotropic = some_orthotropic<Kind>();
    set.stiffness = 0.8;
    set.compliance = compliance;
    sets.push_back(set);
  });
  std::vector<bool> pinned(particles);
  for (int i = 0; i < particles; ++i) pinned[i] = random.below(20) == 0;
  Model model = model_of(sets, pinned, random, random_cuts(5, particles, random));
  model.scene.solver = some_solver(3, 2);
  return model;
}

/// Adding even a zero to these would change their bits.
void put_pins_at_minus_zero(Model& model) {
  for (int i = 0; i < model.count(); ++i)
    if (model.w[i] == 0) model.x[i][0] = -0.0;
}

/// Patches in columns (SoA): a sheet with every kind of constraint.
Model sheet_model(std::optional<double> compliance, bool with_wings = true) {
  std::vector<ConstraintSpec> constraints;
  for_each_constraint([&]<class Kind>(Kind) {
    if (!is_of_mesh<Kind>() || facts_of(Kind::element).solid || (facts_of(Kind::element).weighed && !with_wings))
      return;
    ConstraintSpec spec = constraint(name_in_scenes<Kind>(), Kind::parameter.default_value);
    if (Kind::element == Element::Edges) spec.elements = {"edges", "shear"};
    if constexpr (Kind::strength.accepts_stiffness)
      spec.stiffness = compliance ? 1 : 0.8, spec.compliance = compliance;
    else
      modulus_of(spec, Kind::strength.modulus) = 1e-4, spec.orthotropy = some_orthotropy<Kind>(1e-4);
    constraints.push_back(spec);
  });
  BodySpec sheet = body("sheet", GridShape{{1, 1}, {24, 40}}, constraints);
  sheet.pins = {ListPin{{0, 24, 400, 700}}};
  Scene scene = scene_of({sheet});
  scene.solver = some_solver(3, 2);
  return build_model(scene);
}

template <class R, class Executor>
void expect_same_as_scalar(const Model& model, double size, const Executor& executor, int threads,
                           const std::string& what) {
  const std::vector<Vec3> start = random_ways(model, size, 2);
  const Bench<Executor, R> bench(model, executor, threads, start);
  ScalarSweep<R> scalar(model);
  const PlacedParticles<Serial, R> expected(model.x, start), before(model.x, start);
  for (int substep = 0; substep < 2; ++substep) {
    scalar.start_substep();
    for (int iteration = 0; iteration < 3; ++iteration) {
      SolvePatch<R> solve = bench.make_solve();
      if (iteration == 0) solve.first = FirstIteration<R>{};
      bench.run(solve);
      scalar(expected);
    }
  }
  const Points<R> found = bench.held.d.points(), ways = expected.d.points();
  int moved = 0;
  for (int i = 0; i < model.count(); ++i) {
    ASSERT_TRUE(same_bits(found[i], ways[i])) << what << ", particle " << i;
    ASSERT_TRUE(same_bits(bench.held.x.points()[i], before.x.points()[i])) << what << ", particle " << i;
    moved += !same_bits(ways[i], before.d.points()[i]);
  }
  EXPECT_GT(moved, model.count() / 2) << what;
}

TEST(Sweep, InPacksIsBitForBitThatOfOneByOne) {
  for (const std::optional<double> compliance : {std::optional<double>(), std::optional(1e-3)}) {
    Model tangled = tangled_model(compliance), sheet = sheet_model(compliance);
    put_pins_at_minus_zero(tangled);
    const PatchPlan rows = plan_patches(tangled), columns = plan_patches(sheet);
    ASSERT_EQ(rows.columns, 0);
    ASSERT_GT(rows.colours(), 1);
    ASSERT_EQ(columns.columns, static_cast<int>(columns.patches.size()));
    ASSERT_GT(columns.patches.size(), 1u);
    for_each_executor([&](const auto& executor, int threads, const std::string& name) {
      // A cell of the sheet is 0.025 m wide: a tenth of that folds it.
      expect_same_as_scalar<float>(tangled, 0.5, executor, threads, "rows, float, " + name);
      expect_same_as_scalar<double>(tangled, 0.5, executor, threads, "rows, double, " + name);
      expect_same_as_scalar<float>(sheet, 0.002, executor, threads, "columns, float, " + name);
      expect_same_as_scalar<double>(sheet, 0.002, executor, threads, "columns, double, " + name);
    });
  }
}

TEST(Sweep, ForgetsLambdaWhenASubstepStarts) {
  const Model model = tangled_model(0.01);
  const std::vector<Vec3> start = random_ways(model, 0.5, 3);
  Bench<Serial, double> bench(model, {}, 1, start);
  const auto project = [&](bool first_iteration) {
    bench.held.d.upload(start);
    SolvePatch<double> solve = bench.make_solve();
    if (first_iteration) solve.first = FirstIteration<double>{};
    bench.run(solve);
    return bench.held.d.download();
  };
  const auto first = project(true), remembered = project(false), again = project(true);
  EXPECT_NE(first, remembered);
  EXPECT_EQ(first, again);
}

/// Some substeps in fused patch solves that predict and update, or in separate passes.
template <class R, class Executor>
Bench<Executor, R> advanced(const Model& model, const Executor& executor, int threads, bool fused) {
  Bench<Executor, R> bench(model, executor, threads);
  const Particles<R> all = bench.particles();
  const SolverSpec& solver = model.scene.solver;
  const R h = R(bench.h()), per_h = R(1 / bench.h());
  for (int s = 0; s < solver.substeps; ++s) {
    if (!fused) parallel_for(executor, model.count(), Predict<R>{all, h, bench.gravity()});
    for (int iteration = 0; iteration < solver.iterations; ++iteration) {
      SolvePatch<R> solve = bench.make_solve();
      if (iteration == 0) solve.first = FirstIteration<R>{};
      if (fused && iteration == 0) solve.first = FirstIteration<R>{PatchPrediction<R>{}};
      if (fused && iteration + 1 == solver.iterations) solve.update = bench.sweep.make_update(s + 1);
      bench.run(solve);
    }
    if (!fused) parallel_reduce<FirstIndex>(executor, model.count(), UpdateState<R>{all, h, per_h});
  }
  EXPECT_FALSE(bench.sweep.has_non_finite());
  return bench;
}

template <class R>
void expect_fused_same(const Model& model, const std::string& what) {
  const auto apart = advanced<R>(model, Serial{}, 1, false);
  for_each_executor([&](const auto& executor, int threads, const std::string& name) {
    const auto fused = advanced<R>(model, executor, threads, true);
    const std::string where = what + ", " + name + ", ";
    for (int i = 0; i < model.count(); ++i) {
      ASSERT_TRUE(same_bits(fused.held.x.points()[i], apart.held.x.points()[i])) << where << "x of " << i;
      ASSERT_TRUE(same_bits(fused.held.low.points()[i], apart.held.low.points()[i])) << where << "low of " << i;
      ASSERT_TRUE(same_bits(fused.v.points()[i], apart.v.points()[i])) << where << "v of " << i;
    }
  });
  EXPECT_NE(apart.held.x.download(), model.x) << what << ": nothing moved";
}

TEST(Sweep, ThatPredictsAndUpdatesGivesTheBitsOfSeparatePasses) {
  for (const int iterations : {1, 3}) {
    Model tangled = tangled_model(std::nullopt), sheet = sheet_model(1e-3);
    Model cloud = build_model(scene_of({body("lattice", LatticeShape{{0, 0, 0}, {1, 1, 1}, {9, 9, 21}})}));
    for (Model* model : {&tangled, &sheet, &cloud}) {
      model->scene.solver = some_solver(4, iterations);
      model->scene.gravity = {0.1, -9.81, 0.2};
      give_velocities(*model, 0.1);
      const std::string what = model == &tangled ? "rows" : model == &sheet ? "columns" : "no constraints";
      expect_fused_same<float>(*model, what + ", float, " + std::to_string(iterations) + " iterations");
      expect_fused_same<double>(*model, what + ", double, " + std::to_string(iterations) + " iterations");
    }
  }
}

TEST(Sweep, LeavesPinnedParticlesAsTheyWere) {
  Model model = tangled_model(std::nullopt);
  put_pins_at_minus_zero(model);
  give_velocities(model, 0.1);
  const auto bench = advanced<float>(model, OpenMP{2}, 2, true);
  const std::vector<Vec3> v = bench.v.download();
  int pinned = 0;
  for (int i = 0; i < model.count(); ++i) {
    if (model.w[i] > 0) continue;
    ++pinned;
    const Vector3<float> expected{float(model.x[i][0]), float(model.x[i][1]), float(model.x[i][2])};
    EXPECT_TRUE(same_bits(bench.held.x.points()[i], expected)) << i;
    EXPECT_EQ(v[i], (Vec3{0, 0, 0})) << i;
  }
  EXPECT_GT(pinned, 20);
}

TEST(Sweep, NamesTheNonFiniteParticleAndItsSubstep) {
  for_each_executor([&](const auto& executor, int threads, const std::string& name) {
    for (const int lost : {0, 5, 801, -1700}) {
      const bool slanted = lost < 0;  // finite coordinates, but not their sum
      Model model = build_model(scene_of({body("lattice", LatticeShape{{0, 0, 0}, {1, 1, 1}, {9, 9, 21}})}));
      const int i = std::abs(lost), first = slanted ? 2 : 4;  // at 1e38 m a substep
      model.v[i][1] = 1e30;                                   // a float's range ends at 3.4e38
      if (slanted) model.v[i] = {1e30, 1e30, 1e30};
      model.scene.solver.dt = 1e8, model.scene.solver.substeps = 1;
      Bench<std::decay_t<decltype(executor)>, float> bench(model, executor, threads);
      EXPECT_EQ(bench.sweep.first_non_finite(bench.held.x.download(), model.user_index), -1);
      for (int substep = 1; substep <= 5; ++substep) {
        SolvePatch<float> solve = bench.make_solve();
        solve.first = FirstIteration<float>{PatchPrediction<float>{}};
        solve.update = bench.sweep.make_update(substep);
        bench.run(solve);
        EXPECT_EQ(bench.sweep.has_non_finite(), substep >= first) << name << ", substep " << substep;
      }
      EXPECT_EQ(bench.sweep.first_non_finite(bench.held.x.download(), model.user_index), model.user_index[i]) << name;
    }
  });
}

TEST(Sweep, ReportsItsPatchesAndItsMemory) {
  const Model model = sheet_model(std::nullopt, false);
  const PatchPlan plan = plan_patches(model);
  const Sweep<Serial, float> sweep({}, model, 1);
  EXPECT_EQ(sweep.facts().patches, static_cast<int>(plan.patches.size()));
  EXPECT_EQ(sweep.facts().colours, plan.colours());
  EXPECT_EQ(sweep.facts().columns, plan.columns);
  EXPECT_EQ(sweep.facts().shared, plan.shared);
  EXPECT_EQ(sweep.facts().most_slots, plan.most_slots);
  ASSERT_EQ(sweep.set_facts().size(), model.sets.size());
  for (std::size_t s = 0; s < model.sets.size(); ++s) {
    const SetStats& facts = sweep.set_facts()[s];
    EXPECT_EQ(facts.type, model.sets[s].type);
    EXPECT_EQ(facts.constraints, model.sets[s].count());
    EXPECT_EQ(facts.in_runs, plan.sets[s].in_runs);
    EXPECT_EQ(facts.most_batches, plan.sets[s].most_batches);
    // All rest values of a sheet's runs are equal: a bit a slot, and the values once. Gathered constraints have rest
    // values and particles. With compliance there are multipliers, because there is more than one iteration.
    std::size_t numbers = 0, sums = 0;
    for_each_constraint([&]<class Kind>(Kind) {
      if (model.sets[s].type != Kind::name) return;
      numbers = Kind::rest_values + facts_of(Kind::element).weighed;
      sums = model.sets[s].compliance ? multipliers<Kind>() : 0;
    });
    const auto runs = std::count_if(plan.batches.begin(), plan.batches.end(),
                                    [&](const Batch& batch) { return batch.set == static_cast<int>(s) && batch.run; });
    const std::size_t slots = plan.sets[s].constraint.size(), gathered = plan.sets[s].index[0].size();
    EXPECT_EQ(facts.bytes, (slots - gathered) / 8 + (runs + gathered) * numbers * sizeof(float) +
                               gathered * model.sets[s].arity * sizeof(LocalIndex) + slots * sums * sizeof(float));
  }
}

TEST(StiffnessPerProjection, ComposesToTheStiffness) {
  for (const double k : {0.0, 0.3, 1.0})
    for (const int n : {1, 10, 1000}) {
      const double per = stiffness_per_projection(k, n);
      EXPECT_NEAR(std::pow(1 - per, n), 1 - k, 1e-13);
      EXPECT_GE(per, 0);
      EXPECT_LE(per, 1);
    }
}

}  // namespace
}  // namespace malha
