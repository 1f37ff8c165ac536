// SPDX-License-Identifier: Apache-2.0
// Collision of deformable bodies with edges and corners of environment objects that move together: candidates,
// contacts, their projection, and the final guard, all in the objects' frame. In it only particles move, or (kDeforms)
// also the points of one object, whose mesh deforms; then candidates are found anew in every substep.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "host/attachments/pose.h"
#include "host/base/point_array.h"
#include "host/environment/contact_list.h"
#include "host/environment/deforming_points.h"
#include "host/environment/edge_memory.h"
#include "host/environment/edge_surface.h"
#include "host/measure/solver_stats.h"
#include "kernels/self_collision/contact_distance.h"

namespace malha {

template <class Executor, class R, bool kDeforms = false>
class EdgeGroup {
 public:
  /// `bodies`: simplices of the deformable bodies.
  EdgeGroup(const Executor& executor, const Model& model, const std::vector<Simplex>& bodies,
            const std::vector<const EnvironmentMesh*>& objects)
      : executor_(executor),
        particles_(model.count()),
        bodies_(bodies),
        of_(*objects[0]),
        h_(model.scene.solver.dt / model.scene.solver.substeps),
        recovery_(R(recovery_share(h_))),
        contacts_(executor, model) {
    EdgeSurface surface = edge_surface(objects);
    centre_ = {surface.centre[0], surface.centre[1], surface.centre[2]};
    facts_.edges = surface.edges, facts_.corners = surface.corners;
    std::vector<EdgeContactParams<R>> params;
    double widest = 0;
    for (const EnvironmentMesh* object : objects) {
      params.push_back({R(kMinDistance * object->spec.thickness), R(object->spec.friction)});
      widest = std::max(widest, object->spec.thickness);
    }
    params_ = Array<Executor, EdgeContactParams<R>>(params);
    min_distance_ = R(kMinDistance * widest), margin_ = R(kMargin * widest), slack_ = R(kSlack * widest);
    least_ = R(kLeastGap * widest);
    bvh_ = Array<Executor, BoxNode>(surface.path);
    if constexpr (kDeforms) prepare_motion(surface);
    for (Simplex& t : surface.triangles)
      for (int& corner : t.corner) corner += particles_;
    triangles_ = Array<Executor, Simplex>(surface.triangles);

    const std::size_t n = static_cast<std::size_t>(particles_), all = n + surface.points.size();
    std::vector<Vec3> places(n, Vec3{});
    places.insert(places.end(), surface.points.begin(), surface.points.end());
    std::vector<int> object(n, 0);
    for (const int o : surface.object) object.push_back(1 + o);
    std::vector<Box<R>> boxes(all, Box<R>{});
    for (std::size_t i = n; i < all; ++i) {
      const Vec4<R> at{R(places[i][0]), R(places[i][1]), R(places[i][2]), 0};
      boxes[i] = {at, at};
    }
    std::vector<R> contact_distance(all, R(INFINITY));
    std::fill_n(contact_distance.begin(), n, R(0));
    x_ = Points4(places), x_.upload_fourth(contact_distance), d_ = Points4(all), moved_ = Points4(all),
    x_then_ = Points4(n), d_then_ = Points4(kDeforms ? all : n);
    object_ = Array<Executor, int>(object), boxes_ = Array<Executor, Box<R>>(boxes);
    w_ = Array<Executor, R>(all, R(0));
    has_candidates_ = Array<Executor, unsigned char>(n, 0);
    offset_ = Array<Executor, int>(bodies.size(), 0);
  }

  /// Detects the contacts for x0 -> p, x0 the last positions without intersections; from `start` to `end` (s).
  void detect_contacts(const Particles<R>& particles, const ScatteredPoints<R>& x0, double start, double end) {
    before_ = {pose_at(of_.spec.motion, start), centre_};
    after_ = {pose_at(of_.spec.motion, end), centre_};
    if constexpr (kDeforms) move_points(start, end);
    Memory<Executor>::copy(particles.w, static_cast<std::size_t>(particles_), w_.data());
    parallel_for(executor_, particles_, StartLocal<R>{x0, before_, x_.points()});
    if constexpr (kDeforms) leave_out_crossing();
    update_contacts(particles);
    contacts_.start_substep();
  }

