// What a scene asks for between the prediction and the new state of a substep, beside its batched constraints.
#pragma once
#include "host/model/model.h"

namespace malha {

inline bool asks_contacts_at_most(const Model& model) {
  return model.pressures.empty() && model.attached.empty() && model.long_range.items() == 0 &&
         !model.scene.self_collision;
}
inline bool asks_nothing_between(const Model& model) {
  return model.environment.empty() && asks_contacts_at_most(model);
}

}  // namespace malha
