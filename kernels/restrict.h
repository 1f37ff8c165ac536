// The particles of a level arrive: they are the mass centres of finer ones, patch by patch of these.
#pragma once
#include "kernels/means.h"
#include "kernels/motion.h"
#include "kernels/patch.h"

namespace malha {

/// Where means of a patch's particles go: `means` are of places in the patch's memory. Of a mean of several patches
/// each leaves its part; AddParts joins them.
template <class R>
struct UpTo {
  MeansView<R> means;
  const int* place;
  Points<R> to;
};

/// From the patch's memory.
template <class R, class Group, class Local>
KERNEL void restrict_to(const Group& group, const UpTo<R>& up, const Local& local) {
  up.means.each(group, local, [&](const MeanRun& run, int k, const auto& mean) KERNEL_LAMBDA {
    scatter_points(up.to, up.place + run.to + k, mean);
  });
}

/// Where particles will be after dt if nothing but gravity moves them; null v: where they are.
template <class R>
struct Foreseen {
  Points<R> x, v;      // m, m/s
  const R* w;          // 1/kg
  R dt;                // s
  Vector3<R> gravity;  // m/s^2

  /// Those of a segment, into the patch's memory.
  template <class Group, class Local>
  KERNEL void bring(const Group& group, const Segment& segment, const Local& local) const {
    cover<R>(group, segment.count, [&]<class T>(int i, T of) KERNEL_LAMBDA {
      const int at = segment.global + i;
      Vector3<T> q = load_points<T>(x, at);
      load(w + at, of);
      if (v.x) {
        const Vector3<T> g{T(gravity.x), T(gravity.y), T(gravity.z)};
        q = predicted(q, accelerated(load_points<T>(v, at), of, g, T(dt)), T(dt));
      }
      local.fill(segment.local + i, q, of);
    });
  }
};

/// One visit to a patch of the finer particles.
template <class R>
struct Restrict {
  using Shared = void;
  const Patch* patches;
  const Segment* segments;
  Foreseen<R> from;
  UpTo<R> up;

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    const Patch& patch = patches[group.index];
    R* memory = static_cast<R*>(group.memory);
    if (patch.columns)
      visit(group, patch, Columns<R>::over(memory, patch.slots));
    else
      visit(group, patch, Rows<R>::over(memory, patch.slots));
  }

 private:
  template <class Group, class Local>
  KERNEL void visit(const Group& group, const Patch& patch, const Local& local) const {
    for (int s = patch.segment; s < patch.segment + patch.segments; ++s)
      if (segments[s].last) from.bring(group, segments[s], local);
    restrict_to(group, up, local);
  }
};

/// b[at[k]] += the parts begin[k] .. begin[k + 1] - 1.
template <class R>
struct AddParts {
  const int *at, *begin;
  Points<R> b;
  KERNEL void operator()(int k) const {
    Vector3<R> sum = b[at[k]];
    for (int part = begin[k]; part < begin[k + 1]; ++part) sum = sum + b[part];
    b.set(at[k], sum);
  }
};

}  // namespace malha
