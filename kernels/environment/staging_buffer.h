// SPDX-License-Identifier: Apache-2.0
// Words of particles that the host has to look at, with all that is known of them at every mesh, as one piece of memory
// that goes from a device to the host and back. On both it is read by the same views.
#pragma once
#include "kernels/environment/broad_phase.h"

namespace malha {

/// Where it all lies from `base` on, which is aligned as kAligned says. Particles have other numbers there: word by
/// word, in the order in which the words were taken. Slots are those of the particles that are asked about, `room` for
/// each mesh: twice as many, as what they have and what they get.
template <class R>
struct StagingBuffer {
  static constexpr size_t kAligned = 128;
  char* base;
  int words, meshes, questions, room;  // questions: arrays of bits

  KERNEL int count() const { return words * kGroupSize; }
  /// Its number outside, and whether it is asked about.
  KERNEL int particle(int j) const { return which()[j / kGroupSize] * kGroupSize + j % kGroupSize; }
  KERNEL bool asked(int j) const {
    return ActiveMask{bits(0), questions, words}.asked(j / kGroupSize) >> j % kGroupSize & 1;
  }
  KERNEL unsigned long long* bits(int question) const { return at<unsigned long long>(kBits) + question * words; }
  KERNEL int* which() const { return at<int>(kWhich); }
  KERNEL int* chosen() const { return which() + words; }  // how many of them there are
  /// Without v.
  KERNEL Particles<R> particles() const {
    R* const x = at<R>(kParticles);
    const size_t n = size_t(count());
    const Points<R> from{x, x + n, x + 2 * n}, way{x + 3 * n, x + 4 * n, x + 5 * n};
    return {count(), from, {}, {from, way, {x + 6 * n, x + 7 * n, x + 8 * n}}, w()};
  }
  KERNEL R* w() const { return at<R>(kParticles) + size_t(9) * count(); }
  KERNEL ContactCacheView<R> nearby(int mesh) const {
    char* const own = base + begin(kMeshes) + size_t(mesh) * mesh_bytes();
    const size_t n = size_t(words), slots = size_t(room) * (sizeof(Contact<R>) + sizeof(ProximityRecord));
    WordPlaces* const places = reinterpret_cast<WordPlaces*>(own + slots);
    WordBox* const boxes = reinterpret_cast<WordBox*>(places + n);
    int* const which = reinterpret_cast<int*>(boxes + n);
    Handed* const handed = reinterpret_cast<Handed*>(which + n);
    return {boxes,
            which,
            places,
            reinterpret_cast<Contact<R>*>(own),
            reinterpret_cast<ProximityRecord*>(own + size_t(room) * sizeof(Contact<R>)),
            handed,
            handed + 1};
  }
  KERNEL size_t bytes() const { return begin(kMeshes) + size_t(meshes) * mesh_bytes(); }

