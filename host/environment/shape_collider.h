// SPDX-License-Identifier: Apache-2.0
// Collider of the exact shapes of the environment: planes, spheres, capsules, boxes and cylinders. It has no triangles
// and asks Embree nothing, so that a device does all of it. What it keeps from substep to substep are overlaps alone.
// It is one of the colliders of host/environment/colliders.h, and made only for scenes that have such shapes.
#pragma once
#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "host/base/array.h"
#include "host/environment/moving_shape.h"
#include "host/environment/proximity_memory.h"
#include "host/environment/shape_memory.h"
#include "host/model/model.h"
#include "kernels/environment/shape_guards.h"

namespace malha {

template <class Executor, class R>
class ShapeCollider {
 public:
  ShapeCollider(const Executor& executor, const Model& model)
      : executor_(executor), groups_(static_cast<int>(groups_of(model.x.size()))) {
    for (const EnvironmentMesh& object : model.environment)
      if (object.exact) objects_.push_back(&object);
    const auto groups = static_cast<std::size_t>(groups_);
    first_ = Array<Executor, int>(groups, 0), blocks_ = Array<Executor, int>(groups, 0);
    used_ = Array<Executor, int>(1, 0), moved_ = Array<Executor, int>(1, 0);
    shapes_ = Array<Executor, MovingShape>(objects_.size());
    // One for each group, which costs nothing before it is used.
    if (Memory<Executor>::kOnHost) contacts_ = Array<Executor, ShapeContacts<R>>(groups);
    set_poses(0, 0);
  }

  /// Sets the motion of a substep: the shapes move from their poses at `start` to those at `end` (s).
  void set_poses(double start, double end) {
    if (!present_.empty() && !moves()) return;
    present_.clear();
    for (const EnvironmentMesh* one : objects_) present_.push_back(moving_shape(*one->exact, one->spec, start, end));
    shapes_.upload(present_);
  }
  void end_motion() {
    if (!moves()) return;
    for (MovingShape& shape : present_)
      shape.before = shape.after, shape.motion = {}, shape.rests = true, shape.turn = 0;
    shapes_.upload(present_);
  }
  void append_motion(std::vector<Pose>& motion) const {
    for (const MovingShape& shape : present_) motion.push_back(shape.motion);
  }
  bool moves() const {
    return std::ranges::any_of(objects_, [](const EnvironmentMesh* one) { return !one->spec.motion.empty(); });
  }
  int objects() const { return static_cast<int>(objects_.size()); }

  void detect_contacts(const Particles<R>& particles) {
    if (update_ != OverlapUpdate::None) find_overlaps(particles);
    for (;;) {
      used_.fill(0);
      for_groups(DetectShapeContacts<R>{view(particles)});
      const auto needed = static_cast<std::size_t>(used_.get(0));
      if (needed <= contacts_.size()) return;
      contacts_ = Array<Executor, ShapeContacts<R>>(needed + needed / 4);
    }
  }
  void solve_contacts(const Particles<R>& particles) {
    particles.by_friction([&]<bool mapped>() { for_groups(SolveShapeContacts<R, mapped>{view(particles)}); });
  }
  void restitute(const Particles<R>& particles, double resting_speed, double h) {
    particles.by_friction([&]<bool mapped>() {
      for_groups(RestituteShapeContacts<R, mapped>{view(particles), R(resting_speed), R(1 / h)});
    });
  }
  bool bounces() const {
    return std::ranges::any_of(objects_, [](const EnvironmentMesh* one) { return one->spec.restitution > 0; });
  }
  void clamp_restitution(const Particles<R>& particles) {
    end_motion();
    for_groups(CancelMotionIntoShapes<R>{view(particles)});
  }
  int contacts() const {
    const CountShapeContacts<R> count{contacts_.data(), first_.data(), blocks_.data(), particles_};
    return static_cast<int>(parallel_reduce<Sum>(executor_, groups_, count).value);
  }
  void invalidate_contacts(const Particles<R>& /*particles*/) { blocks_.fill(0); }
  void keep_overlaps(const Particles<R>& /*particles*/) {
    if (update_ == OverlapUpdate::None) update_ = OverlapUpdate::Keep;
  }

  void clamp_tunnelling(const Particles<R>& particles) {
    for_groups(ClampAtShapes<R>{{view(particles)}, false, {}, moved_.data()});
  }
  bool resolve_crossings(const Particles<R>& particles, const KinematicMarks<R>& marks, bool move_with_shapes) {
    moved_.fill(0);
    for_groups(ClampAtShapes<R>{{view(particles)}, move_with_shapes, marks, moved_.data()});
    return moved_.get(0) > 0;
  }

  void allocate_clearance() { clearance_ = Array<Executor, Clearance>(static_cast<std::size_t>(groups_), Clearance{}); }
  double max_contact_free_speed(const Particles<R>& particles, double h, int substeps, double g) {
    const double rounding = 4e-6 + 4e-7 * substeps;  // as of meshes; two roundings for each substep
    for_groups(MeasureShapeClearance<R>{view(particles), rounding, clearance_.data()});
    return parallel_reduce<MinClearance>(executor_, groups_, ReduceClearance{clearance_.data()})
        .max_contact_free_speed(h, substeps, g);
  }

  double max_penetration(const Particles<R>& particles, double time) const {
    std::vector<MovingShape> at;
    for (const EnvironmentMesh* one : objects_) at.push_back(moving_shape(*one->exact, one->spec, time, time));
    const Array<Executor, MovingShape> shapes(at);
    const MeasureDepthInShapes<R> kernel{particles, shapes.data(), objects()};
    return parallel_reduce<Deepest>(executor_, particles.count, kernel).depth;
  }

