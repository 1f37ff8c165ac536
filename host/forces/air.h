// SPDX-License-Identifier: Apache-2.0
// The air on a model's faces (kernels/forces/air.h), in the executor's memory.
#pragma once
#include "host/base/array.h"
#include "host/base/point_array.h"
#include "host/model/model.h"
#include "kernels/forces/air.h"
#include "malha/scene.h"

namespace malha {

template <class Executor, class R>
class Air {
 public:
  Air(const Executor& executor, const AirFaces& of, const Wind& wind)
      : executor_(executor),
        corners_(of.faces),
        particle_(of.particle),
        begin_(of.begin),
        around_(of.incident),
        faces_(of.faces.size()),
        wind_(wind) {}

  /// Applies the forces of the air to v in a substep of h seconds.
  void apply_wind(const Particles<R>& all, double h) const {
    const auto half = [this](double coefficient) { return R(0.5 * wind_.density * coefficient); };
    const Vector3<R> u{R(wind_.velocity[0]), R(wind_.velocity[1]), R(wind_.velocity[2])};
    const Points<R> faces = faces_.points();
    parallel_for(executor_, static_cast<int>(corners_.size()), FacesInAir<R>{all.p, corners_.data()->data(), faces});
    parallel_for(executor_, static_cast<int>(particle_.size()),
                 ApplyWindForces<R>{all.v, all.w, particle_.data(), begin_.data(), around_.data(), faces, u, R(h),
                                    half(wind_.drag_coefficient), half(wind_.lift_coefficient)});
  }
  void change(const Wind& wind) { wind_ = wind; }
  std::size_t bytes() const {
    return corners_.bytes() + particle_.bytes() + begin_.bytes() + around_.bytes() + faces_.bytes();
  }

 private:
  Executor executor_;
  Array<Executor, Quad> corners_;
  Array<Executor, int> particle_, begin_, around_;
  PointArray<Executor, R> faces_;
  Wind wind_;
};

}  // namespace malha
