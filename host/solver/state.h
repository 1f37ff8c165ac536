// The state of a run as bytes: what a checkpoint holds, and its hash.
#pragma once
#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "host/base/hash.h"
#include "host/collision/find_contact.h"
#include "host/error.h"
#include "host/mesh.h"

namespace malha {

/// In the solver's order.
template <class R>
struct State {
  std::int64_t steps = 0;
  std::vector<std::array<R, 3>> x, v;
  std::vector<LastSeen> seen;           // empty without environment
  std::vector<std::array<R, 3>> apart;  // positions without crossings; empty without self-collision
};

namespace detail {

template <class T>
void append(std::string& bytes, const std::vector<T>& values) {
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

template <class T>
const char* take(const char* from, std::size_t count, std::vector<T>& values) {
  values.resize(count);
  if (count > 0) std::memcpy(values.data(), from, count * sizeof(T));  // an empty vector may have no data at all
  return from + count * sizeof(T);
}

}  // namespace detail

template <class R>
std::string save_state(const State<R>& state) {
  std::string bytes(reinterpret_cast<const char*>(&state.steps), sizeof state.steps);
  detail::append(bytes, state.x);
  detail::append(bytes, state.v);
  detail::append(bytes, state.seen);
  detail::append(bytes, state.apart);
  return bytes;
}

/// Throws InputError unless the bytes hold `particles` particles and `seen` remembered contacts in precision R, and
/// `self_collision` says whether positions without crossings.
template <class R>
State<R> load_state(const std::string& bytes, std::size_t particles, std::size_t seen, bool self_collision = false) {
  State<R> state;
  const std::size_t expected =
      sizeof state.steps + (self_collision ? 9 : 6) * particles * sizeof(R) + seen * sizeof(LastSeen);
  if (bytes.size() != expected)
    refuse("checkpoint", "state", std::to_string(bytes.size()) + " bytes",
           std::to_string(expected) + " bytes for this scene's particles and precision");
  std::memcpy(&state.steps, bytes.data(), sizeof state.steps);
  const char* from = bytes.data() + sizeof state.steps;
  from = detail::take(from, particles, state.x);
  from = detail::take(from, particles, state.v);
  from = detail::take(from, seen, state.seen);
  detail::take(from, self_collision ? particles : 0, state.apart);
  return state;
}

/// Of positions and velocities, bit by bit, particle by particle in the user's order.
template <class R>
std::uint64_t hash_state(const State<R>& state, const std::vector<int>& user_of) {
  std::vector<int> at(user_of.size());
  for (std::size_t i = 0; i < at.size(); ++i) at[user_of[i]] = static_cast<int>(i);
  std::uint64_t hash = hash_bytes(nullptr, 0);
  for (int i : at) {
    hash = hash_bytes(&state.x[i], sizeof state.x[i], hash);
    hash = hash_bytes(&state.v[i], sizeof state.v[i], hash);
  }
  return hash;
}

inline std::vector<Vec3> in_user_order(const std::vector<Vec3>& values, const std::vector<int>& user_of) {
  std::vector<Vec3> ordered(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) ordered[user_of[i]] = values[i];
  return ordered;
}

}  // namespace malha