  std::size_t bytes() const {
    return first_.bytes() + blocks_.bytes() + contacts_.bytes() + shapes_.bytes() + clearance_.bytes() +
           overlap_blocks_.bytes() + overlaps_.bytes();
  }

  ShapeMemory save_state(std::size_t particles) const {
    ShapeMemory memory{update_, {}};
    const std::vector<int> block = overlap_blocks_.download();
    const std::vector<R> all = overlaps_.download();
    for (std::size_t k = 0; !block.empty() && k < objects_.size(); ++k)
      for (std::size_t i = 0; i < particles; ++i) {
        const int b = block[i / kGroupSize * objects_.size() + k];
        const double overlap = b < 0 ? 0 : all[static_cast<std::size_t>(b) * kGroupSize + i % kGroupSize];
        if (overlap > 0) memory.overlaps.push_back({static_cast<std::int64_t>(k * particles + i), overlap});
      }
    return memory;
  }
  void restore_state(const ShapeMemory& memory, std::size_t particles) {
    update_ = memory.update;
    std::vector<int> flags(static_cast<std::size_t>(groups_) * objects_.size(), 0);
    const auto pair_block = [&](const OverlapRecord& of) {
      const auto pair = static_cast<std::size_t>(of.pair);
      return pair % particles / kGroupSize * objects_.size() + pair / particles;
    };
    for (const OverlapRecord& of : memory.overlaps) flags[pair_block(of)] = 1;
    allocate_overlaps(flags);
    if (overlaps_.size() == 0) return;
    std::vector<R> all(overlaps_.size(), R(0));
    for (const OverlapRecord& of : memory.overlaps) {
      const auto lane = static_cast<std::size_t>(of.pair) % particles % kGroupSize;
      all[static_cast<std::size_t>(flags[pair_block(of)]) * kGroupSize + lane] = R(of.overlap);
    }
    overlaps_.upload(all);
    blocks_.fill(0);
  }
  /// Finds the overlaps of the pairs that a layout has and another one had not, as at the start, with the shapes where
  /// they are at `time` (s). All others keep theirs.
  void find_new_overlaps(const Particles<R>& particles, const LayoutMap& map, double time) {
    if (update_ != OverlapUpdate::None || !map.has_new(map.shapes)) return;
    const auto count = static_cast<std::size_t>(particles.count);
    ShapeMemory memory = save_state(count);
    present_.clear(), set_poses(time, time);
    update_ = OverlapUpdate::Start, find_overlaps(particles);
    add_new(save_state(count), map, memory);
    restore_state(memory, count);
  }

 private:
  static constexpr int kThreadGrain = 4096;  // particles; about 30 microseconds of contacts

  ShapeView<R> view(const Particles<R>& particles) {
    particles_ = particles.count;
    return {particles,     shapes_.data(), objects(),    {overlap_blocks_.data(), overlaps_.data()}, contacts_.data(),
            first_.data(), blocks_.data(), used_.data(), static_cast<int>(contacts_.size())};
  }

  template <class Kernel>
  void for_groups(const Kernel& kernel) {
    if (groups_ * kGroupSize <= kThreadGrain)
      return parallel_groups(single_threaded(executor_), 0, groups_, {}, kernel);
    parallel_region(executor_, groups_, [&](const auto& team) { parallel_groups(team, 0, groups_, {}, kernel); });
  }

  /// Finds which particles are nearer to shapes than the thickness, and keeps their overlaps. At the start those that
  /// are deeper inside than the thickness are moved out instead.
  void find_overlaps(const Particles<R>& particles) {
    constexpr double kMostThicknesses = 2;
    const bool start = std::exchange(update_, OverlapUpdate::None) == OverlapUpdate::Start;
    overlap_blocks_ = {}, overlaps_ = {};
    flags_.assign(static_cast<std::size_t>(groups_) * objects_.size(), 0);
    if (found_.size() == 0) found_ = Array<Executor, int>(flags_.size());
    found_.upload(flags_);
    for_groups(FindOverlaps<R>{view(particles), found_.data(), kMostThicknesses, start});
    Memory<Executor>::copy_out(found_.data(), flags_.size(), flags_.data());
    allocate_overlaps(flags_);
    if (overlaps_.size() > 0) for_groups(FindOverlaps<R>{view(particles), nullptr, kMostThicknesses, start});
  }
  /// Allocates blocks for the pairs of group and shape with a flag, which becomes the number of the block; -1: none.
  void allocate_overlaps(std::vector<int>& flags) {
    int count = 0;
    for (int& flag : flags) flag = flag ? count++ : -1;
    overlap_blocks_ = {}, overlaps_ = {};
    if (count == 0) return;
    overlap_blocks_ = Array<Executor, int>(flags);
    overlaps_ = Array<Executor, R>(static_cast<std::size_t>(count) * kGroupSize, R(0));
  }

  Executor executor_;
  std::vector<const EnvironmentMesh*> objects_;  // of the model, whose motion the program may change
  std::vector<MovingShape> present_;             // of the present substep
  Array<Executor, MovingShape> shapes_;          // the same, for kernels
  std::vector<int> flags_;                       // of find_overlaps(): one for each pair of group and shape
  Array<Executor, int> found_;                   // the same, for kernels
  Array<Executor, ShapeContacts<R>> contacts_;
  Array<Executor, int> first_, blocks_;  // see ShapeView
  Array<Executor, int> used_, moved_;    // single numbers
  Array<Executor, int> overlap_blocks_;  // see Overlaps; empty: no overlap
  Array<Executor, R> overlaps_;
  OverlapUpdate update_ = OverlapUpdate::Start;
  Array<Executor, Clearance> clearance_;
  int groups_, particles_ = 0;
};

}  // namespace malha
