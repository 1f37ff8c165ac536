// SPDX-License-Identifier: Apache-2.0
#include "host/scene/constraint_schema.h"

#include <algorithm>
#include <limits>

#include "kernels/constraints/constraint_registry.h"

namespace malha {

const std::vector<ConstraintSchema>& constraint_kinds() {
  static const std::vector<ConstraintSchema> kinds = [] {
    constexpr double infinite = std::numeric_limits<double>::infinity();
    std::vector<ConstraintSchema> all;
    for_each_constraint([&all]<class Kind>(Kind) {
      if (!is_of_mesh<Kind>()) return;
      if constexpr (requires { typename Kind::Isotropic; }) {  // which comes before its variant
        std::ranges::find(all, Kind::Isotropic::name, &ConstraintSchema::name)->shear = Kind::shear;
        return;
      }
      const Parameter& p = Kind::parameter;
      const Strength& s = Kind::strength;
      all.push_back({Kind::name, p.name, p.default_value, p.minimum, p.minimum_allowed, p.maximum, s.accepts_stiffness,
                     s.modulus ? s.modulus : "", s.unit ? s.unit : "", "", Kind::element == Element::Edges, true});
    });
    // These are not in the registry, because they have no batches: pressure acts on a whole mesh, long_range on one
    // particle at a time.
    all.push_back({"pressure", "volume_ratio", 1, 0, false, infinite, true, "", "", "", false, false});
    all.push_back({"long_range", "limit", 0, 0, true, infinite, false, "", "", "", false, false});
    return all;
  }();
  return kinds;
}

}  // namespace malha
