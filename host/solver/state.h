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
  std::vector<LastSeen> seen{};           // empty without environment
  std::vector<std::int64_t> rest{};       // of sleep, empty without
  std::vector<std::array<R, 3>> apart{};  // positions without crossings; empty without self-collision
};

/// Of the first step, at rest at these places (m).
template <class R>
State<R> state_at_rest(const std::vector<Vec3>& places) {
  State<R> state;
  for (const Vec3& x : places) state.x.push_back({R(x[0]), R(x[1]), R(x[2])}), state.v.push_back({0, 0, 0});
  return state;
}

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
  detail::append(bytes, state.rest);
  detail::append(bytes, state.apart);
  return bytes;
}

/// How many entries a state has of each.
struct StateSizes {
  std::size_t particles = 0, seen = 0, rest = 0, apart = 0;
};

/// Throws InputError unless the bytes hold as much as `sizes` say, in precision R.
template <class R>
State<R> load_state(const std::string& bytes, const StateSizes& sizes) {
  State<R> state;
  const std::size_t expected = sizeof state.steps + (6 * sizes.particles + 3 * sizes.apart) * sizeof(R) +
                               sizes.seen * sizeof(LastSeen) + sizes.rest * sizeof(std::int64_t);
  if (bytes.size() != expected)
    refuse("checkpoint", "state", std::to_string(bytes.size()) + " bytes",
           std::to_string(expected) + " bytes for this scene's particles and precision");
  std::memcpy(&state.steps, bytes.data(), sizeof state.steps);
  const char* from = bytes.data() + sizeof state.steps;
  from = detail::take(from, sizes.particles, state.x);
  from = detail::take(from, sizes.particles, state.v);
  from = detail::take(from, sizes.seen, state.seen);
  from = detail::take(from, sizes.rest, state.rest);
  detail::take(from, sizes.apart, state.apart);
  return state;
}

/// The state of other particles: the i-th is as the from[i]-th was.
template <class R>
State<R> carried(const State<R>& before, const std::vector<int>& from) {
  State<R> state{before.steps, {}, {}, {}, before.rest, {}};
  for (const int i : from) state.x.push_back(before.x[i]), state.v.push_back(before.v[i]);
  for (std::size_t mesh = 0; mesh < before.seen.size(); mesh += before.x.size())
    for (const int i : from) state.seen.push_back(before.seen[mesh + i]);
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
