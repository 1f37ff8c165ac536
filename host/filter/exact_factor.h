// SPDX-License-Identifier: Apache-2.0
// Factor of a spring system in double, for the columns of the dense S and for measuring errors.
#pragma once
#include <functional>

#include "host/filter/sparse_filter.h"
#include "kernels/simd/vec.h"

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

/// Four columns of S from `first` on, an entry of each in a Vec4, by unknown of the body; from several threads.
using TakeColumns = std::function<void(int first, const Vec4<double>* columns)>;

/// `exact`: factor of one body. For a free one the result is S without its mean mode, S - 1 1^T / mass. `progress`:
/// reports the share of columns that are done.
void dense_columns(const ExactFactor& exact, const OpenMP& executor, const TakeColumns& take,
                   const ShowProgress& progress);

}  // namespace malha
