// Deformable bodies against themselves and each other, substep by substep: candidates from a grid, contacts, their
// projection, and the guarantee that nothing crosses. Made only for scenes that name self_collision.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "host/base/point_array.h"
#include "host/collision/contact_list.h"
#include "host/collision/self_facts.h"
#include "host/model/self_surface.h"
#include "kernels/hold_apart.h"

namespace malha {

template <class Executor, class R>
class SelfCollider {
 public:
  SelfCollider(const Executor& executor, const Model& model)
      : executor_(executor),
        surface_(self_surface(model)),
        count_(model.count()),
        friction_(R(model.scene.self_collision->friction)),
        contacts_(executor, model) {
    const double thickness = model.scene.self_collision->thickness;
    for (int i = 0; i < count_; ++i) has_pins_ = has_pins_ || (surface_.takes_part[i] && model.w[i] == 0);
    facts_.particles = surface_.particles, facts_.edges = surface_.edges, facts_.triangles = surface_.triangles;
    rules_ = {R(thickness), R(kRecovery)};
    margin_ = R(thickness * kMargin), slack_ = R(thickness * kSlack);
    simplices_ = Array<Executor, Simplex>(surface_.simplices);
    takes_part_ = Array<Executor, unsigned char>(surface_.takes_part);
    body_ = Array<Executor, int>(surface_.body);
    rest_ = Points4(model.x), x0_ = Points4(model.x);
    for (Points4* points : {&moved_, &d_, &x_then_, &d_then_}) *points = Points4(model.x.size());
    boxes_ = Array<Executor, Box<R>>(surface_.simplices.size(), Box<R>{});
    reach_boxes_ = Array<Executor, Box<R>>(model.x.size(), Box<R>{});
    place_ = Array<Executor, int>(surface_.simplices.size(), 0);
  }

  /// Lays the contacts for x0 -> p, x0 the last positions in which nothing crossed.
  void find(const Particles<R>& particles) {
    if (!reach(particles, true)) search(kAhead);
    lay_contacts();
    contacts_.start_substep();
  }

  /// One projection of all contacts.
  void resolve(const Particles<R>& particles) {
    if (contacts_.found() == 0) return;
    store_motion(particles);
    contacts_.project(particles.p, particles.w, moved_.points(), OneFriction<R>{friction_}, AsTheyAre{});
  }

  /// The end of a substep: nothing crosses. What jams is held back; where touches() says that nothing holds the bodies,
  /// they keep their momentum all the same.
  template <class Touches>
  void hold_apart(const Particles<R>& particles, const Touches& touches) {
    const MeanMotion before = has_pins_ ? MeanMotion{} : momentum(particles);
    keep_in_reach(particles);
    hold_crossing(particles);
    if (before.weight > 0) give_back(particles, before, touches);
  }

  /// Where all is now is where the next substep begins.
  void settle(const Particles<R>& particles) {
    parallel_for(executor_, count_, CopyPoints<R>{particles.p, x0_.points()});
  }

  /// Contacts that pushed in the last substep.
  int contacts() const { return contacts_.pushed(); }

  const SelfSurface& surface() const { return surface_; }
  const SelfFacts& facts() const { return facts_; }
  std::size_t bytes() const {
    return simplices_.bytes() + takes_part_.bytes() + body_.bytes() + 6 * x0_.bytes() + boxes_.bytes() +
           reach_boxes_.bytes() + place_.bytes() + sums_.bytes() + cells_.bytes() + candidates_.bytes() +
           contacts_.bytes();
  }

  /// What a later substep depends on, for checkpoints: positions in which nothing crosses.
  std::vector<std::array<R, 3>> memory() const { return x0_.template download<std::array<R, 3>>(); }
  void remember(const std::vector<std::array<R, 3>>& x0) { x0_.upload(x0), searched_ = false; }

 private:
  using Points4 = ScatteredArray<Executor, R>;

