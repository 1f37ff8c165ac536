// SPDX-License-Identifier: Apache-2.0
#include "host/filter/filter.h"

#include "host/filter/make_filter.h"

namespace malha {

#define MALHA_FILTER(Executor, R)                                                                          \
  template std::unique_ptr<Filter<R>> make_filter(const Executor&, int, const Model&, const SpringSystem&, \
                                                  const ShowProgress&);                                    \
  template FilterErrors filter_errors<Executor>(const Filter<R>&, const Model&, const SpringSystem&);
MALHA_FILTER(OpenMP, float)
MALHA_FILTER(OpenMP, double)
#undef MALHA_FILTER

}  // namespace malha
