// SPDX-License-Identifier: Apache-2.0
#include "host/model/ordering/renumber.h"

#include <algorithm>

namespace malha {

void renumber(Model& model, const std::vector<int>& order) {
  std::vector<int> now(order.size());
  for (std::size_t i = 0; i < now.size(); ++i) now[order[i]] = static_cast<int>(i);
  const auto reorder = [&](auto& values) {
    auto sorted = values;
    for (std::size_t i = 0; i < now.size(); ++i) sorted[i] = values[order[i]];
    values = std::move(sorted);
  };
  reorder(model.user_index), reorder(model.x), reorder(model.v), reorder(model.w), reorder(model.mass);
  const auto remap = [&](int& i) { i = now[i]; };
  for (ConstraintSet& set : model.sets) std::for_each(set.particles.begin(), set.particles.end(), remap);
  for (ConstraintSet& set : model.stencils) std::for_each(set.particles.begin(), set.particles.end(), remap);
  for (SpringSet& set : model.springs)
    for (Edge& e : set.ends) std::for_each(e.begin(), e.end(), remap);
  for (auto& body : model.tetrahedra)
    for (Tetrahedron& t : body) std::for_each(t.begin(), t.end(), remap);
  for (PressureSet& set : model.pressures) {
    for (Triangle& t : set.triangles) std::for_each(t.begin(), t.end(), remap);
    std::for_each(set.particles.begin(), set.particles.end(), remap);
    std::sort(set.particles.begin(), set.particles.end());
  }
  for (std::vector<int>* list : {&model.long_range.particle, &model.long_range.anchor, &model.air.particle})
    std::for_each(list->begin(), list->end(), remap);
  for (Quad& face : model.air.faces)
    for (int& corner : face)
      if (corner >= 0) remap(corner);
  for (MovedPins& pins : model.moved) std::for_each(pins.particles.begin(), pins.particles.end(), remap);
  for (AttachmentSet& set : model.attached) std::for_each(set.particles.begin(), set.particles.end(), remap);
}

}  // namespace malha
