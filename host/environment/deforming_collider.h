// SPDX-License-Identifier: Apache-2.0
// Collider of the deforming meshes of a scene, substep by substep: contacts, and the guard against tunnelling. It is
// one of the colliders of host/environment/colliders.h, and made only for scenes that have such a mesh.
#pragma once
#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>
#include <vector>

#include "host/attachments/object_motion.h"
#include "host/base/array.h"
#include "host/base/point_array.h"
#include "host/environment/clamp_tunnelling.h"
#include "host/environment/deforming_surface.h"
#include "host/environment/layout_map.h"
#include "host/environment/proximity_memory.h"
#include "host/measure/solver_stats.h"
#include "host/mesh/vectors.h"
#include "kernels/environment/deforming_contact.h"

namespace malha {

template <class Executor, class R>
class DeformingCollider {
 public:
  DeformingCollider(const Executor& executor, const Model& model)
      : executor_(executor),
        particles_(model.count()),
        h_(model.scene.solver.dt / model.scene.solver.substeps),
        recovery_(1.0 / model.scene.solver.substeps),
        pinched_(model.x.size(), 0) {
    for (const EnvironmentMesh& mesh : model.environment)
      if (deforms(mesh)) objects_.emplace_back(mesh, model.x.size());
    views_ = Array<Executor, DeformingObject<R>>(objects_.size());
    if (guards_run_in_turns(model)) saved_displacements_ = PointArray<Executor, R>(model.x.size());
  }

  /// Sets the motion of a substep: the vertices move from where they are at `start` to where they are at `end` (s).
  void set_poses(double start, double end) {
    for (Object& o : objects_) o.move(whole(start), whole(end)), refit(o);
    upload();
  }
  /// Sets the vertices to rest where they are at the end of this substep.
  void end_motion() {
    for (Object& o : objects_)
      if (o.moved) o.mesh.before = o.mesh.after, o.moved = false, refit(o);
    upload();
  }
  // No motion of a deforming mesh is rigid: what it moves has no owner.
  void append_motion(std::vector<Pose>& /*motion*/) const {}
  int objects() const { return 0; }
  bool moves() const { return true; }
  /// Largest speed that a vertex had so far, m/s.
  double fastest_vertex() const {
    double most = 0;
    for (const Object& o : objects_) most = std::max(most, o.fastest);
    return most;
  }

  /// Detects the contacts of the paths from x to p.
  void detect_contacts(const Particles<R>& particles) {
    for (const Object& o : objects_)
      launch(DetectDeformingContacts<R>{o.view(), particles, recovery_ * o.spec().thickness, keeps_overlaps_});
    keeps_overlaps_ = false;
  }
  void solve_contacts(const Particles<R>& particles) {
    particles.by_friction([&]<bool mapped>() {
      for (const Object& o : objects_)
        parallel_for(
            executor_, particles_,
            ResolveContact<R, mapped>{particles.p, o.contacts.data(), R(o.spec().friction), particles.friction});
    });
  }
  /// See EnvironmentContacts.
  void restitute(const Particles<R>& particles, double resting_speed, double h) {
    particles.by_friction([&]<bool mapped>() {
      for (const Object& o : objects_)
        parallel_for(executor_, particles_,
                     ApplyRestitution<R, mapped>{particles.p, particles.v, o.contacts.data(), R(o.spec().restitution),
                                                 R(o.spec().friction), R(resting_speed), R(1 / h), particles.friction});
    });
  }
  void clamp_restitution(const Particles<R>& particles) {
    end_motion();
    launch(CancelCrossings<R>{views_.data(), count(), particles});
  }
  bool bounces() const {
    return std::ranges::any_of(objects_, [](const Object& o) { return o.spec().restitution > 0; });
  }
  /// Number of contacts that pushed in the last substep.
  int contacts() const {
    double sum = 0;
    for (const Object& o : objects_)
      sum += parallel_reduce<Sum>(executor_, particles_, CountContact<R>{o.contacts.data()}).value;
    return static_cast<int>(sum);
  }
  void invalidate_contacts(const Particles<R>& particles) {
    for (const Object& o : objects_)
      parallel_for(executor_, particles_, InvalidateContacts<R>{o.contacts.data(), particles.p, -1});
  }
  /// Lets particles that are nearer than the thickness now keep their distance until they move away by themselves.
  void keep_overlaps(const Particles<R>& /*particles*/) { keeps_overlaps_ = true; }

  /// Puts particles whose path crosses a surface in front of it.
  void clamp_tunnelling(const Particles<R>& particles) {
    launch(ClampToDeforming<R>{views_.data(), count(), particles, pinched_.data()});
    const Sum now = parallel_reduce<Sum>(executor_, particles_, CountPinched{pinched_.data()});
    most_pinched_ = std::max(most_pinched_, static_cast<int>(now.value));
  }
  /// The same after self-collision, with marks on particles that it has moved. Returns whether there are any.
  bool resolve_crossings(const Particles<R>& particles, const KinematicMarks<R>& marks, bool /*move_with_objects*/) {
    const Points<R> saved = saved_displacements_.points();
    parallel_for(executor_, particles_, CopyPoints<R, Points<R>, Points<R>>{particles.p.d, saved});
    clamp_tunnelling(particles);
    return parallel_reduce<Sum>(executor_, particles_, MarkMovedParticles<R>{particles, saved, marks, nullptr, 0})
               .value > 0;
  }

