// The state of a run as bytes: what a checkpoint holds, and its hash.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "host/base/hash.h"
#include "host/base/text.h"
#include "host/collision/edge_memory.h"
#include "host/collision/find_contact.h"
#include "host/collision/self_memory.h"
#include "host/error.h"
#include "host/mesh.h"
#include "host/model/solver_of.h"

namespace malha {

/// In the solver's order.
template <class R>
struct State {
  std::int64_t steps = 0;
  std::vector<std::array<R, 3>> x, v;
  std::vector<LastSeen> seen{};      // empty without environment
  std::vector<std::int64_t> rest{};  // of sleep, empty without
  SelfMemory<R> self{};              // empty where no edges meet edges
  EdgeMemory<R> edges{};             // empty without edges of the environment
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
  detail::append(bytes, state.self.x0);
  detail::append(bytes, state.self.from);
  detail::append(bytes, state.self.way);
  detail::append(bytes, state.self.contact_distance);
  detail::append(bytes, state.self.search);
  detail::append(bytes, state.edges.from);
  detail::append(bytes, state.edges.way);
  detail::append(bytes, state.edges.contact_distance);
  detail::append(bytes, state.edges.serves);
  return bytes;
}

/// How many entries a state has of each.
struct StateSizes {
  std::size_t particles = 0, seen = 0, rest = 0, apart = 0, searched = 0, edge_groups = 0;
};

namespace detail {

inline bool finite(const Point& a) { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); }

inline void check_search(const SearchMemory& search, const std::string& file) {
  for (const auto& frame : {search.since, search.moves})
    for (const double number : frame)
      if (!(std::abs(number) <= 1e18)) refuse(file, "frame of a search", shown(number), "numbers up to 1e18");
  const auto check = [&](const char* what, std::int32_t count, int least, int most) {
    if (count < least || count > most)
      refuse(file, what, std::to_string(count), std::to_string(least) + " to " + std::to_string(most));
  };
  constexpr int most = SearchMemory::kMostAhead;
  check("search that serves", search.serves, 0, 1), check("bodies that cross", search.crosses, 0, 1);
  check("substeps ahead of a search", search.ahead, 1, most);
  check("substeps of a search", search.served, 1, std::numeric_limits<int>::max());
  if (search.driven_through < 0)
    refuse(file, "substeps driven through", std::to_string(search.driven_through), "at least 0");
}

/// Refuses what no run can have left: a solver would read beyond its arrays with it, or never end.
template <class R>
void check_state(const State<R>& state, const std::vector<int>& triangles, const std::string& file) {
  constexpr std::int64_t most = std::int64_t{1} << 53;  // of which a double still tells the next
  if (state.steps < 0 || state.steps > most)
    refuse(file, "steps", std::to_string(state.steps), "0 to " + std::to_string(most));
  // Self-collision lays a grid over everything: squares of what it is to hold must stay finite in single precision.
  const double largest = state.self.x0.empty() ? std::numeric_limits<double>::max() : 1e18;
  const auto check_numbers = [&](const auto& list, const char* place) {
    for (std::size_t i = 0; i < list.size(); ++i)
      for (const R number : list[i])
        if (!(std::abs(double(number)) <= largest))
          refuse(file, place, shown(double(number)) + " at particle " + std::to_string(i),
                 state.self.x0.empty() ? "finite numbers" : "numbers up to 1e18");
  };
  check_numbers(state.x, "positions"), check_numbers(state.v, "velocities");
  check_numbers(state.self.x0, "parted positions");
  check_numbers(state.self.from, "positions of a search"), check_numbers(state.self.way, "ways of a search");
  for (const auto& a : state.self.from)
    if (a[3] < 0) refuse(file, "reach of a search", shown(double(a[3])), "at least 0");
  for (const auto* list : {&state.self.contact_distance, &state.edges.contact_distance})
    for (const R distance : *list)
      if (!(distance >= 0 && double(distance) <= largest))
        refuse(file, "contact distance", shown(double(distance)), "at least 0");
  for (const SearchMemory& search : state.self.search) check_search(search, file);
  check_numbers(state.edges.from, "positions of a search of edges");
  check_numbers(state.edges.way, "ways of a search of edges");
  for (const std::int64_t serves : state.edges.serves)
    if (serves < 0 || serves > 1) refuse(file, "search of edges that serves", std::to_string(serves), "0 or 1");
  if (!state.rest.empty()) {
    const std::int64_t calm = state.rest[0], since = state.rest[1];
    if (calm < 0 || calm > state.steps || since < -1 || since > state.steps)
      refuse(file, "sleep", std::to_string(calm) + " calm steps and sleep since step " + std::to_string(since),
             "at most the " + std::to_string(state.steps) + " steps that were done");
  }
  for (std::size_t i = 0; i < state.seen.size(); ++i) {
    const LastSeen& seen = state.seen[i];
    const int count = triangles.empty() ? std::numeric_limits<int>::max() : triangles.at(i / state.x.size());
    if (seen.triangle < -1 || seen.triangle >= count)
      refuse(file, "contacts", "triangle " + std::to_string(seen.triangle), "-1 to " + std::to_string(count - 1));
    if (!finite(seen.at) || !finite(seen.passed) || std::isnan(seen.distance) ||
        !(seen.overlap >= 0 && std::isfinite(seen.overlap)))
      refuse(file, "contacts", "places that are no numbers", "finite numbers");
  }
}

}  // namespace detail