  /// One projection of all contacts.
  void solve_contacts(const Particles<R>& particles) {
    if (contacts_.found() == 0) return;
    store_motion(particles);
    const auto project = [&](const auto& with) {
      contacts_.project(particles.p, w_.data(), moved_.points(), with, TurnToWorld{after_.pose});
    };
    particles.by_friction([&]<bool mapped>() {
      const ObjectFriction<R, mapped> friction{params_.data(), object_.data(), particles.friction};
      if constexpr (kDeforms)
        project(DeformingFriction<R, mapped>{friction, contacts_.carries()});
      else
        project(friction);
    });
  }

  /// Final guard: resolves intersections at the end of the substep, by projection if that is enough (and can_project),
  /// by truncation otherwise; truncated particles are marked in `marks` if that is enabled, and rest then. Returns
  /// whether anything moved.
  bool resolve_intersections(const Particles<R>& particles, bool can_project, const KinematicMarks<R>& marks) {
    if constexpr (kDeforms) return resolve_in_rounds(particles, can_project, marks);
    store_motion(particles);
    if (leaves_bounds()) {
      contacts_.cache_pushed();
      update_contacts(particles);
      ++facts_.substeps_redetected;
    }
    if (contacts_.found() == 0) return false;
    const DivisionPlanes<R> planes{x_.points(), moved_.points(), least_};
    double left = contacts_.count_violations(planes, w_.data());
    if (!(left > 0)) return false;
    if (can_project) left = project_more(particles, planes, left);
    if (!(left > 0)) return true;
    ++facts_.substeps_truncated;
    contacts_.truncate(left, planes, SetFromLocal<R>{particles.p, after_, marks}, marks.is_enabled(), w_.data());
    return true;
  }

  /// Lets particles that are nearer than the minimum distance now keep their distance until they move away by
  /// themselves.
  void keep_overlaps() {
    parallel_for(executor_, particles_, ResetContactDistances<R>{x_.points().of, min_distance_}, kGrain);
    overlaps_ = true;
  }

  /// Number of contacts that pushed in the last substep.
  int contacts() const { return contacts_.pushed(); }
  /// Largest number of particles in any substep so far whose pairs were left out, because they crossed a mesh that
  /// deforms.
  int most_left_out() const { return most_left_out_; }

  /// Motion of the objects in this substep, from the world to the world.
  Pose motion() const { return from_to(before_.pose, after_.pose); }

  /// Appends the state that later substeps depend on.
  void save(EdgeMemory<R>& memory) const {
    const auto from = x_then_.template download<std::array<R, 3>>(),
               way = d_then_.template download<std::array<R, 3>>();
    memory.from.insert(memory.from.end(), from.begin(), from.end());
    memory.way.insert(memory.way.end(), way.begin(), way.begin() + particles_);
    const auto distance = x_.download_fourth(static_cast<std::size_t>(particles_));
    memory.contact_distance.insert(memory.contact_distance.end(), distance.begin(), distance.end());
    memory.valid.push_back(searched_ && !kDeforms ? 1 : 0);
  }
  /// Restores the state of the group-th group; repeats its search, which finds the same candidates.
  void restore_state(const EdgeMemory<R>& memory, std::size_t group) {
    searched_ = memory.valid.at(group) != 0;
    const auto own = [&]<class T>(const std::vector<T>& all) {
      const auto begin = all.begin() + static_cast<std::ptrdiff_t>(group) * particles_;
      return std::vector<T>(begin, begin + particles_);
    };
    x_.upload_fourth(own(memory.contact_distance));
    overlaps_ = true;
    if constexpr (kDeforms) now_ = {}, searched_ = false, crossing_ = true;
    if (!searched_) return;
    x_then_.upload(own(memory.from)), d_then_.upload(own(memory.way));
    parallel_for(executor_, particles_, CopyPoints<R, ScatteredPoints<R>>{x_then_.points(), x_.points()});
    search_again();
  }

  EdgeStats facts() const {
    EdgeStats facts = facts_;
    facts.candidates = candidates_found_, facts.pairs = contacts_.found();
    return facts;
  }
  std::size_t bytes() const {
    return bvh_.bytes() + triangles_.bytes() + params_.bytes() + x_.bytes() + d_.bytes() + moved_.bytes() +
           x_then_.bytes() + d_then_.bytes() + object_.bytes() + boxes_.bytes() + w_.bytes() + has_candidates_.bytes() +
           offset_.bytes() + bodies_.bytes() + sums_.bytes() + candidates_.bytes() + contacts_.bytes() +
           nodes_by_depth_.bytes() + normals_[0].bytes() + normals_[1].bytes() + crossing_flags_.bytes();
  }

 private:
  using Points4 = ScatteredArray<Executor, R>;