  static constexpr int kGrain = ContactList<Executor, R>::kGrain;
  static constexpr int kMoreProjections = 8;
  static constexpr double kMargin = 0.5;    // of the thickness: constraints may pull as far past the prediction
  static constexpr double kSlack = 0.5;     // of the thickness: candidates are found that much further
  static constexpr double kAhead = 8;       // and along the motion of so many substeps
  static constexpr double kRecovery = 0.1;  // a substep
  static constexpr R kLeastGap = R(0.02);   // of the thickness
  static constexpr R kRounding = R(0.99);   // of a margin: what rounding leaves of it
  static constexpr double kMostCells = 64;  // a simplex, on average

  static Vector3<R> to_R(const Vec3& a) { return {R(a[0]), R(a[1]), R(a[2])}; }
  Reaches<R> reaches() const { return {x0_.points(), d_.points(), origin_, margin_, reach_boxes_.data()}; }

  void store_motion(const Particles<R>& particles) {
    parallel_for(executor_, count_, StoreMotion<R>{particles.p, x0_.points(), moved_.points()}, kGrain);
  }

  void keep_in_reach(const Particles<R>& particles) {
    parallel_for(executor_, count_, KeepInReach<R>{reaches(), common_, particles.p, particles.w, takes_part_.data()},
                 kGrain);
  }

  MeanMotion momentum(const Particles<R>& particles) const {
    return parallel_reduce<MeanMotion>(executor_, count_,
                                       SumMomentum<R>{particles.p, x0_.points(), particles.w, takes_part_.data()});
  }

  /// What the particles have lost of their momentum, by moving all alike, unless something else holds them.
  template <class Touches>
  void give_back(const Particles<R>& particles, const MeanMotion& before, const Touches& touches) {
    const MeanMotion after = momentum(particles);
    const auto lost = [&](int k) { return (before.sum[k] - after.sum[k]) / before.weight; };
    if ((lost(0) != 0 || lost(1) != 0 || lost(2) != 0) && !touches())
      parallel_for(executor_, count_,
                   Translate<R>{particles.p, takes_part_.data(), {R(lost(0)), R(lost(1)), R(lost(2))}});
  }

  void hold_crossing(const Particles<R>& particles) {
    const PairPlanes<R> planes{x0_.points(), moved_.points(), kLeastGap * rules_.thickness};
    store_motion(particles);
    double left = contacts_.crossing(planes, particles.w);
    for (int more = 0; left > 0 && more < kMoreProjections; ++more) {
      resolve(particles);
      keep_in_reach(particles);
      store_motion(particles);
      left = contacts_.crossing(planes, particles.w);
    }
    if (!(left > 0)) return;
    ++facts_.held;
    if (larger(magnitude(common_.x), larger(magnitude(common_.y), magnitude(common_.z))) > kRounding * margin_) {
      meet_at_rest(particles);
      left = contacts_.crossing(planes, particles.w);
    }
    contacts_.hold(left, planes, PlaceInWorld<R>{particles.p}, particles.w);
  }

  /// What is held is at rest in the world, which is no place in a reach that has moved on with the common motion. What
  /// it may meet there: all that lies on the ways of this substep.
  void meet_at_rest(const Particles<R>& particles) {
    contacts_.keep_pushed();
    reach(particles, false);
    search(1);
    lay_contacts();
    searched_ = false;
  }

  /// How far the particles may go, beside their common motion if reaches are to move with it. Returns whether the
  /// candidates that are known still hold all pairs that may meet.
  bool reach(const Particles<R>& particles, bool moves) {
    store_motion(particles);
    const MeanMotion mean =
        parallel_reduce<MeanMotion>(executor_, count_, SumMotion<R>{moved_.points(), takes_part_.data()});
    const double per = moves && mean.weight > 0 ? 1 / mean.weight : 0;
    for (int k = 0; k < 3; ++k) since_[k] += last_common_[k], last_common_[k] = mean.sum[k] * per;
    common_ = to_R(last_common_);
    const OwnMotion<R> own{moved_.points(),  x0_.points(),     common_,      d_.points(),
                           x_then_.points(), d_then_.points(), to_R(since_), kRounding * slack_};
    const double left = parallel_reduce<Sum>(executor_, count_, own).value;
    Vec4<R> first;
    Memory<Executor>::copy_out(x0_.points().of, 1, &first);
    origin_ = first.xyz();
    return searched_ && left == 0;
  }

