// SPDX-License-Identifier: Apache-2.0
// Part of the study "size": error of a hanging cloth, the cost of a given strain, and the error of bending, from small
// bodies to large ones.
#pragma once
#include "tools/study/study.h"

namespace malha::study {

/// Rows of errors after 1 s, of the work for a strain of 1 % and of clamped strips at rest, one cell each.
Json size_errors(Cells& cells);
/// Adds the rows and their sections to the findings.
void add_size_errors(const Json& rows, Findings& findings);
/// The number of cells of size_errors().
int size_error_cells(bool quick);

}  // namespace malha::study