 private:
  enum Part { kBits, kWhich, kParticles, kMeshes };
  KERNEL static size_t aligned(size_t bytes) { return (bytes + kAligned - 1) / kAligned * kAligned; }
  KERNEL size_t begin(Part part) const {
    const size_t n = size_t(words);
    size_t at = 0;
    if (part > kBits) at += aligned(size_t(questions) * n * sizeof(unsigned long long));
    if (part > kWhich) at += aligned((n + 1) * sizeof(int));
    if (part > kParticles) at += aligned(10 * n * kGroupSize * sizeof(R));
    return at;
  }
  template <class T>
  KERNEL T* at(Part part) const {
    return reinterpret_cast<T*>(base + begin(part));
  }
  KERNEL size_t mesh_bytes() const {
    const size_t n = size_t(words);
    return aligned(size_t(room) * (sizeof(Contact<R>) + sizeof(ProximityRecord)) +
                   n * (sizeof(WordPlaces) + sizeof(WordBox) + sizeof(int)) + 2 * sizeof(Handed));
  }
};

/// Number of active groups, and of active particles.
struct ActiveCount {
  int words = 0, particles = 0;
  KERNEL ActiveCount& operator+=(const ActiveCount& o) {
    words += o.words, particles += o.particles;
    return *this;
  }
};
struct CountActive {
  ActiveMask questions;
  KERNEL ActiveCount operator()(int word) const {
    ActiveCount sum;
    for (unsigned long long rest = questions.asked(word); rest != 0; rest &= rest - 1) ++sum.particles;
    sum.words = sum.particles > 0;
    return sum;
  }
};

/// Which words those are, in any order.
struct ChooseWords {
  ActiveMask questions;
  int *chosen, *which;
  KERNEL void operator()(int word) const {
    if (questions.asked(word) != 0) which[atomic_increment(chosen)] = word;
  }
};

/// Into it, particle by particle of its words: what is asked, and where they are.
template <class R>
struct PackParticles {
  ActiveMask questions;
  Particles<R> particles;
  StagingBuffer<R> to;
  KERNEL void operator()(int j) const {
    const int w = j / kGroupSize, word = to.which()[w], bit = j % kGroupSize, i = to.particle(j);
    for (int q = 0; bit == 0 && q < questions.count; ++q) to.bits(q)[w] = questions.of(q, word);
    if (!(questions.asked(word) >> bit & 1)) return;
    const Particles<R> own = to.particles();
    own.x.set(j, particles.x[i]), own.p.d.set(j, particles.p.d[i]);
    if constexpr (kCompensated<R>) own.p.low.set(j, particles.p.low[i]);
    to.w()[j] = particles.w[i];
  }
};

/// And what is known of them at a mesh. Its numbers of slots are 0 before. There every word has places.
template <class R>
struct LoadNearby {
  ActiveMask questions;
  Particles<R> particles;
  Pose pose;  // of the mesh, before the substep
  ContactCacheView<R> from;
  StagingBuffer<R> cargo;
  int mesh;
  KERNEL void operator()(int j) const {
    const int w = j / kGroupSize, word = cargo.which()[w], bit = j % kGroupSize, i = cargo.particle(j);
    const ContactCacheView<R> to = cargo.nearby(mesh);
    if (bit == 0) to.boxes[w] = from.boxes[word], to.which[w] = w;
    if (!(questions.asked(word) >> bit & 1)) return;
    WordPlaces& places = to.places[w];
    const int own = from.slot(i);
    places.set(bit, from.place(i, place_in(pose, particles.x[i]))), places.slot[bit] = -1;
    if (own < 0) return;
    const int s = places.slot[bit] = atomic_increment(&to.slots->used);
    to.contacts[s] = from.contacts[own], to.near[s] = from.near[own];
    to.contacts[s].particle = j;
  }
};

/// And back.
template <class R>
struct UnpackParticles {
  Particles<R> particles;
  StagingBuffer<R> from;
  KERNEL void operator()(int j) const {
    if (!from.asked(j)) return;
    const Particles<R> own = from.particles();
    particles.x.set(from.particle(j), own.x[j]), particles.p.d.set(from.particle(j), own.p.d[j]);
  }
};

/// Words of which something was seen get places.
template <class R>
struct UnloadPlaces {
  Particles<R> particles;
  Pose pose;  // of the mesh, before the substep
  ContactCacheView<R> to;
  StagingBuffer<R> cargo;
  int mesh;
  KERNEL void operator()(int w) const {
    if (cargo.nearby(mesh).boxes[w].is_of_each()) to.give_places(cargo.which()[w], particles, pose);
  }
};

/// Slots are freed or filled as a look on the device would.
template <class R>
struct UnloadNearby {
  ContactCacheView<R> to;
  StagingBuffer<R> cargo;
  int mesh;
  KERNEL void operator()(int j) const {
    const ContactCacheView<R> from = cargo.nearby(mesh);
    const int w = j / kGroupSize, word = cargo.which()[w], bit = j % kGroupSize;
    if (bit == 0) to.boxes[word] = from.boxes[w];
    if (!cargo.asked(j) || to.which[word] < 0) return;
    const int i = cargo.particle(j), own = from.places[w].slot[bit];
    WordPlaces& places = to.places[to.which[word]];
    places.set(bit, from.places[w].of(bit));
    int& s = places.slot[bit];
    if (own < 0) {
      if (s >= 0) to.contacts[s].particle = -1, s = -1, atomic_increment(&to.slots->freed);
      return;
    }
    if (s < 0) s = atomic_increment(&to.slots->used);
    to.contacts[s] = from.contacts[own], to.near[s] = from.near[own];
    to.contacts[s].particle = i;
  }
};

}  // namespace malha
