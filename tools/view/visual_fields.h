// SPDX-License-Identifier: Apache-2.0
// Data of visual fields: computed by the solver's thread when first requested, used by the window's thread.
#pragma once
#include <array>
#include <memory>

#include "host/fields/contacts.h"
#include "host/fields/fields.h"
#include "host/fields/forces.h"
#include "tools/view/shown_state.h"

namespace malha::view {

enum class VisualField { Bodies, Strain, Speed, Residual, Contact, Patch, PatchColour, Batch, Force };
inline constexpr std::array kVisualFieldNames{
    "bodies", "strain", "speed", "residual", "contacts", "patches", "colours of patches", "batches", "forces on pins"};

/// Visual fields of the bodies of a frame; each is set once it was requested.
struct VisualFields {
  std::shared_ptr<const Body> body;
  std::shared_ptr<const Strains> strains;
  std::shared_ptr<const Residuals> residuals;
  std::shared_ptr<const Structure> structure;
  std::shared_ptr<const Contacts> contacts;
  std::shared_ptr<const PinForces> forces;
};

}  // namespace malha::view