  // Deforming meshes always move: contacts are detected in every substep.
  void allocate_clearance() {}
  double max_contact_free_speed(const Particles<R>& /*particles*/, double /*h*/, int /*substeps*/, double /*g*/) {
    return 0;
  }

  /// Largest depth of a particle inside a solid or behind a one-sided sheet (m) at the given time, that of the end of
  /// the last substep.
  double max_penetration(const Particles<R>& particles, double time) const {
    double deepest = 0;
    for (Object& o : objects_) {
      o.move(whole(time), whole(time)), refit(o);
      const DepthInDeforming<R> depth{o.view(), particles, kMaxDepth * o.spec().thickness};
      deepest = std::max(deepest, parallel_reduce<Deepest>(executor_, particles_, depth, kQueryGrain).depth);
    }
    return deepest;
  }
  /// The overlap that each particle may keep at each mesh, m, for checkpoints; below 0: any, as at the start.
  std::vector<float> overlaps() const {
    std::vector<float> all;
    if (keeps_overlaps_) return std::vector<float>(objects_.size() * static_cast<std::size_t>(particles_), -1.0f);
    for (const Object& o : objects_) {
      const std::vector<float> of = o.overlap.download();
      all.insert(all.end(), of.begin(), of.end());
    }
    return all;
  }
  void restore_overlaps(const std::vector<float>& all) {
    keeps_overlaps_ = all[0] < 0;
    std::vector<float> of(static_cast<std::size_t>(particles_));
    for (std::size_t k = 0; k < objects_.size(); ++k) {
      std::copy_n(all.begin() + static_cast<std::ptrdiff_t>(k * of.size()), of.size(), of.begin());
      objects_[k].overlap.upload(of);
    }
  }
  /// Finds the overlaps of the pairs that a layout has and another one had not, as at the start, with the meshes where
  /// they are at `time` (s). All others keep theirs.
  void find_new_overlaps(const Particles<R>& particles, const LayoutMap& map, double time) {
    if (keeps_overlaps_ || !map.has_new(map.deforming)) return;
    std::vector<float> all = overlaps();
    set_poses(time, time);
    keeps_overlaps_ = true, detect_contacts(particles);
    const std::vector<float> found = overlaps();
    for (std::size_t k = 0, pair = 0; k < objects_.size(); ++k)
      for (std::size_t i = 0; i < map.particles.size(); ++i, ++pair)
        if (map.is_new(map.deforming, k, i)) all[pair] = found[pair];
    restore_overlaps(all), invalidate_contacts(particles);
  }
  /// Largest number of particles in any substep so far for which there was no place between surfaces.
  int most_pinched() const { return most_pinched_; }

  std::vector<DeformingStats> facts() const {
    std::vector<DeformingStats> all;
    for (const Object& o : objects_) all.push_back({o.spec().name, o.mesh.triangles, o.bytes()});
    return all;
  }
  std::size_t bytes() const {
    std::size_t sum = pinched_.bytes() + views_.bytes() + saved_displacements_.bytes();
    for (const Object& o : objects_) sum += o.bytes();
    return sum;
  }

 private:
  static constexpr int kBlockGrain = 256, kQueryGrain = 1024;
  static constexpr double kMaxDepth = 20;  // thicknesses: depths are measured up to it

  struct Object {
    Object(const EnvironmentMesh& object, std::size_t particles)
        : of(object),
          overlap(particles, 0.0f),
          hint(particles, -1),
          clear(particles, Vec4<float>{0, 0, 0, -1}),
          contacts(particles, Contact<R>{}) {
      const DeformingSurface surface = deforming_surface(object.mesh);
      const auto list = [this](const std::vector<int>& values) {
        lists.emplace_back(values);
        return lists.back().data();
      };
      for (int k = 0; k < 3; ++k)
        mesh.corner[k] = list(surface.corner[k]), mesh.neighbour[k] = list(surface.neighbour[k]);
      mesh.star_begin = list(surface.star.begin), mesh.star = list(surface.star.list);
      rim = Array<Executor, unsigned char>(surface.rim);
      mesh.rim = rim.data(), mesh.triangles = static_cast<int>(surface.triangles.size());
      const int blocks = (mesh.triangles + kBranch - 1) / kBranch;
      lay_out_levels(blocks, mesh.tree);
      const auto rows = [this](int count) {
        BoxRows<float> all;
        for (float*& bound : all.bound) bound = boxes.emplace_back(static_cast<std::size_t>(count), 0.0f).data();
        return all;
      };
      mesh.tree.node = rows(node_capacity(mesh.tree));
      mesh.box = rows(blocks * kBranch), mesh.motion = rows(blocks);
      for (Box<float>** bounds : {&mesh.vertex_box, &mesh.vertex_motion})
        *bounds = vertex_bounds.emplace_back(object.mesh.points.size()).data();
      for (Array<Executor, Vec4<double>>& at : vertices)
        at = Array<Executor, Vec4<double>>(object.mesh.points.size(), Vec4<double>{});
    }