  static constexpr int kGrain = ContactList<Executor, R>::kGrain;
  static constexpr int kMoreProjections = 8;
  static constexpr double kMinDistance =
      0.5;  // of the thickness; faces keep a whole one, so smooth parts need no edges
  static constexpr double kMargin =
      0.25;                               // of the thickness: constraints may move particles as far past the prediction
  static constexpr double kSlack = 0.12;  // of the thickness: margin of the search for candidates
  static constexpr double kLookAhead = kDeforms ? 1 : 8;  // substeps of motion that the search looks ahead
  static constexpr int kRounds = 32, kRoundsOfEach = 4;   // of the guard of a mesh that deforms; of each GuardStart
  static constexpr R kDiagonal = R(1.7320508075688772);   // of a cube of side 1
  static constexpr double kLeastGap = 0.01;               // of the thickness
  static constexpr R kRounding = R(0.99);                 // share of the slack that rounding leaves

  void store_motion(const Particles<R>& particles) {
    parallel_for(executor_, particles_, MoveLocal<R>{particles.p, after_, x_.points(), moved_.points()}, kGrain);
  }

  void update_contacts(const Particles<R>& particles) {
    store_motion(particles);
    const CheckCandidateBounds<R> own{moved_.points(),  x_.points(),      d_.points(),
                                      x_then_.points(), d_then_.points(), kRounding * slack_};
    const double left = parallel_reduce<Sum>(executor_, particles_, own).value;
    if (kDeforms || !searched_ || left > 0) search();
    update_contacts();
  }

  /// Tells whether particles have moved farther than the candidates were found for.
  bool leaves_bounds() const {
    const CountBoundsViolations<R> count{x_.points(),      moved_.points(), d_.points(), x_then_.points(),
                                         d_then_.points(), margin_,         slack_,      has_candidates_.data()};
    return parallel_reduce<Sum>(executor_, particles_, count).value > 0;
  }
  /// Projects contacts further while some are violated; returns how many are, of those that truncation can resolve.
  double project_more(const Particles<R>& particles, const DivisionPlanes<R>& planes, double left) {
    for (int more = 0; left > 0 && more < kMoreProjections; ++more) {
      solve_contacts(particles);
      store_motion(particles);
      if (leaves_bounds()) {
        contacts_.cache_pushed();
        update_contacts(particles);
      }
      left = contacts_.count_violations(planes, w_.data());
    }
    return left;
  }

  /// resolve_intersections() of a mesh that deforms. It may move a particle out of the bounds for which candidates were
  /// found, so that the next round finds new ones. Where places of particles contradict each other, they go with the
  /// mesh, and what its deformation leaves is resolved from there.
  bool resolve_in_rounds(const Particles<R>& particles, bool can_project, const KinematicMarks<R>& marks) {
    constexpr GuardStart starts[] = {GuardStart::There, GuardStart::Beside, GuardStart::Stay, GuardStart::There,
                                     GuardStart::Stay};
    constexpr int again = 3, last = 4;
    const DivisionPlanes<R> planes{x_.points(), moved_.points(), least_};
    bool any = false, detected_again = false, truncated = false;
    int start = 0, rounds = 0;  // rounds with this start
    const auto next_start = [&] {
      ++start, rounds = 0;
      if (start == again) contacts_.end_guard();
    };
    for (int round = 0; round < kRounds; ++round) {
      store_motion(particles);
      if (leaves_bounds()) {
        contacts_.cache_pushed();
        update_contacts(particles);
        detected_again = true;
      }
      const auto count = [&] { return contacts_.found() > 0 ? contacts_.count_violations(planes, w_.data()) : 0; };
      double left = count();
      if (!(left > 0) && start + 1 == again) next_start(), left = count();
      if (!(left > 0)) break;
      if (can_project && round == 0) left = project_more(particles, planes, left), any = true;
      if (!(left > 0)) continue;
      const SetFromLocal<R> set_position{particles.p, after_, marks};
      const double moved = contacts_.project_onto_planes(planes, set_position, starts[start], w_.data());
      any = truncated = true, ++rounds;
      if (moved > 0 && (starts[start] == GuardStart::Stay || rounds < kRoundsOfEach)) continue;
      if (start == last) break;
      next_start();
    }
    contacts_.end_guard();
    facts_.substeps_redetected += detected_again ? 1 : 0, facts_.substeps_truncated += truncated ? 1 : 0;
    return any;
  }

