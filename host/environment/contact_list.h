// SPDX-License-Identifier: Apache-2.0
// List of contacts of deformable bodies with edges of the environment, in the executor's memory: built from candidates,
// projected, and truncated where bodies would intersect.
#pragma once
#include "host/base/array.h"
#include "host/base/radix_sort.h"
#include "host/base/scratch_buffer.h"
#include "host/model/model.h"
#include "kernels/environment/deforming_edge.h"

namespace malha {

template <class Executor, class R>
class ContactList {
 public:
  static constexpr int kGrain = 2048;

  ContactList(const Executor& executor, const Model& model)
      : executor_(executor), particles_(model.count()), truncated_(model.x.size(), 0) {
    if (model.scene.solver.dt / model.scene.solver.substeps > kLong) more_shares_ = kMoreShares;
  }

  /// Builds the contacts of `candidates` candidates. `object`: of each point; `params`: of each object; `sums`: scratch
  /// memory for prefix sums.
  template <class Evaluate>
  void build(Evaluate evaluate, int candidates, const EdgeContactParams<R>* params, const int* object,
             ScratchBuffer<Executor, int>& sums) {
    found_ = 0;
    if (candidates == 0) return;
    int* const offset = flags_.at_least(static_cast<std::size_t>(candidates));
    parallel_for(executor_, candidates, CountOverlappingCandidates<R>{evaluate, offset}, kGrain);
    found_ = running_sum(executor_, offset, candidates, sums);
    if (found_ == 0) return;
    const auto count = static_cast<std::size_t>(found_);
    contacts_.at_least(count), active_.at_least(count), impulses_.at_least(count);
    int* const ends = end_offsets_.at_least(count);
    if constexpr (requires { evaluate.carry; }) evaluate.carry = carries_.at_least(count);
    const BuildEdgeContacts<R, Evaluate> build{evaluate, params,     object,           offset, candidates,
                                               found_,   particles_, contacts_.data(), ends};
    parallel_for(executor_, candidates, build, kGrain);
    const int all = running_sum(executor_, ends, found_, sums);
    parallel_for(executor_, found_, ListContactEnds<R>{contacts_.data(), ends, particles_, ends_.items(all)}, kGrain);
    int bits = 1;
    while ((1 << bits) < particles_) ++bits;
    ends_.sort(executor_, all, bits, particles_);
  }

  /// Grows contact distances and returns how many particles are still below max_distance (GrowEdgeDistances).
  double grow_distances(const ScatteredPoints<R>& x, const EdgeContactParams<R>* params, const int* object,
                        R max_distance) {
    const bool any = found_ > 0;
    const GrowEdgeDistances<R> grow{
        x,      contacts_.data(), any ? ends_.sorted() : nullptr, any ? ends_.begin() : nullptr, params,
        object, max_distance};
    return parallel_reduce<Sum>(executor_, particles_, grow, kGrain).value;
  }

  /// One projection of all contacts. `moved`: displacements of the particles; their w is scratch memory for mass
  /// splitting; `w`: 1/kg; `friction` of a contact; `rotation` of impulses to the frame of p.
  template <class Friction>
  void project(const Displaced<R>& p, const R* w, const ScatteredPoints<R>& moved, const Friction& friction,
               const TurnToWorld& rotation) {
    ContactImpulse<R>* const impulses = impulses_.data();
    const int* const begin = ends_.begin();
    const auto split = [&] {
      parallel_for(executor_, particles_, SplitMasses<R>{w, ends_.sorted(), begin, impulses, moved}, kGrain);
    };
    parallel_for(executor_, found_, EstimateMassShares<R>{moved, contacts_.data(), w, impulses}, kGrain);
    split();
    for (int more = 0; more < more_shares_; ++more) {
      parallel_for(executor_, found_, RefineMassShares<R>{moved, contacts_.data(), impulses}, kGrain);
      split();
    }
    parallel_for(executor_, found_, SolveContactsJacobi<R, Friction>{moved, contacts_.data(), friction, impulses},
                 kGrain);
    parallel_for(executor_, particles_, ApplyImpulses<R, TurnToWorld>{p, w, ends_.sorted(), begin, impulses, rotation},
                 kGrain);
  }

  /// Marks the contacts that would intersect. Returns how many truncation can still resolve.
  double count_violations(const DivisionPlanes<R>& planes, const R* w) {
    const FindEdgeViolations<R> find{planes, contacts_.data(), truncated_.data(), w, active_.data()};
    return parallel_reduce<Sum>(executor_, found_, find, kGrain).value;
  }
  /// Truncates displacements until no contact violates its planes, to zero if `to_rest`. `left`: result of
  /// count_violations().
  void truncate(double left, const DivisionPlanes<R>& planes, const SetFromLocal<R>& offset, bool to_rest, const R* w) {
    for (; left > 0; left = count_violations(planes, w))
      parallel_for(executor_, particles_,
                   TruncateParticles<R, SetFromLocal<R>>{planes, offset, to_rest, contacts_.data(), ends_.sorted(),
                                                         ends_.begin(), active_.data(), w, truncated_.data()},
                   kGrain);
    end_guard();
  }

  /// Moves the particles of violating contacts with a mesh that deforms in front of the planes of all of their contacts
  /// (ProjectOntoPlanes). Returns how many moved.
  double project_onto_planes(const DivisionPlanes<R>& planes, const SetFromLocal<R>& set_position, GuardStart start,
                             const R* w) {
    const ProjectOntoPlanes<R, SetFromLocal<R>> project{
        planes,        set_position,   start, contacts_.data(), ends_.sorted(),
        ends_.begin(), active_.data(), w,     truncated_.data()};
    return parallel_reduce<Sum>(executor_, particles_, project, kGrain).value;
  }
  /// Ends the guard, in whose rounds particles that go with the mesh stay there.
  void end_guard() { Memory<Executor>::fill(truncated_.data(), truncated_.size(), static_cast<unsigned char>(0)); }
  /// The way by which the surface carries what sticks to it, of each contact with a mesh that deforms.
  const Vector3<R>* carries() const { return carries_.data(); }

  int found() const { return found_; }
  /// Number of contacts that pushed in the last substep.
  int pushed() const {
    if (pushed_ >= 0) return pushed_;
    return static_cast<int>(parallel_reduce<Sum>(executor_, found_, CountPushing<R>{contacts_.data()}).value);
  }
  void start_substep() { pushed_ = -1; }
  /// Caches pushed() before new contacts are built in the same substep.
  void cache_pushed() { pushed_ = pushed(); }

  std::size_t bytes() const {
    return truncated_.bytes() + flags_.bytes() + end_offsets_.bytes() + contacts_.bytes() + active_.bytes() +
           impulses_.bytes() + carries_.bytes() + ends_.bytes();
  }

 private:
  static constexpr double kLong =
      0.01;  // s: in longer substeps layers fall so far that one estimate of the shares is uneven
  static constexpr int kMoreShares = 2;  // refinements of the shares, in those

  Executor executor_;
  int particles_, found_ = 0, more_shares_ = 0;
  int pushed_ = -1;  // result of pushed() for contacts that were replaced; -1: none were
  Array<Executor, unsigned char> truncated_;
  ScratchBuffer<Executor, int> flags_, end_offsets_;
  ScratchBuffer<Executor, EdgeContact<R>> contacts_;
  ScratchBuffer<Executor, unsigned char> active_;
  ScratchBuffer<Executor, ContactImpulse<R>> impulses_;
  ScratchBuffer<Executor, Vector3<R>> carries_;  // empty for rigid objects
  Sorter<Executor> ends_;
};

}  // namespace malha
