// SPDX-License-Identifier: Apache-2.0
// All environment meshes of a scene: their contacts with the particles, substep by substep. Made only for scenes that
// have an environment; without one there is no Embree device.
#pragma once
#include <algorithm>
#include <cmath>
#include <deque>
#include <vector>

#include "host/attachments/pose.h"
#include "host/base/array.h"
#include "host/base/point_array.h"
#include "host/environment/clamp_tunnelling.h"
#include "host/environment/contact_cache_storage.h"
#include "host/environment/contact_query_device.h"
#include "host/environment/find_contact.h"
#include "host/environment/host_query_staging.h"
#include "host/measure/solver_stats.h"
#include "host/model/model.h"
#include "kernels/environment/clearance.h"

namespace malha {

template <class Executor, class R>
class EnvironmentCollider {
 public:
  EnvironmentCollider(const Executor& executor, const Model& model)
      : executor_(executor),
        host_words_(executor),
        particles_(model.x.size()),
        words_(static_cast<int>(words_of(particles_))) {
    for (const EnvironmentMesh& mesh : model.environment) {
      obstacles_.emplace_back(Surface(device_, mesh.mesh), mesh.spec, model.x.size());
      bounces_ = bounces_ || mesh.spec.restitution > 0;
    }
    const std::size_t questions = kOnHost ? 2 : obstacles_.size() + 2;
    if (!kOnHost) tested_ = Array<Executor, BroadPhaseCounts>(obstacles_.size(), BroadPhaseCounts{});
    bits_ = Array<Executor, unsigned long long>(questions * static_cast<std::size_t>(words_), 0ull);
  }

  /// Detects the contacts for x -> p; the meshes move from their poses at `start` to those at `end` (s). While the host
  /// runs the Embree queries, go_on(mask) may launch device work that does not touch the queried particles.
  template <class GoOn>
  void detect_contacts(const Particles<R>& particles, double start, double end, [[maybe_unused]] const GoOn& go_on) {
    place_meshes(start, end);
    for (Obstacle& o : obstacles_) invalidate(o, particles, o.spec.motion.empty() ? o.spec.thickness / 2 : -1);
    if constexpr (kOnHost)
      find_on_host(particles);
    else
      find_on_device(particles, go_on);
  }
  void detect_contacts(const Particles<R>& particles, double start, double end) {
    detect_contacts(particles, start, end, [](const ActiveMask&) {});
  }

  void solve_contacts(const Particles<R>& particles) {
    for (Obstacle& o : obstacles_)
      parallel_for(executor_, o.memory.slots(),
                   ResolveContact<R>{particles.p, o.memory.view().contacts, R(o.spec.friction)});
  }

  /// After the last iteration: nothing that was dragged crosses a surface.
  void clamp_tunnelling(const Particles<R>& particles) {
    hold_crossing<PutBeforeMeshes<R>>(find_crossing(particles), particles);
  }

  /// After what holds bodies apart: what it has moved across a surface goes with that mesh instead, from where it came,
  /// or, unless `carries`, is put before it. `held` notes it, by numbers of meshes. Returns whether anything moved.
  bool move_with_meshes(const Particles<R>& particles, const HeldByEdges<R>& held, bool carries) {
    const ActiveCount asked = find_crossing(particles);
    if (asked.particles == 0) return false;
    if (before_.size() == 0) before_ = PointArray<Executor, R>(static_cast<std::size_t>(particles.count));
    parallel_for(executor_, particles.count, CopyPoints<R, Points<R>, Points<R>>{particles.p.d, before_.points()});
    carries ? hold_crossing<CarryBeforeMeshes<R>>(asked, particles)
            : hold_crossing<PutBeforeMeshes<R>>(asked, particles);
    std::vector<Pose> motion;
    append_motion(motion);
    const Array<Executor, Pose> there(motion);
    const NoteCarried<R> note{particles, before_.points(), held, there.data(), count()};
    return parallel_reduce<Sum>(executor_, particles.count, note).value > 0;
  }
  /// Adds how each mesh moves in this substep.
  void append_motion(std::vector<Pose>& motion) const {
    for (const MovingSurface& mesh : meshes_) motion.push_back(mesh.motion());
  }
  /// From here on meshes are where they are at the end of this substep.
  void end_motion() {
    for (MovingSurface& mesh : meshes_) mesh.before = mesh.after;
  }