  /// Lists the nodes of the BVH by their depth, the deepest first, and the triangles of the mesh.
  void prepare_motion(const EdgeSurface& surface) {
    std::vector<std::vector<int>> by_depth;
    std::vector<int> ends;  // of the subtrees around a node
    for (int node = 0; node < static_cast<int>(surface.path.size()); ++node) {
      while (!ends.empty() && ends.back() == node) ends.pop_back();
      by_depth.resize(std::max(by_depth.size(), ends.size() + 1));
      by_depth[ends.size()].push_back(node);
      ends.push_back(surface.path[node].next);
    }
    std::vector<int> nodes;
    for (std::size_t depth = by_depth.size(); depth-- > 0;) {
      nodes.insert(nodes.end(), by_depth[depth].begin(), by_depth[depth].end());
      depth_end_.push_back(static_cast<int>(nodes.size()));
    }
    nodes_by_depth_ = Array<Executor, int>(nodes);
    for (const Simplex& t : surface.triangles) mesh_triangles_.push_back({t.corner[0], t.corner[1], t.corner[2]});
    for (auto& normals : normals_) normals = Array<Executor, Vec4<double>>(surface.points.size(), Vec4<double>{});
    crossing_flags_ = Array<Executor, unsigned char>(static_cast<std::size_t>(particles_), 0);
  }

  /// Sets the motion of the mesh's points in a substep. One that follows the last begins where that ended. The frame
  /// moves with the mean of the points.
  void move_points(double start, double end) {
    start = std::round(start / h_) * h_, end = std::round(end / h_) * h_;
    std::swap(from_, now_);
    const DeformingPoints& from = from_;
    if (from_.time != start) from_.sample(of_, mesh_triangles_, start);
    now_.sample(of_, mesh_triangles_, end);
    before_.centre = from.centre, after_.centre = now_.centre;
    const std::vector<Vec3>&before = from.at.points, &after = now_.at.points;
    const std::size_t count = before.size();
    auto& [x, d, boxes] = staged_points_;
    x.resize(count), d.resize(count), boxes.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      const auto in_frame = [](const Vec3& a, const Vector3<double>& centre) {
        return Vector3<double>{a[0], a[1], a[2]} - centre;
      };
      const Vector3<R> at = rounded<R>(in_frame(before[i], from.centre)),
                       way = rounded<R>(in_frame(after[i], now_.centre) - in_double(at)), to = at + way;
      x[i] = {at.x, at.y, at.z, R(INFINITY)}, d[i] = {way.x, way.y, way.z, R(0)};
      boxes[i] = merge(Box<R>{x[i], x[i]}, Box<R>{{to.x, to.y, to.z, R(0)}, {to.x, to.y, to.z, R(0)}});
    }
    const auto n = static_cast<std::ptrdiff_t>(particles_);
    Memory<Executor>::copy_in(x.data(), count, x_.points().of + n);
    for (const Points4* motion : {&d_, &moved_, &d_then_})
      Memory<Executor>::copy_in(d.data(), count, motion->points().of + n);
    Memory<Executor>::copy_in(boxes.data(), count, boxes_.data() + n);
    normals_[0].upload(from.normal), normals_[1].upload(now_.normal);
    for (std::size_t depth = 0; depth < depth_end_.size(); ++depth) {
      const int begin = depth == 0 ? 0 : depth_end_[depth - 1];
      parallel_for(executor_, depth_end_[depth] - begin,
                   RefitBoxNodes<R>{bvh_.data(), nodes_by_depth_.data() + begin, triangles_.data(), boxes_.data()},
                   kGrain);
    }
  }

  /// Leaves out the pairs of particles that cross the mesh now.
  void leave_out_crossing() {
    Memory<Executor>::fill(crossing_flags_.data(), crossing_flags_.size(), static_cast<unsigned char>(0));
    parallel_for(executor_, static_cast<int>(bodies_.size()),
                 FindMeshCrossings<R>{{bvh_.data(), static_cast<int>(bvh_.size())},
                                      bodies_.data(),
                                      triangles_.data(),
                                      x_.points(),
                                      crossing_flags_.data()},
                 kGrain / 8);
    const LeaveOutCrossing<R> leave_out{x_.points(), crossing_flags_.data(), min_distance_};
    const int now = static_cast<int>(parallel_reduce<Sum>(executor_, particles_, leave_out).value);
    // Particles that do not cross it any more are as near as they are.
    overlaps_ = overlaps_ || crossing_ || now > 0;
    crossing_ = now > 0, most_left_out_ = std::max(most_left_out_, now);
  }

