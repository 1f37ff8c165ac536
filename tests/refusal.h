// SPDX-License-Identifier: Apache-2.0
// Messages of refusals, for tests.
#pragma once
#include <string>

#include "malha/error.h"

namespace malha {

/// The message of the InputError that `act` throws; "" if it throws none.
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