  bool moves() const {
    return std::any_of(obstacles_.begin(), obstacles_.end(), [](const Obstacle& o) { return !o.spec.motion.empty(); });
  }

  /// Memory for questions of speed.
  void allocate_clearance() { rooms_ = Array<Executor, Clearance>(static_cast<std::size_t>(words_), Clearance{}); }
  /// Lets particles that are nearer than the thickness now stay as near until they leave by themselves.
  void keep_overlaps() {
    for (Obstacle& o : obstacles_)
      parallel_for(executor_, o.memory.slots(), KeepOverlap{o.memory.view().near, 2 * o.spec.thickness});
  }

  /// How fast (m/s) particles may be during the next `substeps` of h seconds, so that they need no look at meshes that
  /// do not move: none comes so near that a contact were laid, or anything held back. 0: they do need it. `g`: of
  /// gravity, m/s^2.
  double max_contact_free_speed(const Particles<R>& particles, double h, int substeps, double g) {
    const auto rounding = static_cast<float>(4e-6 + 4e-7 * substeps);  // of a substep two, of a first test some ten
    for (int k = 0; k < count(); ++k) {
      const ContactCacheView<R> nearby = obstacles_[k].memory.view();
      words(particles.count > kParticleGrain,
            MeasureRoom<R>{particles.x, particles.v, particles.w, particles.count, nearby,
                           static_cast<float>(2 * obstacles_[k].spec.thickness), rounding, k == 0, rooms_.data()});
    }
    const MinClearance all = parallel_reduce<MinClearance>(executor_, words_, SumRooms{rooms_.data()});
    const double speed = (all.distance - g * h * h) / ((substeps + 1) * h);
    return std::sqrt(all.speed2) + g * h * substeps < speed ? speed : 0;
  }

  /// Before substeps without looks.
  void invalidate_contacts(const Particles<R>& particles) {
    for (Obstacle& o : obstacles_) invalidate(o, particles, -1);
  }

  /// After a substep without looks, of h seconds and with its new state, in which particles were faster than they may.
  void clamp_tunnelling_late(const Particles<R>& particles, double start, double h) {
    const PointArray<Executor, R> before(static_cast<std::size_t>(particles.count));
    Particles<R> then = particles;
    then.x = then.p.x = before.points();
    parallel_for(executor_, particles.count, ReconstructPrevious<R>{particles, then.x, R(h)});
    place_meshes(start, start + h);
    clamp_tunnelling(then);
    parallel_for(executor_, particles.count, KeepHeld<R>{particles, R(1 / h)});
  }

  /// `resting`: the speed that gravity gives in two substeps, below which nothing bounces (m/s).
  void restitute(const Particles<R>& particles, double resting, double h) {
    for (Obstacle& o : obstacles_)
      parallel_for(executor_, o.memory.slots(),
                   ApplyRestitution<R>{particles.p, particles.v, o.memory.view().contacts, R(o.spec.restitution),
                                       R(o.spec.friction), R(resting), R(1 / h)});
    if (!bounces_) return;
    parallel_for(executor_, words_, FindBounced<R>{particles, bits(0)});
    on_words<HoldBounce<R>>(count_asked(0), particles);
  }

  /// Whether restitute moves anything.
  bool bounces() const { return bounces_; }

  /// Contacts that pushed in the last substep.
  int contacts() const {
    double sum = 0;
    for (const Obstacle& o : obstacles_)
      sum += parallel_reduce<Sum>(executor_, o.memory.slots(), CountContact<R>{o.memory.view().contacts}).value;
    return static_cast<int>(sum);
  }

  /// How deep the deepest particle lies below a surface (m) at the given time, or was when it was pressed through one.
  double max_penetration(const Particles<R>& particles, double time) const {
    double deepest = 0;
    for (const Obstacle& o : obstacles_) {
      const MeasureDepth<R> kernel{&o.surface, o.spec.sides, pose_at(o.spec.motion, time), particles, o.memory.view()};
      deepest = std::max(deepest, parallel_reduce<Deepest>(executor_, particles.count, kernel, kGrain).depth);
    }
    return deepest;
  }

