// SPDX-License-Identifier: Apache-2.0
// Kinematic particles (moved pins, and particles moved by environment objects) push bodies that they would penetrate:
// along the normal of the division plane, as far as the plane must move; pushed particles push others likewise.
#pragma once
#include "kernels/attachments/pose.h"
#include "kernels/parallel/compute.h"
#include "kernels/self_collision/truncate.h"

namespace malha {

/// Counts the particles with inverse mass 0, now: pins may have been released.
template <class R>
struct CountFixed {
  const R* w;
  const unsigned char* takes_part;
  KERNEL Sum operator()(int i) const { return {takes_part[i] && !(w[i] > R(0)) ? 1.0 : 0.0}; }
};

/// Moves movable particles back to where the substep began.
template <class R>
struct ResetMovableParticles {
  Particles<R> particles;
  KERNEL void operator()(int i) const {
    if (particles.w[i] > R(0)) particles.p.clear_displacement(i);
  }
};

/// Marks the fixed particles that move: these push. Returns how many there are.
template <class R>
struct MarkPushing {
  Trajectories<R> motions;
  MotionState* states;
  KERNEL Sum operator()(int i) const {
    const Vec4<R> m = motions.moved[i];
    const bool pushes = m.w == R(0) && (m.x != R(0) || m.y != R(0) || m.z != R(0));
    states[i] = pushes ? MotionState::Pushing : MotionState::Unchanged;
    return {pushes ? 1.0 : 0.0};
  }
};

/// Pushes one side of every violating pair: the side without kinematic particles; if neither has any, the side that is
/// not pushed yet; both by half if both are alike. Groups: patches of one colour.
template <class R>
struct PushByKinematic {
  Trajectories<R> motions;
  Pairs<R> pairs;
  ContactParams<R> rules;
  const ViolationCount* violations;
  MotionState* states;
  template <class Group>
  KERNEL void operator()(const Group& group) const {
    for_each_crossing(group, pairs, violations, [&](const ContactBlock<R>& block, int k, int section) KERNEL_LAMBDA {
      push(block, k, first_side_of(section));
    });
  }

 private:
  KERNEL void push(const ContactBlock<R>& block, int k, int first) const {
    const Vector3<R> n{block.n[0][k], block.n[1][k], block.n[2][k]};
    int i[4];
    R at[4];
    int one = 0, other = 0;
    ContactSides<R> sides;
    for (int j = 0; j < 4; ++j) {
      i[j] = block.i[j][k] / kIndexScale<R>;
      at[j] = dot(n, motions.x0[i[j]].xyz() - motions.x0[i[0]].xyz()) + dot(n, motions.moved[i[j]].xyz());
      sides.add(j, first, at[j]);
      const int pushes = states[i[j]] != MotionState::Pushing ? 0 : motions.moved[i[j]].w > R(0) ? 1 : 2;
      int& side = j < first ? one : other;
      side = pushes > side ? pushes : side;
    }
    if (one == 0 && other == 0) return;
    // A little more than the required gap: rounding takes some.
    const R required = R(1.1) * required_gap(block.gap[k], rules.least);
    if (!(sides.low - sides.high < required)) return;
    const R overlap = required - (sides.low - sides.high);
    const R low_shift = one < other ? overlap : one > other ? R(0) : R(0.5) * overlap;
    const R low = sides.low + low_shift, high = sides.high - (overlap - low_shift);  // of each side's plane
    for (int j = 0; j < 4; ++j) {
      Vec4<R>& m = motions.moved[i[j]];
      if (!(m.w > R(0)) || (j < first ? at[j] >= low : at[j] <= high)) continue;
      m.set(m.xyz() + n * ((j < first ? low : high) - at[j]));
      states[i[j]] = MotionState::Pushing;
    }
  }
};

/// Moves particles that kinematic ones still penetrate along with these, recursively: primitives with the same motion
/// cannot intersect. Counts the moved particles in `violations`. Groups: patches of one colour.
template <class R>
struct MoveWithKinematic {
  Trajectories<R> motions;
  Pairs<R> pairs;
  KinematicOwners owners;
  ViolationCount* violations;
  MotionState* states;
  template <class Group>
  KERNEL void operator()(const Group& group) const {
    int moved = 0;
    for_each_crossing(group, pairs, violations, [&](const ContactBlock<R>& block, int k, int) KERNEL_LAMBDA {
      int i[4], by = -1;
      for (int j = 0; j < 4; ++j) {
        i[j] = block.i[j][k] / kIndexScale<R>;
        if (pushes(i[j]) && (by < 0 || length2(i[j]) > length2(by))) by = i[j];
      }
      for (int j = 0; j < 4 && by >= 0; ++j) {
        Vec4<R>& m = motions.moved[i[j]];
        if (!(m.w > R(0)) || states[i[j]] == MotionState::Kinematic) continue;
        m.set(displacement_with(by, i[j]));
        states[i[j]] = MotionState::Kinematic, ++moved;
      }
    });
    violations[group.index] = {moved, 0};
  }

 private:
  KERNEL bool pushes(int i) const {
    return states[i] == MotionState::Kinematic || (states[i] == MotionState::Pushing && !(motions.moved[i].w > R(0)));
  }
  KERNEL Vector3<R> displacement_with(int by, int i) const {
    if (owners.of == nullptr || owners.of[by] == kNoOwner) return motions.moved[by].xyz();
    owners.of[i] = owners.of[by];
    const Vector3<double> from = in_double(motions.origin) + in_double(motions.x0[i].xyz());
    return rounded<R>(to_world(owners.motion[owners.of[by]], from) - from);
  }
  KERNEL R length2(int i) const { return dot(motions.moved[i].xyz(), motions.moved[i].xyz()); }
};

}  // namespace malha
