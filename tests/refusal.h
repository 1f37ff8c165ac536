// SPDX-License-Identifier: Apache-2.0
// What a refusal says.
#pragma once
#include <string>

#include "malha/error.h"

namespace malha {

/// What the InputError said that `act` threw; "" where it threw none.
template <class Act>
std::string refusal(const Act& act) {
  try {
    act();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace malha