  std::size_t bytes() const {
    std::size_t sum = bits_.bytes() + rooms_.bytes() + host_words_.bytes() + before_.bytes();
    for (const Obstacle& o : obstacles_) sum += o.memory.bytes() + o.surface.bytes();
    return sum;
  }

  ContactStats facts() const {
    ContactStats facts = facts_;
    facts.far_bytes = bits_.bytes() + rooms_.bytes() + host_words_.bytes() + before_.bytes();
    for (const Obstacle& o : obstacles_) {
      facts.near += o.memory.near();
      facts.far_bytes += o.memory.bytes() - o.memory.near_bytes(), facts.near_bytes += o.memory.near_bytes();
      facts.cell_bytes += o.surface.cell_bytes(), facts.queries += o.surface.queries();
    }
    return facts;
  }

  /// The contact cache of a mesh, valid until the next detect_contacts or clamp_tunnelling.
  ContactCacheView<R> nearby(int mesh) const { return obstacles_[static_cast<std::size_t>(mesh)].memory.view(); }

  /// How many triangles each mesh has.
  std::vector<int> triangles() const {
    std::vector<int> counts;
    for (const Obstacle& o : obstacles_) counts.push_back(o.surface.triangles());
    return counts;
  }

  /// Passes on what a later substep depends on, for checkpoints, as ContactMemory does, but mesh by mesh: a copy of
  /// what 1,000 meshes know may be as large as everything else.
  template <class Take>
  void tell(const Take& take) const {
    for (const Obstacle& o : obstacles_) take(o.memory.boxes());
    for (const Obstacle& o : obstacles_) take(o.memory.places());
    for (std::size_t k = 0; k < obstacles_.size(); ++k) take(obstacles_[k].memory.near_pairs(first_pair(k)));
  }
  std::size_t box_count() const { return obstacles_.size() * words_of(particles_); }
  std::size_t near_count() const {
    std::size_t sum = 0;
    for (const Obstacle& o : obstacles_) sum += static_cast<std::size_t>(o.memory.near());
    return sum;
  }
  std::size_t most_places() const {
    std::size_t sum = 0;
    for (const Obstacle& o : obstacles_) sum += o.memory.most_places();
    return sum;
  }
  void restore_state(const ContactMemory& all) {
    const std::size_t words = words_of(particles_);
    const PlaceSeen* place = all.places.data();
    const SeenOfPair *from = all.near.data(), *const last = from + all.near.size();
    for (std::size_t k = 0; k < obstacles_.size(); ++k) {
      const SeenOfPair* const end =
          std::find_if(from, last, [&](const auto& a) { return a.pair >= first_pair(k + 1); });
      NearMemory<Executor, R>& memory = obstacles_[k].memory;
      if (all.boxes.empty()) {
        memory.forget(executor_);
      } else {
        const WordBox* const first = all.boxes.data() + k * words;
        memory.restore_state(executor_, {first, first + words}, place, from, static_cast<std::size_t>(end - from),
                             first_pair(k));
        place += places_of(first, particles_);
      }
      from = end;
    }
  }

 private:
  static constexpr bool kOnHost = Memory<Executor>::kOnHost;
  static constexpr int kGrain = 64;    // a query of a whole mesh costs about as much as a hundred plain updates
  static constexpr int kLooks = 1024;  // fewer take less time than a second thread, where cores are shared
  struct Obstacle {
    Obstacle(Surface s, const EnvironmentSpec& e, std::size_t particles)
        : surface(std::move(s)), spec(e), memory(particles) {}
    Surface surface;
    EnvironmentSpec spec;
    NearMemory<Executor, R> memory;
  };

  int count() const { return static_cast<int>(obstacles_.size()); }
  long long first_pair(std::size_t mesh) const { return static_cast<long long>(mesh * particles_); }

  /// `way`: see InvalidateContacts. On ways of up to half the thickness contacts are planes, whatever the distance.
  void invalidate(Obstacle& o, const Particles<R>& particles, double way) {
    parallel_for(executor_, o.memory.slots(), InvalidateContacts<R>{o.memory.view().contacts, particles.p, way});
  }

  void place_meshes(double start, double end) {
    meshes_.clear(), nearby_.clear();
    for (Obstacle& o : obstacles_) {
      meshes_.push_back(
          {&o.surface, o.spec.sides, o.spec.thickness, pose_at(o.spec.motion, start), pose_at(o.spec.motion, end)});
      if (o.surface.tidy()) o.memory.forget_cells(executor_);
      nearby_.push_back(o.memory.view());
    }
  }
  EnvironmentView<R> surroundings(const Particles<R>& particles) {
    return {meshes_.data(), count(), particles, nearby_.data()};
  }