    /// Sets the motion of the vertices in a substep. One that follows the last begins where that ended.
    void move(double start, double end) {
      if (time != start) vertices[last].upload(points(start));
      mesh.before = vertices[last].data();
      if (end != start) {
        last = 1 - last;
        vertices[last].upload(points(end));
      }
      mesh.after = vertices[last].data(), time = end, moved = true;
    }

    const EnvironmentSpec& spec() const { return of.spec; }
    DeformingObject<R> view() const {
      return {mesh,
              of.spec.sides == Sides::Solid,
              of.spec.sides == Sides::OneSided,
              of.spec.thickness,
              overlap.data(),
              moved ? clear.data() : nullptr,
              hint.data(),
              contacts.data()};
    }
    std::size_t bytes() const {
      std::size_t sum = overlap.bytes() + contacts.bytes() + rim.bytes() + 2 * vertices[0].bytes();
      for (const auto& one : lists) sum += one.bytes();
      for (const auto& one : boxes) sum += one.bytes();
      for (const auto& one : vertex_bounds) sum += one.bytes();
      return sum + hint.bytes() + clear.bytes();
    }

    const EnvironmentMesh& of;
    DeformingMesh mesh{};
    std::deque<Array<Executor, int>> lists;
    Array<Executor, unsigned char> rim;
    std::deque<Array<Executor, float>> boxes;
    std::deque<Array<Executor, Box<float>>> vertex_bounds;
    Array<Executor, float> overlap;
    Array<Executor, int> hint;
    Array<Executor, Vec4<float>> clear;
    Array<Executor, Vec4<double>> vertices[2];
    Array<Executor, Contact<R>> contacts;
    int last = 0;        // of `vertices`, those at `time`
    bool moved = true;   // in this substep: otherwise the mesh rests where it is at its end
    double time = NAN;   // s
    double fastest = 0;  // m/s

   private:
    /// The vertices at a time, whose speed since `time` is noted.
    const std::vector<Vec4<double>>& points(double at) {
      const std::vector<Vec3>& now = points_at(of, at, sampled);
      staged.clear();
      for (const Vec3& x : now) staged.push_back({x[0] + 0, x[1] + 0, x[2] + 0, 0});
      if (at > time)
        for (std::size_t v = 0; v < now.size(); ++v)
          fastest = std::max(fastest, norm(minus(now[v], before[v])) / (at - time));
      before.swap(sampled.points);
      return staged;
    }
    VertexBuffer sampled;
    std::vector<Vec4<double>> staged;  // for kernels
    std::vector<Vec3> before;          // positions at `time`
  };

  struct CountPinched {
    const unsigned char* pinched;
    KERNEL Sum operator()(int i) const { return {double(pinched[i])}; }
  };

  int count() const { return static_cast<int>(objects_.size()); }
  /// A whole number of substeps: a substep begins at the very time at which the last one ended, after a resume too.
  double whole(double time) const { return std::round(time / h_) * h_; }

  void refit(const Object& o) const {
    const WideBvh<float>& tree = o.mesh.tree;
    parallel_for(executor_, static_cast<int>(o.of.mesh.points.size()), ComputeVertexBounds{o.mesh},
                 kBlockGrain * kBranch);
    parallel_for(executor_, tree.nodes[0], RefitBlock{o.mesh}, kBlockGrain);
    for (int level = 1; level < tree.levels; ++level)
      parallel_for(executor_, tree.nodes[level], RefitLevel<float>{tree, level});
  }
  void upload() {
    staged_views_.clear();
    for (const Object& o : objects_) staged_views_.push_back(o.view());
    views_.upload(staged_views_);
  }
  template <class Kernel>
  void launch(const Kernel& kernel) {
    const int groups = static_cast<int>(groups_of(static_cast<std::size_t>(particles_)));
    if (particles_ <= kQueryGrain) return parallel_for_interleaved(single_threaded(executor_), groups, kernel);
    parallel_region(executor_, groups, [&](const auto& team) { parallel_for_interleaved(team, groups, kernel); });
  }

  Executor executor_;
  int particles_;
  double h_;                            // s
  double recovery_;                     // thicknesses by which a particle that is too near is moved out in a substep
  mutable std::deque<Object> objects_;  // also set to times that are measured
  Array<Executor, DeformingObject<R>> views_;
  std::vector<DeformingObject<R>> staged_views_;  // the same, before they are uploaded
  Array<Executor, unsigned char> pinched_;        // of each particle
  PointArray<Executor, R> saved_displacements_;
  bool keeps_overlaps_ = true;
  int most_pinched_ = 0;
};

}  // namespace malha
