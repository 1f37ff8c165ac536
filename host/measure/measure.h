// SPDX-License-Identifier: Apache-2.0
// Measures of a state, for reports and expectations.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "host/measure/strain.h"
#include "host/model/model.h"
#include "host/model/seams.h"
#include "kernels/constraints/constraint_registry.h"
#include "kernels/measure/energies.h"
#include "kernels/projection/rest.h"
#include "malha/measures.h"

namespace malha {

/// Momenta, kinetic and potential energy, and the largest speed.
template <class Executor, class R>
Measures measure_motion(const Executor& executor, const Particles<R>& particles, const Vec3& g) {
  const Motion motion =
      parallel_reduce<Motion>(executor, particles.count, MeasureMotion<R>{particles, {g[0], g[1], g[2]}});
  Measures m;
  std::copy_n(motion.momentum, 3, m.momentum.begin());
  const auto& [cx, cy, cz] = motion.moment;  // times the mass: the centre of mass
  const auto& [px, py, pz] = motion.momentum;
  if (motion.mass > 0)
    m.angular_momentum = {motion.angular[0] - (cy * pz - cz * py) / motion.mass,
                          motion.angular[1] - (cz * px - cx * pz) / motion.mass,
                          motion.angular[2] - (cx * py - cy * px) / motion.mass};
  m.kinetic = motion.kinetic, m.potential = motion.potential;
  m.speed_max = std::sqrt(motion.speed2_max);
  return m;
}

/// Adds the elastic energy and degenerate constraints of a set, and its strain to `lengths`.
template <class Executor>
void measure_set(const Executor& executor, const Model& model, const ConstraintSet& set, const std::vector<Vec3>& x,
                 Measures& m, Residual& lengths) {
  if (set.per_closing > 0) return;  // of seams, see measure_seams()
  with_kind(set.type, [&]<class Kind>(Kind) {
    const double* softness = set.softness.empty() ? nullptr : set.softness.data();
    const int* particles = set.particles.data();
    const Residual r =
        parallel_reduce<Residual>(executor, set.count(),
                                  MeasureResidual<Kind, Vec3>{rest_positions(model, set), x.data(), model.w.data(),
                                                              particles, materials_of<Kind>(set), softness});
    m.degenerate += static_cast<std::int64_t>(r.degenerate);
    if constexpr (multipliers<Kind>() > 1)
      m.elastic += parallel_reduce<Sum>(executor, set.count(),
                                        MeasureEnergy<Kind, Vec3>{rest_positions(model, set), x.data(), particles,
                                                                  materials_of<Kind>(set), softness})
                       .value /
                   *set.compliance;
    else if (set.compliance.value_or(0) > 0)
      m.elastic += r.softened / (2 * *set.compliance);
    if (set.type == Distance::name) lengths += r;
  });
}

/// Adds the gap of seams and their elastic energy at x (the solver's order) and a time, s.
inline void measure_seams(const Model& model, const std::vector<Vec3>& x, double time, Measures& m) {
  for (const ConstraintSet& set : model.sets) {
    if (!is_seam(set)) continue;
    m.has_seams = true;
    with_kind(set.type, [&]<class Kind>(Kind) {
      const double factor = closing_factor(set.per_closing, time);
      for (int c = 0; c < set.count(); ++c) {
        double rest[Kind::rest_values], gap = 0;
        rest_values<Kind>(rest_positions(model, set), c, material_of<Kind>(set, c), rest);
        Vector3<double> q[Kind::particles], grad[Kind::particles];
        corners<Kind>(x.data(), &set.particles[std::size_t(c) * Kind::particles], q);
        Kind::evaluate(q, rest, true, grad, gap);  // the scale of these kinds is the gap
        m.max_seam_gap = std::max(m.max_seam_gap, gap);
        const double C = gap - rest[0] * factor;
        if (set.alpha(c) > 0) m.elastic += C * C / (2 * set.alpha(c));
      }
    });
  }
}

/// Runs of `distance` constraints of one set and one body, which are consecutive in their set.
inline std::vector<LengthRun> length_runs(const Model& model) {
  std::vector<LengthRun> runs;
  const std::vector<int> body = bodies_of(model);
  const auto add = [&](int set, bool springs, int count, const int* ends) {
    for (int c = 0; c < count; ++c) {
      if (c == 0 || runs.back().body != body[ends[2 * c]]) runs.push_back({set, springs, c, 0, body[ends[2 * c]]});
      ++runs.back().count;
    }
  };
  for (std::size_t s = 0; s < model.sets.size(); ++s)
    if (const ConstraintSet& set = model.sets[s]; set.type == Distance::name)
      add(static_cast<int>(s), false, set.count(), set.particles.data());
  for (std::size_t s = 0; s < model.springs.size(); ++s)
    if (const SpringSet& set = model.springs[s]; set.type == Distance::name && !set.ends.empty())
      add(static_cast<int>(s), true, static_cast<int>(set.ends.size()), set.ends[0].data());
  return runs;
}

/// Measures the strains of those runs.
template <class Executor>
void sample_strains(const Executor& executor, const Model& model, const std::vector<LengthRun>& runs,
                    const std::vector<Vec3>& x, StrainSample& sample) {
  sample.largest = sample.beyond = 0, sample.particle = -1, sample.rms.clear();
  for (const LengthRun& run : runs) {
    const auto set = static_cast<std::size_t>(run.set);
    const int* ends = run.springs ? model.springs[set].ends[0].data() : model.sets[set].particles.data();
    const double* rest = run.springs ? model.springs[set].rest.data() + run.first : nullptr;
    const std::size_t first = std::size_t(2) * run.first;
    ends += first;
    const double scale = run.springs ? 1 : model.sets[set].parameter;
    const bool has_scales = !run.springs && !model.sets[set].parameters.empty();
    const double* const scales = has_scales ? model.sets[set].parameters.data() + run.first : nullptr;
    const bool has_own = !run.springs && !model.sets[set].rest_corners.empty();
    const Vec3* const own = has_own ? &model.sets[set].rest_corners[first] : nullptr;
    const auto sum = parallel_reduce<LengthSum>(
        executor, run.count, MeasureLength<Vec3>{model.x.data(), x.data(), ends, scale, scales, rest, own});
    sample.rms.push_back(std::sqrt(sum.strain2 / run.count));
    if (sum.most > sample.largest) sample.largest = sum.most, sample.particle = model.user_index[ends[2 * sum.at]];
  }
}

/// Strain, elastic energy and degenerate constraints and springs at x (the solver's order).
template <class Executor>
void measure_constraints(const Executor& executor, const Model& model, const std::vector<Vec3>& x, Measures& m) {
  Residual lengths;
  for (const std::vector<ConstraintSet>* sets : {&model.sets, &model.stencils})
    for (const ConstraintSet& set : *sets) measure_set(executor, model, set, x, m, lengths);
  for (const SpringSet& set : model.springs) {
    const SpringSum sum = parallel_reduce<SpringSum>(
        executor, static_cast<int>(set.ends.size()),
        MeasureSpring<Vec3, Edge>{x.data(), set.ends.data(), set.stiffness.data(), set.rest.data()});
    m.elastic += sum.energy;
    m.degenerate += static_cast<std::int64_t>(sum.lengths.degenerate);
    if (set.type == Distance::name) lengths += sum.lengths;
  }
  m.has_strain = lengths.count > 0;
  if (m.has_strain) m.strain_rms = std::sqrt(lengths.strain2 / lengths.count), m.strain_max = lengths.strain_max;
}

/// Volume and number of inverted tetrahedra of all bodies at x.
template <class Executor>
void measure_tetrahedra(const Executor& executor, const Model& model, const std::vector<Vec3>& x, Measures& m) {
  for (const std::vector<Tetrahedron>& body : model.tetrahedra) {
    const Volumes sum =
        parallel_reduce<Volumes>(executor, static_cast<int>(body.size()),
                                 MeasureVolume<Vec3>{model.at_rest().data(), x.data(), body.front().data()});
    m.has_tetrahedra = true;
    m.volume_ratios.push_back(sum.now / sum.at_rest);
    m.inverted_tetrahedra += static_cast<std::int64_t>(sum.inverted);
  }
}

}  // namespace malha
