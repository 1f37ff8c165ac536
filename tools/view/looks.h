// SPDX-License-Identifier: Apache-2.0
// What a look needs to know of a model: made by the solver's thread when it is first asked for, used by the window's.
#pragma once
#include <array>
#include <memory>

#include "host/fields/contacts.h"
#include "host/fields/fields.h"
#include "host/fields/forces.h"
#include "tools/view/shown_state.h"

namespace malha::view {

enum class Look { Bodies, Strain, Speed, Residual, Contact, Patch, Phase, Batch, Force };
inline constexpr std::array kLookNames{"bodies",  "strain", "speed",   "residual",      "contacts",
                                       "patches", "phases", "batches", "forces on pins"};

/// Of the bodies of a frame; each part is there once it was asked for.
struct Looks {
  std::shared_ptr<const Body> body;
  std::shared_ptr<const Strains> strains;
  std::shared_ptr<const Residuals> residuals;
  std::shared_ptr<const Structure> structure;
  std::shared_ptr<const Contacts> contacts;
  std::shared_ptr<const PinForces> forces;
};

}  // namespace malha::view
