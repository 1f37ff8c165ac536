// SPDX-License-Identifier: Apache-2.0
// Attachments of particles to fixed points, points on a path, or points of an environment object, rigid or deforming.
// Made only for scenes that have some.
#pragma once
#include <algorithm>
#include <deque>
#include <vector>

#include "host/attachments/moved_pins.h"
#include "host/attachments/pose.h"
#include "host/base/array.h"
#include "host/model/model.h"
#include "host/projection/stiffness.h"
#include "kernels/attachments/attachment.h"

namespace malha {

template <class Executor, class R>
class Attachments {
 public:
  Attachments(const Executor& executor, const Model& model) : executor_(executor) {
    const SolverSpec& solver = model.scene.solver;
    substep_ = solver.dt / solver.substeps;
    for (const AttachmentSet& spec : model.attached) {
      Set& set = sets_.emplace_back();
      set.target = &spec.target;
      set.release_time = spec.release_time, set.alpha = spec.compliance.value_or(0);
      set.list = Array<Executor, int>(spec.particles);
      set.anchor = Array<Executor, Vector3<double>>(anchors(spec.target, spec.particles, model.x));
      set.surface = surface_points(model, spec.target, spec.particles);
      if (set.alpha > 0 && solver.iterations > 1)
        set.lambda = Array<Executor, Vector3<R>>(spec.particles.size(), Vector3<R>{R(0), R(0), R(0)});
      set.share = spec.compliance ? 1 : stiffness_per_projection(spec.stiffness, solver, 1);
    }
  }

  /// Returns true if an attachment is released at the start of the substep at `start` (s).
  bool release(double start) const {
    return std::ranges::any_of(sets_, [&](const Set& set) {
      return is_over(set.release_time, start, substep_) && !is_over(set.release_time, start - substep_, substep_);
    });
  }

  /// Projects the attachments in a substep from `start` to `end` (s).
  void project(const Displaced<R>& p, const R* w, double start, double end, bool first_iteration) {
    for (Set& set : sets_) {
      if (is_over(set.release_time, start, substep_)) continue;
      const R alpha = R(set.alpha / (substep_ * substep_));
      if (first_iteration) set.follow(end);
      parallel_for(executor_, static_cast<int>(set.list.size()),
                   SolveAttachment<R>{p, w, set.list.data(), set.anchor.data(), set.pose(end), set.lambda.data(),
                                      R(set.share), alpha, first_iteration});
    }
  }

  /// Energy of the springs at `time` (s), J.
  double energy(const Points<R>& x, double time) const {
    double sum = 0;
    for (Set& set : sets_) {
      if (!(set.alpha > 0) || is_over(set.release_time, time, substep_)) continue;
      set.follow(time);
      const MeasureAttachment<R> measure{x, set.list.data(), set.anchor.data(), set.pose(time)};
      const double lengths2 = parallel_reduce<Sum>(executor_, static_cast<int>(set.list.size()), measure).value;
      sum += lengths2 / (2 * set.alpha);
    }
    return sum;
  }

  std::size_t bytes() const {
    std::size_t sum = 0;
    for (const Set& set : sets_) sum += set.list.bytes() + set.anchor.bytes() + set.lambda.bytes();
    return sum;
  }

 private:
  struct Set {
    const Target* target = nullptr;  // of the model, whose motion the program may change
    std::optional<double> release_time;
    double alpha = 0, share = 1;  // m/N; share of the error that a projection removes
    Array<Executor, int> list;
    Array<Executor, Vector3<double>> anchor;  // m, in the target's frame; of a surface: at a time
    std::optional<SurfacePoints> surface;     // of an object that deforms
    Array<Executor, Vector3<R>> lambda;

    Pose pose(double time) const { return surface ? Pose{} : pose_at(target->motion, time); }
    void follow(double time) {
      if (surface) anchor.upload(surface->at(time));
    }
  };

  Executor executor_;
  double substep_;                // s
  mutable std::deque<Set> sets_;  // also set to a time that is measured
};

}  // namespace malha