  /// Finds candidates that serve several substeps of the present motion.
  void search() {
    parallel_for(executor_, particles_,
                 InitCandidateSearch<R>{x_.points(), d_.points(), x_then_.points(), d_then_.points(), R(kLookAhead)});
    search_again();
    ++facts_.searches;
  }
  /// Repeats the search from its stored start.
  void search_again() {
    box_particles(x_then_.points(), d_then_.points(), max(min_distance_, margin_) + slack_);
    Memory<Executor>::fill(has_candidates_.data(), has_candidates_.size(), static_cast<unsigned char>(0));
    const int n = static_cast<int>(bodies_.size());
    const auto launch = [&]<bool kStores>() {
      parallel_for(executor_, n,
                   FindEdgePairs<R, kStores, kDeforms>{{bvh_.data(), static_cast<int>(bvh_.size())},
                                                       bodies_.data(),
                                                       triangles_.data(),
                                                       boxes_.data(),
                                                       x_.points(),
                                                       d_then_.points(),
                                                       max(min_distance_, kDiagonal * margin_) + kDiagonal * slack_,
                                                       offset_.data(),
                                                       n,
                                                       candidates_found_,
                                                       candidates_.data(),
                                                       has_candidates_.data()},
                   kGrain / 8);
    };
    launch.template operator()<false>();
    candidates_found_ = running_sum(executor_, offset_.data(), n, sums_);
    candidates_.at_least(static_cast<std::size_t>(candidates_found_));
    if (candidates_found_ > 0) launch.template operator()<true>();
    searched_ = true;
  }

  void box_particles(const ScatteredPoints<R>& x, const ScatteredPoints<R>& d, R margin) {
    parallel_for(executor_, particles_, ComputeParticleBounds<R>{{x, d, margin, boxes_.data()}});
  }

  void update_contacts() {
    if (candidates_found_ > 0) box_particles(x_.points(), d_.points(), max(min_distance_, margin_));
    // Only one of the two sides moves and has a margin.
    const EvaluateCandidate<R> evaluate{
        candidates_.data(), {x_.points(), d_.points(), R(0.5) * margin_, boxes_.data()}, {min_distance_, recovery_}};
    const auto build_with = [&](const auto& with) {
      contacts_.build(with, candidates_found_, params_.data(), object_.data(), sums_);
    };
    const auto build = [&] {
      if constexpr (kDeforms)
        build_with(
            EvaluateDeformingCandidate<R>{evaluate, {normals_[0].data(), normals_[1].data(), particles_}, nullptr});
      else
        build_with(evaluate);
    };
    build();
    if (!overlaps_) return;
    overlaps_ = contacts_.grow_distances(x_.points(), params_.data(), object_.data(), min_distance_) > 0;
    build();
  }

  Executor executor_;
  int particles_;
  Array<Executor, Simplex> bodies_;
  const EnvironmentMesh& of_;  // any of the objects: they move alike, and the program may change how
  double h_;                   // s
  R recovery_;
  Vector3<double> centre_{};
  ObjectFrame before_{}, after_{};  // at the substep's start and end
  R min_distance_ = 0, margin_ = 0, slack_ = 0, least_ = 0;
  bool searched_ = false;
  bool overlaps_ = true;  // whether contact distances may be below the minimum distance
  int candidates_found_ = 0;
  EdgeStats facts_;
  Array<Executor, BoxNode> bvh_;
  Array<Executor, Simplex> triangles_;
  Array<Executor, EdgeContactParams<R>> params_;
  Points4 x_, d_, moved_, x_then_, d_then_;  // of particles; the first three also of points
  Array<Executor, int> object_, offset_;
  Array<Executor, Box<R>> boxes_;
  Array<Executor, R> w_;
  Array<Executor, unsigned char> has_candidates_;
  ScratchBuffer<Executor, int> sums_;
  ScratchBuffer<Executor, Candidate> candidates_;
  ContactList<Executor, R> contacts_;

  // State of a mesh that deforms.
  std::vector<Triangle> mesh_triangles_;
  DeformingPoints from_, now_;  // at the start and the end of the last substep
  struct {                      // of move_points(), for kernels
    std::vector<Vec4<R>> x, d;
    std::vector<Box<R>> boxes;
  } staged_points_;
  std::vector<int> depth_end_;                     // in nodes_by_depth_
  Array<Executor, int> nodes_by_depth_;            // of the BVH, the deepest first
  Array<Executor, Vec4<double>> normals_[2];       // of the points, at the substep's start and end
  Array<Executor, unsigned char> crossing_flags_;  // of each particle
  bool crossing_ = false;                          // whether any particle crossed the mesh when the last substep began
  int most_left_out_ = 0;
};

}  // namespace malha
