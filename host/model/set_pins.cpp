// SPDX-License-Identifier: Apache-2.0
#include "host/model/set_pins.h"

#include <algorithm>

#include "malha/error.h"

namespace malha {

std::vector<int> static_pins(const Model& model) {
  std::vector<bool> is_static(model.w.size());
  for (std::size_t i = 0; i < is_static.size(); ++i) is_static[i] = !(model.w[i] > 0);
  for (const MovedPins& pins : model.moved)
    for (const int i : pins.particles) is_static[i] = false;
  std::vector<int> list;
  for (std::size_t i = 0; i < is_static.size(); ++i)
    if (is_static[i]) list.push_back(model.user_index[i]);
  std::sort(list.begin(), list.end());
  return list;
}

std::vector<bool> has_keyframes(const Model& model) {
  std::vector<bool> moves(model.user_index.size(), false);
  for (const MovedPins& pins : model.moved)
    for (const int i : pins.particles) moves[model.user_index[i]] = pins.target.moves();
  return moves;
}

Scene with_pins(const Model& model, const std::vector<int>& particles) {
  std::vector<bool> in_other_pin(model.user_index.size(), false);
  for (const MovedPins& pins : model.moved)
    for (const int i : pins.particles) in_other_pin[model.user_index[i]] = true;
  for (const int i : particles) {
    if (i < 0 || i >= model.count())
      refuse("pins", "", "particle " + std::to_string(i), "0 to " + std::to_string(model.count() - 1));
    if (in_other_pin[i])
      refuse(
          "pins", "",
          particle_name(model, i) + ", which an attachment or a pin on keyframes or with a release holds or has held",
          "others");
  }
  const std::vector<int> before = static_pins(model);
  Scene scene = model.scene;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const auto of_body = [&](const std::vector<int>& all) {
      return std::vector<int>(std::lower_bound(all.begin(), all.end(), model.render_mesh.body_begin[b]),
                              std::lower_bound(all.begin(), all.end(), model.render_mesh.body_begin[b + 1]));
    };
    std::vector<int> list = of_body(particles);
    if (list == of_body(before)) continue;  // keep its selectors
    for (int& i : list) i = number_in_body(model, i);
    std::erase_if(scene.bodies[b].pins, [](const Pin& pin) { return pin.motion.empty() && !pin.release_time; });
    if (!list.empty()) scene.bodies[b].pins.push_back(ListPin{list});
  }
  return scene;
}

}  // namespace malha
