// SPDX-License-Identifier: Apache-2.0
// Factor of a spring system in double, for the columns of the dense S and for measuring errors.
#pragma once
#include "host/filter/sparse_filter.h"

namespace malha {

/// Filters by unknown. Products run on one thread each, and in workspaces of their own on several at once.
struct ExactFactor {
  ExactFactor(const SpringSystem& whole, const OpenMP& executor);

  SpringSystem system;  // with its unknowns for particles
  Supernodes all;
  Subtrees cut;
  SparseFilter<Serial, double> filter;
  int singular;  // the unknown at which the system proved singular, and nothing else is then defined; -1: none
};

/// The factor of one body.
SpringSystem body_system(const SpringSystem& system, int body);

}  // namespace malha
