// SPDX-License-Identifier: Apache-2.0
// Part of the study "size": how far off a hanging cloth is, and what it costs to have it right, from small bodies to
// large ones.
#pragma once
#include "tools/study/study.h"

namespace malha::study {

/// Rows of errors after 1 s and of the work for a strain of 1 %, a cell each.
Json size_errors(Cells& cells);
/// Adds them and their sections.
void add_size_errors(const Json& rows, Findings& findings);
/// How many cells those are.
int size_error_cells(bool quick);

}  // namespace malha::study
