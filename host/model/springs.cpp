// SPDX-License-Identifier: Apache-2.0
#include "host/model/springs.h"

#include <algorithm>

#include "host/mesh/vectors.h"
#include "host/model/model.h"
#include "host/model/stencils.h"

namespace malha {

SpringSet springs_of(const ConstraintSpec& spec, double full, const std::vector<int>& particles,
                     const std::vector<double>& softness, const std::vector<Vec3>& X) {
  SpringSet set{spec.type, {}, {}, {}};
  for (std::size_t c = 0; c < particles.size() / 2; ++c) {
    const Edge ends{particles[2 * c], particles[2 * c + 1]};
    if (ends[0] == ends[1]) continue;
    const double alpha = spec.rigidity ? softness[c] / *spec.rigidity : spec.compliance.value_or(0);
    const double k = alpha > 0 ? 1 / alpha : spec.compliance || spec.rigidity ? full : spec.stiffness * full;
    if (!(k > 0)) continue;
    set.ends.push_back(ends), set.stiffness.push_back(k);
    set.rest.push_back(spec.parameter * distance(X[ends[0]], X[ends[1]]));
  }
  return set;
}

void soften_by_levers(ConstraintSet& set, double full, const std::vector<Vec3>& X) {
  std::vector<int> kept;
  set.compliance = 1, set.softness.clear();
  with_stencil(set, [&]<class Kind, class Stencil>(Kind, Stencil) {
    if constexpr (Kind::strength.accepts_stiffness)
      for (int c = 0; c < set.count(); ++c) {
        const int* of = &set.particles[std::size_t(c) * set.arity];
        Vector3<double> q[Kind::particles];
        corners<Kind>(X.data(), of, q);
        const double lever = Stencil::lever(q), k = set.stiffness * full * lever * lever;
        if (!(k > 0)) continue;
        set.softness.push_back(1 / k);
        kept.insert(kept.end(), of, of + set.arity);
      }
  });
  set.particles = std::move(kept);
}

SpringSet linear_part(const Model& model) {
  struct Pair {
    Edge ends;
    double stiffness;
  };
  std::vector<Pair> all;
  for_each_stencil(model, [&](const auto& stencil) {
    for (const auto& c : stencil.weights)
      for (int i = 0; i < stencil.n; ++i)
        for (int j = 0; j < i; ++j) {
          const int a = stencil.particles[i], b = stencil.particles[j];
          if (a != b && c[i] * c[j] != 0)
            all.push_back({{std::min(a, b), std::max(a, b)}, -c[i] * c[j] / stencil.alpha});
        }
  });
  std::stable_sort(all.begin(), all.end(), [](const Pair& a, const Pair& b) { return a.ends < b.ends; });
  SpringSet sum{"", {}, {}, {}};
  for (const Pair& pair : all)
    if (!sum.ends.empty() && sum.ends.back() == pair.ends)
      sum.stiffness.back() += pair.stiffness;
    else
      sum.ends.push_back(pair.ends), sum.stiffness.push_back(pair.stiffness);
  sum.rest.assign(sum.ends.size(), 0);
  return sum;
}

}  // namespace malha