  /// Finds candidates that last for some substeps of the present motion.
  void search(double ahead) {
    parallel_for(executor_, count_,
                 StartSearch<R>{x0_.points(), d_.points(), x_then_.points(), d_then_.points(), R(ahead)});
    since_ = {};
    parallel_for(executor_, count_,
                 BoxParticles<R>{{x_then_.points(), d_then_.points(), origin_, margin_ + slack_, reach_boxes_.data()}});
    enter_grid();
    find_candidates();
    searched_ = true, ++facts_.searches;
  }

  /// Cells about as wide as the mean box, or, where that would make too many, wider.
  void enter_grid() {
    const int n = static_cast<int>(simplices_.size());
    const Extent sides = parallel_reduce<Extent>(
        executor_, n, BoxSimplices<R>{reach_boxes_.data(), simplices_.data(), boxes_.data()}, kGrain);
    double cell = std::max(kCellSize * sides.sum / n, 1e-30), entries = 0;
    for (;; cell *= 2) {
      grid_ = {R(1 / cell), 0};
      entries = parallel_reduce<Extent>(executor_, n, CountCells<R>{grid_, boxes_.data(), place_.data()}, kGrain).sum;
      if (entries <= kMostCells * n) break;
    }
    grid_.bits = 1;
    while (grid_.bits < 2 * kDigitBits && (1 << grid_.bits) < entries) ++grid_.bits;
    const int total = running_sum(executor_, place_.data(), n, sums_);
    parallel_for(executor_, n, EnterCells<R>{grid_, boxes_.data(), place_.data(), cells_.items(total)}, kGrain);
    cells_.sort(executor_, total, grid_.bits, 1 << grid_.bits);
  }

  void find_candidates() {
    const int n = static_cast<int>(simplices_.size());
    const auto launch = [&]<bool kLays>() {
      parallel_for(executor_, n,
                   FindCandidates<R, kLays>{grid_, reach_boxes_.data(), simplices_.data(), boxes_.data(),
                                            cells_.sorted(), cells_.begin(), place_.data(), candidates_.data()},
                   kGrain / 8);
    };
    launch.template operator()<false>();
    candidates_found_ = running_sum(executor_, place_.data(), n, sums_);
    candidates_.at_least(candidates_found_);
    launch.template operator()<true>();
  }

  void lay_contacts() {
    const int n = candidates_found_;
    const LookAtCandidate<R> look{candidates_.data(), reaches(), rest_.points(), body_.data(), rules_};
    parallel_for(executor_, count_, BoxParticles<R>{reaches()});
    contacts_.lay(
        look, n, sums_,
        [&](const int* place, int total, SelfContact<R>* contacts, int* ends) {
          return LayContacts<R>{look, place, n, total, contacts, ends};
        },
        [](const SelfContact<R>* contacts, const int* place, Keyed* ends) {
          return EnterEnds<R>{contacts, place, ends};
        });
  }

  static constexpr double kCellSize = 2;

  Executor executor_;
  SelfSurface surface_;
  int count_;
  R friction_, margin_ = 0, slack_ = 0;
  Vec3 since_{}, last_common_{};
  bool searched_ = false, has_pins_ = false;
  ContactRules<R> rules_{};
  Vector3<R> common_{}, origin_{};
  Grid<R> grid_{};
  int candidates_found_ = 0;
  SelfFacts facts_;
  Array<Executor, Simplex> simplices_;
  Array<Executor, unsigned char> takes_part_;
  Array<Executor, int> body_, place_;
  Points4 rest_, x0_, moved_, d_, x_then_, d_then_;
  Array<Executor, Box<R>> boxes_, reach_boxes_;
  Growing<Executor, int> sums_;
  Growing<Executor, Candidate> candidates_;
  Sorter<Executor> cells_;
  ContactList<Executor, R> contacts_;
};

}  // namespace malha
