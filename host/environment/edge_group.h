// SPDX-License-Identifier: Apache-2.0
// Collision of deformable bodies with edges and corners of environment objects that move together: candidates,
// contacts, their projection, and the final guard, all in the objects' frame, where only particles move.
#pragma once
#include <algorithm>
#include <array>
#include <vector>

#include "host/attachments/pose.h"
#include "host/base/point_array.h"
#include "host/environment/contact_list.h"
#include "host/environment/edge_memory.h"
#include "host/environment/edge_surface.h"
#include "host/measure/solver_stats.h"
#include "kernels/self_collision/contact_distance.h"

namespace malha {

template <class Executor, class R>
class EdgeGroup {
 public:
  /// `bodies`: simplices of the deformable bodies.
  EdgeGroup(const Executor& executor, const Model& model, const std::vector<Simplex>& bodies,
            const std::vector<const EnvironmentMesh*>& objects)
      : executor_(executor),
        particles_(model.count()),
        bodies_(bodies),
        of_(*objects[0]),
        recovery_(R(recovery_share(model.scene.solver.dt / model.scene.solver.substeps))),
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
    x_then_ = Points4(n), d_then_ = Points4(n);
    object_ = Array<Executor, int>(object), boxes_ = Array<Executor, Box<R>>(boxes);
    w_ = Array<Executor, R>(all, R(0));
    has_candidates_ = Array<Executor, unsigned char>(n, 0);
    offset_ = Array<Executor, int>(bodies.size(), 0);
  }

  /// Detects the contacts for x0 -> p, x0 the last positions without intersections; from `start` to `end` (s).
  void detect_contacts(const Particles<R>& particles, const ScatteredPoints<R>& x0, double start, double end) {
    before_ = {pose_at(of_.spec.motion, start), centre_};
    after_ = {pose_at(of_.spec.motion, end), centre_};
    Memory<Executor>::copy(particles.w, static_cast<std::size_t>(particles_), w_.data());
    parallel_for(executor_, particles_, StartLocal<R>{x0, before_, x_.points()});
    update_contacts(particles);
    contacts_.start_substep();
  }

  /// One projection of all contacts.
  void solve_contacts(const Particles<R>& particles) {
    if (contacts_.found() == 0) return;
    store_motion(particles);
    contacts_.project(particles.p, w_.data(), moved_.points(), ObjectFriction<R>{params_.data(), object_.data()},
                      TurnToWorld{after_.pose});
  }

  /// Final guard: resolves intersections at the end of the substep, by projection if that is enough (and can_project),
  /// by truncation otherwise; truncated particles are marked in `marks` if that is enabled, and rest then. Returns
  /// whether anything moved.
  bool resolve_intersections(const Particles<R>& particles, bool can_project, const KinematicMarks<R>& marks) {
    store_motion(particles);
    const auto leaves_bounds = [&] {
      const CountBoundsViolations<R> count{x_.points(),      moved_.points(), d_.points(), x_then_.points(),
                                           d_then_.points(), margin_,         slack_,      has_candidates_.data()};
      return parallel_reduce<Sum>(executor_, particles_, count).value > 0;
    };
    if (leaves_bounds()) {
      contacts_.cache_pushed();
      update_contacts(particles);
      ++facts_.substeps_redetected;
    }
    if (contacts_.found() == 0) return false;
    const DivisionPlanes<R> planes{x_.points(), moved_.points(), least_};
    double left = contacts_.count_violations(planes, w_.data());
    if (!(left > 0)) return false;
    for (int more = 0; can_project && left > 0 && more < kMoreProjections; ++more) {
      solve_contacts(particles);
      store_motion(particles);
      if (leaves_bounds()) {
        contacts_.cache_pushed();
        update_contacts(particles);
      }
      left = contacts_.count_violations(planes, w_.data());
    }
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

  /// Motion of the objects in this substep, from the world to the world.
  Pose motion() const { return from_to(before_.pose, after_.pose); }

  /// Appends the state that later substeps depend on.
  void save(EdgeMemory<R>& memory) const {
    const auto from = x_then_.template download<std::array<R, 3>>(),
               way = d_then_.template download<std::array<R, 3>>();
    memory.from.insert(memory.from.end(), from.begin(), from.end());
    memory.way.insert(memory.way.end(), way.begin(), way.end());
    const auto distance = x_.download_fourth(static_cast<std::size_t>(particles_));
    memory.contact_distance.insert(memory.contact_distance.end(), distance.begin(), distance.end());
    memory.valid.push_back(searched_ ? 1 : 0);
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
           offset_.bytes() + bodies_.bytes() + sums_.bytes() + candidates_.bytes() + contacts_.bytes();
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
  static constexpr double kLookAhead = 8;                // substeps of motion that the search looks ahead
  static constexpr R kDiagonal = R(1.7320508075688772);  // of a cube of side 1
  static constexpr double kLeastGap = 0.01;              // of the thickness
  static constexpr R kRounding = R(0.99);                // share of the slack that rounding leaves

  void store_motion(const Particles<R>& particles) {
    parallel_for(executor_, particles_, MoveLocal<R>{particles.p, after_, x_.points(), moved_.points()}, kGrain);
  }

  void update_contacts(const Particles<R>& particles) {
    store_motion(particles);
    const CheckCandidateBounds<R> own{moved_.points(),  x_.points(),      d_.points(),
                                      x_then_.points(), d_then_.points(), kRounding * slack_};
    const double left = parallel_reduce<Sum>(executor_, particles_, own).value;
    if (!searched_ || left > 0) search();
    update_contacts();
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
                   FindEdgePairs<R, kStores>{{bvh_.data(), static_cast<int>(bvh_.size())},
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
    const auto build = [&] { contacts_.build(evaluate, candidates_found_, params_.data(), object_.data(), sums_); };
    build();
    if (!overlaps_) return;
    overlaps_ = contacts_.grow_distances(x_.points(), params_.data(), object_.data(), min_distance_) > 0;
    build();
  }

  Executor executor_;
  int particles_;
  Array<Executor, Simplex> bodies_;
  const EnvironmentMesh& of_;  // any of the objects: they move alike, and the program may change how
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
};

}  // namespace malha
