#include "host/scene/constraint_kinds.h"

#include <type_traits>

#include "kernels/constraints.h"

namespace malha {

const std::vector<ConstraintKind>& constraint_kinds() {
  static const std::vector<ConstraintKind> kinds = [] {
    std::vector<ConstraintKind> all;
    for_each_constraint([&all]<class Kind>(Kind) {
      const Parameter& p = Kind::parameter;
      all.push_back({Kind::name, p.name, p.standard, p.minimum, p.minimum_allowed, Kind::material,
                     Kind::element == Element::Edges});
      if constexpr (std::is_same_v<Kind, NeoHookean>) all.back().elastic = true, all.back().parameter_max = Kind::most;
    });
    all.push_back(
        {"pressure", "volume_ratio", 1, 0, false, false, false});  // over a whole mesh: no batches, so not registered
    all.push_back({"long_range", "limit", 0, 0, true, false, false, true});  // a particle at a time: no batches either
    return all;
  }();
  return kinds;
}

}  // namespace malha
