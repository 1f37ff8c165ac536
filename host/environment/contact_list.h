// SPDX-License-Identifier: Apache-2.0
// The contacts of deformable bodies with edges of the environment in the executor's memory: laid down from candidates,
// projected, and held apart where they would cross.
#pragma once
#include "host/base/array.h"
#include "host/base/radix_sort.h"
#include "host/base/scratch_buffer.h"
#include "host/model/model.h"
#include "kernels/environment/edge_contact.h"

namespace malha {

template <class Executor, class R>
class ContactList {
 public:
  static constexpr int kGrain = 2048;

  ContactList(const Executor& executor, const Model& model)
      : executor_(executor), particles_(model.count()), held_(model.x.size(), 0) {
    if (model.scene.solver.dt / model.scene.solver.substeps > kLong) more_shares_ = kMoreShares;
  }

  /// Lays those of so many candidates that meet; `object`: of each point, `rules`: of each object; `sums`: memory for
  /// sums.
  void lay(const EvaluateCandidate<R>& look, int candidates, const EdgeContactParams<R>* rules, const int* object,
           ScratchBuffer<Executor, int>& sums) {
    found_ = 0;
    if (candidates == 0) return;
    int* const place = meets_.at_least(static_cast<std::size_t>(candidates));
    parallel_for(executor_, candidates, CountOverlappingCandidates<R>{look, place}, kGrain);
    found_ = running_sum(executor_, place, candidates, sums);
    if (found_ == 0) return;
    const auto many = static_cast<std::size_t>(found_);
    contacts_.at_least(many), active_.at_least(many), pushes_.at_least(many);
    int* const ends = ends_of_.at_least(many);
    const BuildEdgeContacts<R> lay{look, rules, object, place, candidates, found_, particles_, contacts_.data(), ends};
    parallel_for(executor_, candidates, lay, kGrain);
    const int all = running_sum(executor_, ends, found_, sums);
    parallel_for(executor_, found_, ListContactEnds<R>{contacts_.data(), ends, particles_, ends_.items(all)}, kGrain);
    int bits = 1;
    while ((1 << bits) < particles_) ++bits;
    ends_.sort(executor_, all, bits, particles_);
  }

  /// Grows contact distances and returns how many particles still have less than `most` (GrowEdgeDistances).
  double grow_distances(const ScatteredPoints<R>& x, const EdgeContactParams<R>* rules, const int* object, R most) {
    const bool any = found_ > 0;
    const GrowEdgeDistances<R> grow{
        x, contacts_.data(), any ? ends_.sorted() : nullptr, any ? ends_.begin() : nullptr, rules, object, most};
    return parallel_reduce<Sum>(executor_, particles_, grow, kGrain).value;
  }

  /// One projection of all. `moved`: how far particles have moved, with room for their parts of mass; `w`: 1/kg;
  /// `friction` of a contact; `turn`: of impulses, into the frame of p.
  void project(const Displaced<R>& p, const R* w, const ScatteredPoints<R>& moved, const ObjectFriction<R>& friction,
               const TurnToWorld& turn) {
    Push<R>* const pushes = pushes_.data();
    const int* const begin = ends_.begin();
    const auto split = [&] {
      parallel_for(executor_, particles_, SplitMasses<R>{w, ends_.sorted(), begin, pushes, moved}, kGrain);
    };
    parallel_for(executor_, found_, EstimateMassShares<R>{moved, contacts_.data(), w, pushes}, kGrain);
    split();
    for (int more = 0; more < more_shares_; ++more) {
      parallel_for(executor_, found_, RefineMassShares<R>{moved, contacts_.data(), pushes}, kGrain);
      split();
    }
    parallel_for(executor_, found_,
                 SolveContactsJacobi<R, ObjectFriction<R>>{moved, contacts_.data(), friction, pushes}, kGrain);
    parallel_for(executor_, particles_, ApplyImpulses<R, TurnToWorld>{p, w, ends_.sorted(), begin, pushes, turn},
                 kGrain);
  }

  /// Marks the pairs that are about to cross: how many of them holding back can still help.
  double crossing(const DivisionPlanes<R>& planes, const R* w) {
    const FindEdgeViolations<R> find{planes, contacts_.data(), held_.data(), w, active_.data()};
    return parallel_reduce<Sum>(executor_, found_, find, kGrain).value;
  }
  /// Holds back what crosses, `left` by crossing(), until nothing does; where it was, if it `rests`.
  void hold(double left, const DivisionPlanes<R>& planes, const SetFromLocal<R>& place, bool rests, const R* w) {
    for (; left > 0; left = crossing(planes, w))
      parallel_for(executor_, particles_,
                   TruncateParticles<R, SetFromLocal<R>>{planes, place, rests, contacts_.data(), ends_.sorted(),
                                                   ends_.begin(), active_.data(), w, held_.data()},
                   kGrain);
    Memory<Executor>::fill(held_.data(), held_.size(), static_cast<unsigned char>(0));
  }

  int found() const { return found_; }
  /// Contacts that pushed in the last substep.
  int pushed() const {
    if (pushed_ >= 0) return pushed_;
    return static_cast<int>(parallel_reduce<Sum>(executor_, found_, CountPushing<R>{contacts_.data()}).value);
  }
  void start_substep() { pushed_ = -1; }
  /// Before others are laid in the same substep.
  void keep_pushed() { pushed_ = pushed(); }

  std::size_t bytes() const {
    return held_.bytes() + meets_.bytes() + ends_of_.bytes() + contacts_.bytes() + active_.bytes() + pushes_.bytes() +
           ends_.bytes();
  }

 private:
  static constexpr double kLong = 0.01;  // s: in longer substeps a layer falls so far that one push is far from even
  static constexpr int kMoreShares = 2;  // a push, in those

  Executor executor_;
  int particles_, found_ = 0, more_shares_ = 0;
  int pushed_ = -1;  // contacts that did, where others were laid since
  Array<Executor, unsigned char> held_;
  ScratchBuffer<Executor, int> meets_, ends_of_;
  ScratchBuffer<Executor, SelfContact<R>> contacts_;
  ScratchBuffer<Executor, unsigned char> active_;
  ScratchBuffer<Executor, Push<R>> pushes_;
  Sorter<Executor> ends_;
};

}  // namespace malha
