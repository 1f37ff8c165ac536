// The columns of the dense S of one body: sparse factor in double, then four columns at a time.
#pragma once
#include <functional>

#include "host/filter/factor.h"
#include "host/filter/system.h"
#include "kernels/vec.h"

namespace malha {

/// Four columns of S from `first` on, an entry of each in a Vec4, by unknown of the body; from several threads.
using TakeColumns = std::function<void(int first, const Vec4<double>* columns)>;

/// Of a free body, S without its mean mode: S - 1 1^T / mass. Returns -1, or the unknown at which the body's system
/// proved singular. `progress`: of the columns.
int dense_columns(const SpringSystem& system, int body, const OpenMP& executor, const TakeColumns& take,
                  const ShowProgress& progress);

}  // namespace malha