  void find_on_host(const Particles<R>& particles) {
    for (int k = 0; k < count(); ++k) {
      broad_phase(particles, k, reach(k), bits(0), false);
      const int looks = reserve_slots(k, k + 1, {bits(0), 1, words_}).particles;
      facts_.looks += looks;
      deal_words(looks, FindContact<R>{surroundings(particles), k, bits(0)});
    }
  }
  /// Queries all meshes in one pass. Depenetration on the device is limited to particles near a single mesh, and to
  /// less than their distance from the others.
  template <class GoOn>
  void find_on_device(const Particles<R>& particles, const GoOn& go_on) {
    for (int k = 0; k < count(); ++k) broad_phase(particles, k, reach(k), bits(k), false);
    const int looks = reserve_slots(0, count(), {bits(0), count(), words_}).particles;
    facts_.looks += looks;
    if (looks == 0) return;
    const EnvironmentView<R> there = surroundings(particles);
    const ActiveMask asked{bits(0), count(), words_};
    unsigned long long *const once = bits(count()), *const lifted = bits(count() + 1);
    parallel_for(executor_, words_, FindAskedOnce{asked, once, lifted});
    for (int k = 0; k < count(); ++k) {
      double most_lift = INFINITY;
      for (int other = 0; other < count(); ++other)
        if (other != k) most_lift = std::min(most_lift, double(reach(other)));
      const ListBits own{bits(k), k > 0 ? bits(k - 1) : nullptr, once, lifted};
      parallel_for(executor_, words_, GivePlaces<R>(look_at(there, k), own));
      parallel_for(executor_, particles.count, AnswerByLists<R>(look_at(there, k), own, most_lift));
    }
    const ActiveCount left = parallel_reduce<ActiveCount>(executor_, words_, CountActive{asked});
    if (left.particles == 0) return;
    const auto look = [&](const auto& all, const auto& cargo) {
      for (int k = 0; k < count(); ++k)
        parallel_for_interleaved(executor_, cargo.words, FindContact<R>{all, k, cargo.bits(k)});
    };
    host_words_.ask(there, asked, left, look, go_on);
  }

  /// Marks the particles whose way may lead through a surface. On a device they get slots at all meshes.
  ActiveCount find_crossing(const Particles<R>& particles) {
    for (int k = 0; k < count(); ++k) broad_phase(particles, k, -1, bits(0), k > 0);
    if constexpr (kOnHost)
      return count_asked(0);
    else
      return reserve_slots(0, count(), {bits(0), 1, words_});
  }
  ActiveCount count_asked(int question) {
    return parallel_reduce<ActiveCount>(executor_, words_, CountActive{{bits(question), 1, words_}});
  }

  float reach(int k) const { return static_cast<float>(2 * meshes_[k].thickness); }
  unsigned long long* bits(int question) const { return bits_.data() + question * words_; }

  /// The first test of mesh k (see BroadPhaseTest).
  void broad_phase(const Particles<R>& particles, int k, float reach, unsigned long long* bits, bool add) {
    const MovingSurface& mesh = meshes_[k];
    const NearMemory<Executor, R>& memory = obstacles_[k].memory;
    const SurfaceView& surface = mesh.surface->view();
    const FloatBox box{rounded<float>(surface.centre), rounded<float>(surface.half)};
    words(particles.count > kParticleGrain || memory.slots() > kLooks,
          BroadPhaseTest<R>{particles, memory.view(), FloatPose(mesh.before), FloatPose(mesh.after), box, reach, add,
                            bits});
  }
  /// Reserves contact slots at meshes first .. last - 1 for all particles that passed the broad phase: of the one mask,
  /// or of those up to the mesh's own. Returns how many particles and groups passed.
  ActiveCount reserve_slots(int first, int last, const ActiveMask& questions) {
    const auto counting = [&](int k) {
      return CountTested<R>{{questions.bits, std::min(k + 1, questions.count), words_}, obstacles_[k].memory.view()};
    };
    std::vector<BroadPhaseCounts> tested;
    if constexpr (kOnHost) {
      for (int k = first; k < last; ++k)
        tested.push_back(parallel_reduce<BroadPhaseCounts>(executor_, words_, counting(k)));
    } else {
      for (int k = first; k < last; ++k) parallel_reduce_into(executor_, words_, counting(k), tested_.data() + k);
      tested = tested_.download();
    }
    ActiveCount asked;
    for (int k = first; k < last; ++k) {
      const BroadPhaseCounts& at = tested[k - first];
      obstacles_[k].memory.reserve_slots(executor_, at.without_slot, at.slots, at.without_places, at.places);
      nearby_[k] = obstacles_[k].memory.view();
      asked = {at.words, questions.count > 1 ? asked.particles + at.all : at.all};
    }
    return asked;
  }

