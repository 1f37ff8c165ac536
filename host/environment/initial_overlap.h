// SPDX-License-Identifier: Apache-2.0
// Initial overlap of bodies with solids and one-sided sheets of the environment.
#pragma once
#include "host/model/model.h"

namespace malha {

/// Adds notes to model.notes on bodies that start behind a one-sided sheet and will be affected: with particles that
/// contact would move in front of it in the first step, or that lie behind it by less than its thickness and stay so,
/// or with edges through it, whose ends contact would separate. Bodies that are wholly behind it and away from it, or
/// beside its boundary, are allowed.
void note_starts_behind(Model& model);

inline constexpr double kNegligibleDepth =
    0.01;  // of the thickness: a smaller depth inside or behind a surface is ignored

/// Throws InputError if a movable particle of a body starts deeper in a solid than the solid's thickness. If the solid
/// says push_out, the whole body is moved out instead, rigidly and without velocity, and model.notes says by how much;
/// this also throws for a body with pins, one for which no way out is found, and one that then intersects another body.
/// A body that is inside by less stays so, with a note.
void start_outside(Model& model);

}  // namespace malha
