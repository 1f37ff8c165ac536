// Words of particles that the host has to look at, with all that is known of them at every mesh, as one piece of memory
// that goes from a device to the host and back. On both it is read by the same views.
#pragma once
#include "kernels/nearby.h"

namespace malha {

/// Where it all lies from `base` on, which is aligned as kAligned says. Particles have other numbers there: word by
/// word, in the order in which the words were taken. Slots are those of the particles that are asked about, `room` for
/// each mesh: twice as many, as what they have and what they get.
template <class R>
struct WordCargo {
  static constexpr size_t kAligned = 128;
  char* base;
  int words, meshes, questions, room;  // questions: arrays of bits

  KERNEL int count() const { return words * kWord; }
  /// Its number outside, and whether it is asked about.
  KERNEL int particle(int j) const { return which()[j / kWord] * kWord + j % kWord; }
  KERNEL bool asked(int j) const { return Questions{bits(0), questions, words}.asked(j / kWord) >> j % kWord & 1; }
  KERNEL unsigned long long* bits(int question) const { return at<unsigned long long>(kBits) + question * words; }
  KERNEL int* which() const { return at<int>(kWhich); }
  KERNEL int* chosen() const { return which() + words; }  // how many of them there are
  /// Without v.
  KERNEL Particles<R> particles() const {
    R* const x = at<R>(kParticles);
    const size_t n = size_t(count());
    return {count(), {x, x + n, x + 2 * n}, {}, {x + 3 * n, x + 4 * n, x + 5 * n}, w()};
  }
  KERNEL R* w() const { return at<R>(kParticles) + size_t(6) * count(); }
  KERNEL Nearby<R> nearby(int mesh) const {
    char* const own = base + begin(kMeshes) + size_t(mesh) * mesh_bytes();
    const size_t n = size_t(count()), slots = size_t(room) * (sizeof(Contact<R>) + sizeof(Near));
    float* const seen = reinterpret_cast<float*>(own + slots);
    int* const slot = reinterpret_cast<int*>(seen + 4 * n);
    WordBall* const balls = reinterpret_cast<WordBall*>(slot + n);
    int* const counts = reinterpret_cast<int*>(balls + words);
    return {{seen, seen + n, seen + 2 * n},
            balls,
            seen + 3 * n,
            slot,
            reinterpret_cast<Contact<R>*>(own),
            reinterpret_cast<Near*>(own + size_t(room) * sizeof(Contact<R>)),
            counts,
            counts + 1};
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
    if (part > kParticles) at += aligned(7 * n * kWord * sizeof(R));
    return at;
  }
  template <class T>
  KERNEL T* at(Part part) const {
    return reinterpret_cast<T*>(base + begin(part));
  }
  KERNEL size_t mesh_bytes() const {
    const size_t n = size_t(words);
    return aligned(size_t(room) * (sizeof(Contact<R>) + sizeof(Near)) + n * kWord * (4 * sizeof(float) + sizeof(int)) +
                   n * sizeof(WordBall) + 2 * sizeof(int));
  }
};

/// How many words have one that is asked about, and how many those are.
struct Asked {
  int words = 0, particles = 0;
  KERNEL Asked& operator+=(const Asked& o) {
    words += o.words, particles += o.particles;
    return *this;
  }
};
struct CountAsked {
  Questions questions;
  KERNEL Asked operator()(int word) const {
    Asked sum;
    for (unsigned long long rest = questions.asked(word); rest != 0; rest &= rest - 1) ++sum.particles;
    sum.words = sum.particles > 0;
    return sum;
  }
};

/// Which words those are, in any order.
struct ChooseWords {
  Questions questions;
  int *chosen, *which;
  KERNEL void operator()(int word) const {
    if (questions.asked(word) != 0) which[count_up(chosen)] = word;
  }
};

/// Into it, particle by particle of its words: what is asked, and where they are.
template <class R>
struct LoadWords {
  Questions questions;
  Particles<R> particles;
  WordCargo<R> to;
  KERNEL void operator()(int j) const {
    const int w = j / kWord, word = to.which()[w], bit = j % kWord, i = to.particle(j);
    for (int q = 0; bit == 0 && q < questions.count; ++q) to.bits(q)[w] = questions.of(q, word);
    if (!(questions.asked(word) >> bit & 1)) return;
    const Particles<R> own = to.particles();
    own.x.set(j, particles.x[i]), own.p.set(j, particles.p[i]);
    to.w()[j] = particles.w[i];
  }
};

/// And what is known of them at a mesh. Its numbers of slots are 0 before.
template <class R>
struct LoadNearby {
  Questions questions;
  Nearby<R> from;
  WordCargo<R> cargo;
  int mesh;
  KERNEL void operator()(int j) const {
    const int w = j / kWord, word = cargo.which()[w], bit = j % kWord, i = cargo.particle(j);
    const Nearby<R> to = cargo.nearby(mesh);
    if (bit == 0) to.balls[w] = from.balls[word];
    if (!(questions.asked(word) >> bit & 1)) return;
    to.at.set(j, from.at[i]), to.distance[j] = from.distance[i], to.slot[j] = -1;
    if (from.slot[i] < 0) return;
    const int s = to.slot[j] = count_up(to.used);
    to.contacts[s] = from.contacts[from.slot[i]], to.near[s] = from.near[from.slot[i]];
    to.contacts[s].particle = j;
  }
};

/// And back.
template <class R>
struct UnloadWords {
  Particles<R> particles;
  WordCargo<R> from;
  KERNEL void operator()(int j) const {
    if (!from.asked(j)) return;
    const Particles<R> own = from.particles();
    particles.x.set(from.particle(j), own.x[j]), particles.p.set(from.particle(j), own.p[j]);
  }
};

/// Slots are freed or filled as a look on the device would.
template <class R>
struct UnloadNearby {
  Nearby<R> to;
  WordCargo<R> cargo;
  int mesh;
  KERNEL void operator()(int j) const {
    const Nearby<R> from = cargo.nearby(mesh);
    if (j % kWord == 0) to.balls[cargo.which()[j / kWord]] = from.balls[j / kWord];
    if (!cargo.asked(j)) return;
    const int i = cargo.particle(j), own = from.slot[j];
    to.at.set(i, from.at[j]), to.distance[i] = from.distance[j];
    int& s = to.slot[i];
    if (own < 0) {
      if (s >= 0) to.contacts[s].particle = -1, s = -1, count_up(to.freed);
      return;
    }
    if (s < 0) s = count_up(to.used);
    to.contacts[s] = from.contacts[own], to.near[s] = from.near[own];
    to.contacts[s].particle = i;
  }
};

}  // namespace malha