  /// A kernel over the words of bits.
  template <class Kernel>
  void words(bool wide, const Kernel& kernel) {
    if (!wide) return parallel_groups(single_threaded(executor_), 0, words_, {}, kernel);
    parallel_region(executor_, words_, [&](const auto& team) { parallel_groups(team, 0, words_, {}, kernel); });
  }
  /// The same, of words that may have many looks or none.
  template <class Kernel>
  void deal_words(int looks, const Kernel& kernel) {
    if (looks <= kLooks) return parallel_for_interleaved(single_threaded(executor_), words_, kernel);
    parallel_region(executor_, words_, [&](const auto& team) { parallel_for_interleaved(team, words_, kernel); });
  }

  /// Puts particles that cross meshes, so many of the first question, before them by a kernel. Those that nothing holds
  /// back are few: on the host they alone get slots, at all meshes.
  template <class Kernel>
  void hold_crossing(const ActiveCount& asked, const Particles<R>& particles) {
    if constexpr (kOnHost) {
      deal_words(asked.particles, Kernel{surroundings(particles), bits(0), bits(1)});
      const ActiveCount pressed = asked.particles > 0 ? count_asked(1) : ActiveCount{};
      if (pressed.particles == 0) return;
      reserve_slots(0, count(), {bits(1), 1, words_});
      deal_words(pressed.particles, NotePressed<R>{surroundings(particles), bits(1), nullptr});
    } else if (asked.particles > 0) {
      Memory<Executor>::fill(bits(1), static_cast<std::size_t>(words_), 0ull);
      const auto look = [&](const auto& all, const auto& cargo) {
        parallel_for_interleaved(executor_, cargo.words, Kernel{all, cargo.bits(0), cargo.bits(1)});
        const unsigned long long* const pressed = cargo.bits(1);
        if (std::any_of(pressed, pressed + cargo.words, [](auto word) { return word != 0; }))
          parallel_for_interleaved(executor_, cargo.words, NotePressed<R>{all, pressed, nullptr});
      };
      host_words_.ask(surroundings(particles), {bits(0), 2, words_}, asked, look, [](const ActiveMask&) {});
    }
  }

  /// Launches an Embree kernel on the particles set in the mask.
  template <class Kernel>
  void on_words(const ActiveCount& asked, const Particles<R>& particles) {
    const EnvironmentView<R> here = surroundings(particles);
    if constexpr (kOnHost)
      deal_words(asked.particles, Kernel{here, bits(0)});
    else if (asked.particles > 0)
      host_words_.ask(
          here, {bits(0), 1, words_}, asked,
          [&](const auto& all, const auto& cargo) {
            parallel_for_interleaved(executor_, cargo.words, Kernel{all, cargo.bits(0)});
          },
          [](const ActiveMask&) {});
  }

  Executor executor_;
  HostWords<Executor, R> host_words_;
  Array<Executor, BroadPhaseCounts> tested_;  // of each mesh, on a device
  Device device_;
  std::deque<Obstacle> obstacles_;
  std::vector<MovingSurface> meshes_;         // of the present substep
  std::vector<ContactCacheView<R>> nearby_;   // to each of them
  Array<Executor, unsigned long long> bits_;  // of the particles; on a device of each mesh, and what lists ask beside
  Array<Executor, Clearance> rooms_;
  PointArray<Executor, R> before_;  // where particles are to go, before meshes carry them
  ContactStats facts_;
  std::size_t particles_;
  int words_;
  bool bounces_ = false;
};

}  // namespace malha
