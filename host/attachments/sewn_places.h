// SPDX-License-Identifier: Apache-2.0
// The places of closed seams in the executor's memory (kernels/attachments/sewn_places.h).
#pragma once
#include <vector>

#include "host/base/array.h"
#include "host/model/seams.h"
#include "kernels/attachments/sewn_places.h"

namespace malha {

template <class Executor, class R>
class SewnPlaces {
 public:
  SewnPlaces(const Executor& executor, const Model& model) : executor_(executor) {
    const CompressedLists<int> places = closed_places(model);
    begin_ = Array<Executor, int>(places.begin), particles_ = Array<Executor, int>(places.list);
  }

  void close(const Particles<R>& particles) const {
    const CloseSeams<R> close{particles.p, particles.w, begin_.data(), particles_.data()};
    parallel_for(executor_, static_cast<int>(begin_.size()) - 1, close);
  }
  std::size_t bytes() const { return begin_.bytes() + particles_.bytes(); }

 private:
  Executor executor_;
  Array<Executor, int> begin_, particles_;
};

}  // namespace malha