/// Throws InputError unless the bytes hold as much as `sizes` say, in precision R, and all of it can be gone on with.
/// `triangles`: of each environment mesh; without it contacts are taken as they are. `file`: what the message names.
template <class R>
State<R> load_state(const std::string& bytes, const StateSizes& sizes, const std::vector<int>& triangles = {},
                    const std::string& file = "checkpoint") {
  State<R> state;
  const std::size_t searches = sizes.searched > 0 ? 1 : 0;
  const std::size_t expected =
      sizeof state.steps + (6 * sizes.particles + 3 * sizes.apart + 8 * sizes.searched) * sizeof(R) +
      sizes.seen * sizeof(LastSeen) + sizes.rest * sizeof(std::int64_t) + searches * sizeof(SearchMemory) +
      sizes.edge_groups * (7 * sizes.particles * sizeof(R) + sizeof(std::int64_t));
  if (bytes.size() != expected)
    refuse(file, "state", std::to_string(bytes.size()) + " bytes",
           std::to_string(expected) + " bytes for this scene's particles and precision");
  std::memcpy(&state.steps, bytes.data(), sizeof state.steps);
  const char* from = bytes.data() + sizeof state.steps;
  from = detail::take(from, sizes.particles, state.x);
  from = detail::take(from, sizes.particles, state.v);
  from = detail::take(from, sizes.seen, state.seen);
  from = detail::take(from, sizes.rest, state.rest);
  from = detail::take(from, sizes.apart, state.self.x0);
  from = detail::take(from, sizes.searched, state.self.from);
  from = detail::take(from, sizes.searched, state.self.way);
  from = detail::take(from, sizes.searched, state.self.contact_distance);
  from = detail::take(from, searches, state.self.search);
  from = detail::take(from, sizes.edge_groups * sizes.particles, state.edges.from);
  from = detail::take(from, sizes.edge_groups * sizes.particles, state.edges.way);
  from = detail::take(from, sizes.edge_groups * sizes.particles, state.edges.contact_distance);
  detail::take(from, sizes.edge_groups, state.edges.serves);
  detail::check_state(state, triangles, file);
  return state;
}

/// The state of other particles: the i-th is as the from[i]-th was.
template <class R>
State<R> carried(const State<R>& before, const std::vector<int>& from) {
  State<R> state{before.steps, {}, {}, {}, before.rest, {}, {}};
  for (const int i : from) {
    state.x.push_back(before.x[i]), state.v.push_back(before.v[i]);
    if (!before.self.x0.empty()) state.self.x0.push_back(before.self.x0[i]);  // a split leaves all in its place
  }
  if (!before.self.search.empty()) state.self = unsearched(std::move(state.self.x0), before.self.search[0]);
  state.edges = unsearched_edges<R>(before.edges.serves.size(), from.size());
  for (std::size_t mesh = 0; mesh < before.seen.size(); mesh += before.x.size())
    for (const int i : from) state.seen.push_back(before.seen[mesh + i]);
  return state;
}

/// The same particles elsewhere, after so many steps, awake: nothing has been seen or searched there. What stays where
/// it is keeps its contact distance.
template <class R>
State<R> displaced(const State<R>& before, std::int64_t steps, const std::vector<Vec3>& x, const std::vector<Vec3>& v) {
  State<R> state{steps, {}, {}, {}, {}, {}, {}};
  const auto to_R = [](const Vec3& a) { return std::array<R, 3>{R(a[0]), R(a[1]), R(a[2])}; };
  for (std::size_t i = 0; i < x.size(); ++i) state.x.push_back(to_R(x[i])), state.v.push_back(to_R(v[i]));
  state.seen.resize(before.seen.size());
  if (!before.rest.empty()) state.rest = {0, -1};
  if (!before.self.x0.empty()) state.self.x0 = state.x;
  if (!before.self.search.empty()) state.self = unsearched(std::move(state.self.x0), before.self.search[0]);
  state.edges = unsearched_edges<R>(before.edges.serves.size(), x.size());
  const auto keep = [&](const std::vector<R>& from, std::vector<R>& to) {
    for (std::size_t i = 0; i < to.size(); ++i)
      if (state.x[i % x.size()] == before.x[i % x.size()]) to[i] = from[i];
  };
  keep(before.self.contact_distance, state.self.contact_distance);
  keep(before.edges.contact_distance, state.edges.contact_distance);
  return state;
}

/// Of positions and velocities, bit by bit, particle by particle in the user's order.
template <class R>
std::uint64_t hash_state(const State<R>& state, const std::vector<int>& user_of) {
  std::uint64_t hash = hash_bytes(nullptr, 0);
  for (const int i : solver_of(user_of)) {
    hash = hash_bytes(&state.x[i], sizeof state.x[i], hash);
    hash = hash_bytes(&state.v[i], sizeof state.v[i], hash);
  }
  return hash;
}

}  // namespace malha
