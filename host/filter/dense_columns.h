// SPDX-License-Identifier: Apache-2.0
// The columns of the dense S of one body, from its factor, four at a time.
#pragma once
#include <functional>

#include "host/filter/exact_factor.h"
#include "kernels/simd/vec.h"

namespace malha {

/// Four columns of S from `first` on, an entry of each in a Vec4, by unknown of the body; from several threads.
using TakeColumns = std::function<void(int first, const Vec4<double>* columns)>;

/// `exact`: factor of one body. For a free one the result is S without its mean mode, S - 1 1^T / mass. `progress`:
/// reports the share of columns that are done.
void dense_columns(const ExactFactor& exact, const OpenMP& executor, const TakeColumns& take,
                   const ShowProgress& progress);

}  // namespace malha
