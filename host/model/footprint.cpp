#include "host/model/footprint.h"

namespace malha {

namespace {

/// Calls visit(array) for every array of the model.
template <class M, class Visit>
void for_each_array(M& model, const Visit& visit) {
  auto& look = model.look;
  visit(look.points), visit(look.faces), visit(look.lines);
  visit(look.body_begin), visit(look.face_begin), visit(look.line_begin);
  visit(model.user_of), visit(model.x), visit(model.v), visit(model.w), visit(model.mass);
  for (auto* sets : {&model.sets, &model.stencils})
    for (auto& set : *sets) visit(set.particles), visit(set.softness);
  for (auto& set : model.springs) visit(set.ends), visit(set.stiffness), visit(set.rest);
  for (auto& set : model.pressures) visit(set.particles), visit(set.triangles);
  for (auto& body : model.tetrahedra) visit(body);
  visit(model.damped), visit(model.free);
  visit(model.long_range.particle), visit(model.long_range.begin);
  visit(model.long_range.anchor), visit(model.long_range.reach);
  visit(model.air.particle), visit(model.air.begin), visit(model.air.around);
  visit(model.air.faces);
  for (auto& pins : model.moved) visit(pins.particles);
  for (auto& set : model.attached) visit(set.particles);
  visit(model.patches.begin), visit(model.patches.class_of);
  for (auto& environment : model.environment)
    visit(environment.mesh.points), visit(environment.mesh.faces), visit(environment.mesh.lines);
}

}  // namespace

std::size_t bytes(const Model& model) {
  std::size_t sum = 0;
  for_each_array(model, [&sum](const auto& array) { sum += array.capacity() * sizeof(array[0]); });
  return sum;
}

void keep_what_runs_need(Model& model) {
  model.v = {}, model.mass = {}, model.patches = {}, model.long_range = {}, model.air = {};
  for_each_array(model, [](auto& array) { array.shrink_to_fit(); });
}

}  // namespace malha
