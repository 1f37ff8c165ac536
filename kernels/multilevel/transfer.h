// SPDX-License-Identifier: Apache-2.0
// Restriction and prolongation: weighted means between a level and the next finer one. Runs of consecutive means with
// consecutive terms are computed as packs, from a structure of arrays; otherwise means are computed one by one, from
// rows.
#pragma once
#include "kernels/projection/patch_memory.h"
#include "kernels/simd/for_each_pack.h"
#include "kernels/simd/particles.h"
#include "kernels/simd/rows.h"

namespace malha {

/// Means to .. to + count - 1: mean to + k is the sum of weight * value[from + k] over the terms.
struct MeanRun {
  int to, count;
  int term, terms;
};
template <class R>
struct MeanTerm {
  int from;
  R weight;
};

/// Runs of means, piece by piece: those of piece g are begin[g] .. begin[g + 1] - 1.
template <class R>
struct MeansView {
  const int* begin;
  const MeanRun* runs;
  const MeanTerm<R>* terms;

  /// Calls work(run, k, mean) once for every mean, or pack of means, of a piece. From a structure of arrays `mean` is a
  /// Vector3 of lanes.
  template <class Group, class Work>
  KERNEL void each(const Group& group, const Points<R>& from, const Work& work) const {
    for (int r = begin[group.index]; r < begin[group.index + 1]; ++r) {
      const MeanRun& run = runs[r];
      for_each_pack_once<R>(group, run.count, [&]<class T>(int k, T) KERNEL_LAMBDA {
        const MeanTerm<R>* term = terms + run.term;
        Vector3<T> sum = load_points<T>(from, term->from + k) * T(term->weight);
        for (int t = 1; t < run.terms; ++t) sum = sum + load_points<T>(from, term[t].from + k) * T(term[t].weight);
        work(run, k, sum);
      });
    }
  }
  /// From rows it is a Vec4, whose w is the mean of theirs.
  template <class Group, class Work>
  KERNEL void each(const Group& group, const ScatteredPoints<R>& from, const Work& work) const {
    group.for_each(begin[group.index + 1] - begin[group.index], [&](int i) KERNEL_LAMBDA {
      const MeanRun& run = runs[begin[group.index] + i];
      for (int k = 0; k < run.count; ++k) {
        const MeanTerm<R>* term = terms + run.term;
        Vec4<R> sum{};
        for (int t = 0; t < run.terms; ++t) add_row(sum, from.of[term[t].from + k], term[t].weight);
        work(run, k, sum);
      }
    });
  }
};

/// The corrections of a level's particles, by rank: a structure of arrays where prolongation loads packs of them, and
/// rows of four numbers where it does not.
template <class R>
struct Corrections {
  Points<R> columns;
  ScatteredPoints<R> rows;
  template <class Work>
  KERNEL void with_layout(const Work& work) const {
    if (rows.of)
      work(rows);
    else
      work(columns);
  }
};

/// Means of a level's corrections.
template <class R>
struct ProlongationView {
  MeansView<R> means;
  Corrections<R> corrections;
  template <class Group, class Work>
  KERNEL void each(const Group& group, const Work& work) const {
    corrections.with_layout([&](const auto& from) KERNEL_LAMBDA { means.each(group, from, work); });
  }
};

/// Adds the coarse correction to the displacements of a patch's particles; `to` of a run indexes its memory.
template <class R, class Group, class Local>
KERNEL void prolongate(const Group& group, const ProlongationView<R>& prolongation, const Local& local) {
  prolongation.each(group, [&](const MeanRun& run, int k, const auto& mean)
                               KERNEL_LAMBDA { local.add_displacement(run.to + k, mean); });
}

/// The same for particles in their arrays.
template <class R>
struct Prolongate {
  using Shared = void;
  ProlongationView<R> prolongation;
  Points<R> d;
  template <class Group>
  KERNEL void operator()(const Group& group) const {
    prolongation.each(
        group, [&](const MeanRun& run, int k, const auto& mean) KERNEL_LAMBDA { add_points(d, run.to + k, mean); });
  }
};

/// Scatters a point, or the points of a pack, to points[place[0]], points[place[1]], ...
template <class T, class Store>
KERNEL void scatter_points(const Store& points, const int* place, const Vector3<T>& a) {
  if constexpr (sizeof(T) == sizeof(typename RealOf<T>::type))
    points.set(*place, a);
  else
    for (int i = 0; i < T::lanes; ++i) points.set(place[i], {lane(a.x, i), lane(a.y, i), lane(a.z, i)});
}
template <class R, class Store>
KERNEL void scatter_points(const Store& points, const int* place, const Vec4<R>& a) {
  points.set(*place, a.xyz());
}

}  // namespace malha
