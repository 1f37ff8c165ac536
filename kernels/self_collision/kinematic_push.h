// SPDX-License-Identifier: Apache-2.0
// Pins that move go where they are told. What they would go through is driven before them: along the plane's normal, as
// far as the plane must go, and what it would go through likewise.
#pragma once
#include "kernels/attachments/pose.h"
#include "kernels/self_collision/truncate.h"

namespace malha {

/// Particles that nothing moves but pins and edges, now: pins may be let go.
template <class R>
struct CountFixed {
  const R* w;
  const unsigned char* takes_part;
  KERNEL Sum operator()(int i) const { return {takes_part[i] && !(w[i] > R(0)) ? 1.0 : 0.0}; }
};

/// Of them, those that move. Returns how many.
template <class R>
struct MarkPushed {
  Trajectories<R> motions;
  MotionState* held;
  KERNEL Sum operator()(int i) const {
    const Vec4<R> m = motions.moved[i];
    const bool drives = m.w == R(0) && (m.x != R(0) || m.y != R(0) || m.z != R(0));
    held[i] = drives ? MotionState::Pushed : MotionState::Free;
    return {drives ? 1.0 : 0.0};
  }
};

/// Of crossing pairs the side without pins gives way; where neither has any, the one that is not driven yet; each half
/// of the way where both are. Groups: patches of one phase.
template <class R>
struct PushByKinematic {
  Trajectories<R> motions;
  Pairs<R> pairs;
  ContactParams<R> rules;
  const ViolationCount* left;
  MotionState* held;
  template <class Group>
  KERNEL void operator()(const Group& group) const {
    for_each_crossing(group, pairs, left, [&](const ContactBlock<R>& block, int k, int section) KERNEL_LAMBDA {
      drive(block, k, first_side_of(section));
    });
  }

 private:
  KERNEL void drive(const ContactBlock<R>& block, int k, int first) const {
    const Vector3<R> n{block.n[0][k], block.n[1][k], block.n[2][k]};
    int i[4];
    R at[4];
    int one = 0, other = 0;
    ContactSides<R> sides;
    for (int j = 0; j < 4; ++j) {
      i[j] = block.i[j][k] / kIndexScale<R>;
      at[j] = dot(n, motions.x0[i[j]].xyz() - motions.x0[i[0]].xyz()) + dot(n, motions.moved[i[j]].xyz());
      sides.add(j, first, at[j]);
      const int drives = held[i[j]] != MotionState::Pushed ? 0 : motions.moved[i[j]].w > R(0) ? 1 : 2;
      int& side = j < first ? one : other;
      side = drives > side ? drives : side;
    }
    if (one == 0 && other == 0) return;
    // A little more than must be kept: what rounding takes.
    const R keeps = R(1.1) * required_gap(block.gap[k], rules.least);
    if (!(sides.low - sides.high < keeps)) return;
    const R lacks = keeps - (sides.low - sides.high);
    const R part = one < other ? lacks : one > other ? R(0) : R(0.5) * lacks;
    const R low = sides.low + part, high = sides.high - (lacks - part);  // where each side's plane goes
    for (int j = 0; j < 4; ++j) {
      Vec4<R>& m = motions.moved[i[j]];
      if (!(m.w > R(0)) || (j < first ? at[j] >= low : at[j] <= high)) continue;
      m.set(m.xyz() + n * ((j < first ? low : high) - at[j]));
      held[i[j]] = MotionState::Pushed;
    }
  }
};

/// What pins went through all the same goes where they go, and what that would go through: what moves alike cannot
/// cross. Counts those in `left`. Groups: patches of one phase.
template <class R>
struct MoveWithKinematic {
  Trajectories<R> motions;
  Pairs<R> pairs;
  KinematicOwners carriers;
  ViolationCount* left;
  MotionState* held;
  template <class Group>
  KERNEL void operator()(const Group& group) const {
    int carried = 0;
    for_each_crossing(group, pairs, left, [&](const ContactBlock<R>& block, int k, int) KERNEL_LAMBDA {
      int i[4], by = -1;
      for (int j = 0; j < 4; ++j) {
        i[j] = block.i[j][k] / kIndexScale<R>;
        if (drives(i[j]) && (by < 0 || way2(i[j]) > way2(by))) by = i[j];
      }
      for (int j = 0; j < 4 && by >= 0; ++j) {
        Vec4<R>& m = motions.moved[i[j]];
        if (!(m.w > R(0)) || held[i[j]] == MotionState::Kinematic) continue;
        m.set(carried_by(by, i[j]));
        held[i[j]] = MotionState::Kinematic, ++carried;
      }
    });
    left[group.index] = {carried, 0};
  }

 private:
  KERNEL bool drives(int i) const {
    return held[i] == MotionState::Kinematic || (held[i] == MotionState::Pushed && !(motions.moved[i].w > R(0)));
  }
  KERNEL Vector3<R> carried_by(int by, int i) const {
    if (carriers.of == nullptr || carriers.of[by] == kNoOwner) return motions.moved[by].xyz();
    carriers.of[i] = carriers.of[by];
    const Vector3<double> from = in_double(motions.origin) + in_double(motions.x0[i].xyz());
    return rounded<R>(to_world(carriers.motion[carriers.of[by]], from) - from);
  }
  KERNEL R way2(int i) const { return dot(motions.moved[i].xyz(), motions.moved[i].xyz()); }
};

}  // namespace malha
