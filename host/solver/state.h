// SPDX-License-Identifier: Apache-2.0
// State of a run, its serialisation for checkpoints, and its hash.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "host/base/check_numbers.h"
#include "host/base/hash.h"
#include "host/environment/edge_memory.h"
#include "host/environment/proximity_memory.h"
#include "host/environment/shape_memory.h"
#include "host/model/ordering/index_map.h"
#include "host/self_collision/self_memory.h"
#include "kernels/simd/particles.h"
#include "malha/error.h"
#include "malha/mesh.h"
#include "malha/text.h"

namespace malha {

/// State of a run, by particle in the solver's order.
template <class R>
struct State {
  std::int64_t steps = 0;
  std::vector<std::array<R, 3>> x, v;
  ProximityMemory proximity{};          // empty without environment meshes
  std::vector<std::int64_t> rest{};     // of sleep; empty without it
  SelfMemory<R> self{};                 // empty without self-collision
  EdgeMemory<R> edges{};                // empty without edges of the environment
  std::vector<float> overlaps{};        // that particles may keep at deforming meshes, m; empty without those
  std::vector<std::array<R, 3>> low{};  // positions less x, of compensated types
  std::optional<ShapeMemory> shapes{};  // none without exact shapes
};

/// Sets x and low of a state from positions (m).
template <class R>
void set_positions(const std::vector<Vec3>& places, State<R>& state) {
  for (const Vec3& place : places) {
    std::array<R, 3> x, low;
    for (int k = 0; k < 3; ++k) x[k] = R(place[k]), low[k] = R(place[k] - double(x[k]));
    state.x.push_back(x);
    if constexpr (kCompensated<R>) state.low.push_back(low);
  }
}

/// State before the first step, at rest at these positions (m).
template <class R>
State<R> state_at_rest(const std::vector<Vec3>& places) {
  State<R> state;
  set_positions(places, state);
  state.v.assign(places.size(), {0, 0, 0});
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

/// Serialises a state. `contacts`: used in place of state.proximity, with the same interface.
template <class R, class Contacts>
std::string save_state(const State<R>& state, const Contacts& contacts) {
  std::string bytes;
  const auto of_all = [&](const auto& take) {
    take(state.rest), take(state.overlaps), SelfMemory<R>::for_each_list(state.self, take),
        EdgeMemory<R>::for_each_list(state.edges, take);
  };
  std::size_t most = 3 * sizeof state.steps + (2 * state.x.size() + state.low.size()) * sizeof state.x[0];
  most += contacts.box_count() * sizeof(GroupBox) + contacts.max_entries() * sizeof(CacheEntry) +
          contacts.near_count() * sizeof(PairRecord);
  if (state.shapes) most += sizeof(std::int64_t[2]) + state.shapes->overlaps.size() * sizeof(OverlapRecord);
  of_all([&](const auto& values) { most += values.size() * sizeof values[0]; });
  bytes.reserve(most);
  const auto append = [&](const auto& values) { detail::append(bytes, values); };
  append(std::vector<std::int64_t>{state.steps}), append(state.x), append(state.v);
  append(state.low);
  append(std::vector<std::int64_t>{static_cast<std::int64_t>(contacts.box_count()),
                                   static_cast<std::int64_t>(contacts.near_count())});
  contacts.for_each_part(append);
  of_all(append);
  if (state.shapes) {
    append(
        std::vector<std::int64_t>{static_cast<std::int64_t>(state.shapes->update), std::ssize(state.shapes->overlaps)});
    append(state.shapes->overlaps);
  }
  return bytes;
}
template <class R>
std::string save_state(const State<R>& state) {
  return save_state(state, state.proximity);
}

/// Sizes of a state; `meshes`, `shapes`, `deforming`: numbers of environment meshes that are rigid, of exact shapes,
/// and of meshes that deform.
struct StateSizes {
  std::size_t particles = 0, meshes = 0, shapes = 0, deforming = 0, rest = 0, searched = 0, edge_groups = 0;
};

namespace detail {

/// Checks contacts. `pairs`: number of pairs of particle and mesh. `triangles`: number of each mesh; empty: not
/// checked.
inline void check_contacts(const ProximityMemory& cache, std::int64_t pairs, std::int64_t particles,
                           const std::vector<int>& triangles, const std::string& file) {
  constexpr double most = std::numeric_limits<float>::max();  // places are kept in float too
  const auto require_numbers = [&](bool numbers) {
    if (!numbers) refuse(file, "contacts", "places that are no numbers", "finite numbers");
  };
  const auto is_place = [](const auto& a) {
    return std::abs(double(a.x)) <= most && std::abs(double(a.y)) <= most && std::abs(double(a.z)) <= most;
  };
  for (const GroupBox& box : cache.boxes) {
    const Vector3<float>& half = box.half;
    require_numbers(box.has_entries() || (is_place(box.centre) && is_place(half) && half.x >= 0 && half.y >= 0 &&
                                          half.z >= 0 && !std::isnan(box.distance)));
  }
  for (const CacheEntry& a : cache.entries) require_numbers(is_place(a));
  std::int64_t least = 0;
  for (const auto& [pair, last] : cache.near) {
    if (pair < least || pair >= pairs)
      refuse(file, "contacts", "pair " + std::to_string(pair),
             std::to_string(least) + " to " + std::to_string(pairs - 1));
    least = pair + 1;
    const int count =
        triangles.empty() ? std::numeric_limits<int>::max() : triangles.at(static_cast<std::size_t>(pair / particles));
    if (last.triangle < -1 || last.triangle >= count)
      refuse(file, "contacts", "triangle " + std::to_string(last.triangle), "-1 to " + std::to_string(count - 1));
    const auto is_finite = [](const Vector3<double>& a) { return std::isfinite(a.x + a.y + a.z); };
    require_numbers(is_finite(last.at) && !std::isnan(last.distance) && is_finite(last.tunnel_offset) &&
                    last.overlap >= 0 && std::isfinite(last.overlap));
  }
}

/// Throws InputError for a state that no run can have saved, with which a solver would read beyond its arrays, or never
/// end.
template <class R>
void check_state(const State<R>& state, const std::vector<int>& triangles, std::int64_t meshes,
                 const std::string& file) {
  constexpr std::int64_t most = std::int64_t{1} << 53;  // so that a double represents the next one
  if (state.steps < 0 || state.steps > most)
    refuse(file, "steps", std::to_string(state.steps), "0 to " + std::to_string(most));
  // Self-collision and edges need squares of positions that are finite in single precision.
  const double most_m =
      state.self.x0.empty() && state.edges.x0.empty() ? std::numeric_limits<double>::max() : kMostSquared;
  check_numbers(state.x, "positions", file, most_m), check_numbers(state.v, "velocities", file, most_m);
  check_numbers(state.low, "remainders of positions", file, most_m);
  check(state.self, file), check(state.edges, file);
  for (const float overlap : state.overlaps)
    if (std::isnan(overlap)) refuse(file, "overlaps", "places that are no numbers", "numbers");
  if (!state.rest.empty()) {
    const std::int64_t calm = state.rest[0], since = state.rest[1];
    if (calm < 0 || calm > state.steps || since < -1 || since > state.steps)
      refuse(file, "sleep", std::to_string(calm) + " calm steps and sleep since step " + std::to_string(since),
             "at most the " + std::to_string(state.steps) + " steps that were done");
  }
  const std::int64_t particles = std::ssize(state.x);
  check_contacts(state.proximity, meshes * particles, particles, triangles, file);
}

}  // namespace detail

/// Reads a state. Throws InputError unless the bytes have the given sizes in precision R and a valid state.
/// `triangles`: number of each environment mesh; empty: contacts are not checked. `file`: name for messages.
template <class R>
State<R> load_state(const std::string& bytes, const StateSizes& sizes, const std::vector<int>& triangles = {},
                    const std::string& file = "checkpoint") {
  State<R> state;
  const std::size_t carries = kCompensated<R> ? sizes.particles : 0;
  if (sizes.searched > 0) state.self = unsearched(std::vector<std::array<R, 3>>(sizes.searched));
  if (sizes.edge_groups > 0)
    state.edges = unsearched_edges(sizes.edge_groups, std::vector<std::array<R, 3>>(sizes.particles));
  constexpr std::size_t two = 2 * sizeof(std::int64_t);
  // Offset of the numbers of boxes and of near pairs.
  const std::size_t counts_at = sizeof state.steps + (6 * sizes.particles + 3 * carries) * sizeof(R),
                    words = groups_of(sizes.particles);
  std::int64_t counts[2] = {0, 0};
  if (bytes.size() >= counts_at + two) std::memcpy(counts, bytes.data() + counts_at, two);
  const auto boxes = static_cast<std::int64_t>(sizes.meshes * words);
  const auto pairs = static_cast<std::int64_t>(sizes.meshes * sizes.particles);
  if (counts[0] != 0 && counts[0] != boxes)
    refuse(file, "contacts", counted(counts[0], "box", "boxes"), "0 or " + std::to_string(boxes));
  if (counts[1] < 0 || counts[1] > (counts[0] == 0 ? 0 : pairs))
    refuse(file, "contacts", counted(counts[1], "pair"), "at most the " + std::to_string(pairs) + " there are");
  const auto box_count = static_cast<std::size_t>(counts[0]), near = static_cast<std::size_t>(counts[1]);
  std::size_t places = 0;
  if (const std::size_t at = counts_at + two; box_count > 0 && bytes.size() >= at + box_count * sizeof(GroupBox)) {
    detail::take(bytes.data() + at, box_count, state.proximity.boxes);
    for (std::size_t mesh = 0; mesh < sizes.meshes; ++mesh)
      places += count_entries(state.proximity.boxes.data() + mesh * words, sizes.particles);
  }
  std::size_t expected = counts_at + two + box_count * sizeof(GroupBox) + places * sizeof(CacheEntry) +
                         near * sizeof(PairRecord) + sizes.rest * sizeof(std::int64_t) +
                         sizes.deforming * sizes.particles * sizeof(float);
  const auto add = [&](const auto& list) { expected += list.size() * sizeof list[0]; };
  SelfMemory<R>::for_each_list(state.self, add), EdgeMemory<R>::for_each_list(state.edges, add);
  std::int64_t shapes[2] = {0, 0};  // the update, and the number of overlaps
  const std::size_t shapes_at = expected;
  if (sizes.shapes > 0) {
    if (bytes.size() >= shapes_at + sizeof shapes) std::memcpy(shapes, bytes.data() + shapes_at, sizeof shapes);
    const auto most = static_cast<std::int64_t>(sizes.shapes * sizes.particles);
    if (shapes[1] < 0 || shapes[1] > most)
      refuse(file, "shapes", counted(shapes[1], "overlap"), "at most the " + std::to_string(most) + " pairs there are");
    expected += sizeof shapes + static_cast<std::size_t>(shapes[1]) * sizeof(OverlapRecord);
  }
  if (bytes.size() != expected)
    refuse(file, "state", std::to_string(bytes.size()) + " bytes",
           std::to_string(expected) + " bytes for this scene's particles and precision");
  std::memcpy(&state.steps, bytes.data(), sizeof state.steps);
  const char* from = bytes.data() + sizeof state.steps;
  from = detail::take(from, sizes.particles, state.x);
  from = detail::take(from, sizes.particles, state.v);
  from = detail::take(from, carries, state.low);
  from = detail::take(from + two, box_count, state.proximity.boxes);
  from = detail::take(from, places, state.proximity.entries);
  from = detail::take(from, near, state.proximity.near);
  from = detail::take(from, sizes.rest, state.rest);
  from = detail::take(from, sizes.deforming * sizes.particles, state.overlaps);
  const auto take = [&](auto& list) { from = detail::take(from, list.size(), list); };
  SelfMemory<R>::for_each_list(state.self, take), EdgeMemory<R>::for_each_list(state.edges, take);
  if (sizes.shapes > 0) {
    state.shapes.emplace(ShapeMemory{static_cast<OverlapUpdate>(shapes[0]), {}});
    detail::take(from + sizeof shapes, static_cast<std::size_t>(shapes[1]), state.shapes->overlaps);
    check(*state.shapes, static_cast<std::int64_t>(sizes.shapes * sizes.particles), file);
  }
  detail::check_state(state, triangles, static_cast<std::int64_t>(sizes.meshes), file);
  return state;
}

/// Contact cache of renumbered particles: particle i was particle from[i]. Groups with boxes whose particles are now
/// mixed have no cached data.
inline ProximityMemory remapped(const ProximityMemory& before, std::size_t particles, const std::vector<int>& from) {
  ProximityMemory all;
  const std::size_t words = groups_of(particles);
  const CacheEntry* place = before.entries.data();
  auto near = before.near.begin();
  for (std::size_t mesh = 0; mesh * words < before.boxes.size(); ++mesh) {
    const GroupBox* const boxes = before.boxes.data() + mesh * words;
    std::vector<CacheEntry> places(particles, {0, 0, 0, -INFINITY});
    for (std::size_t i = 0; i < particles; ++i)
      if (boxes[i / kGroupSize].has_entries()) places[i] = *place++;
    for (std::size_t word = 0; word < groups_of(from.size()); ++word) {
      const int *const own = from.data() + word * kGroupSize, *const end = own + particles_in_group(word, from.size());
      const int first = own[0] / kGroupSize;
      const auto has_entries = [&](int i) { return boxes[i / kGroupSize].has_entries(); };
      if (std::any_of(own, end, has_entries)) {
        all.boxes.push_back({{}, {1, 0, 0}, GroupBox::kPerParticle});
        for (const int* i = own; i < end; ++i) all.entries.push_back(places[*i]);
      } else {
        const bool together = std::all_of(own, end, [&](int i) { return i / kGroupSize == first; });
        all.boxes.push_back(together ? boxes[first] : GroupBox{});
      }
    }
    std::vector<const ClosestPointRecord*> last(particles, nullptr);
    for (; near != before.near.end() && near->pair < static_cast<long long>((mesh + 1) * particles); ++near)
      last[near->pair % particles] = &near->record;
    for (std::size_t i = 0; i < from.size(); ++i)
      if (const ClosestPointRecord* const record = last[from[i]])
        all.near.push_back({static_cast<long long>(mesh * from.size() + i), *record});
  }
  return all;
}

/// State of renumbered particles: particle i was particle from[i].
template <class R>
State<R> remapped(const State<R>& before, const std::vector<int>& from) {
  State<R> state{before.steps, {}, {}, {}, before.rest, {}, {}};
  for (const int i : from) {
    state.x.push_back(before.x[i]), state.v.push_back(before.v[i]);
    if (!before.low.empty()) state.low.push_back(before.low[i]);
    // A split does not move particles.
    if (!before.self.x0.empty()) state.self.x0.push_back(before.self.x0[i]);
    if (!before.edges.x0.empty()) state.edges.x0.push_back(before.edges.x0[i]);
  }
  if (!before.self.search.empty()) state.self = unsearched(std::move(state.self.x0), before.self);
  state.edges = unsearched_edges<R>(before.edges.valid.size(), state.edges.x0);
  state.proximity = remapped(before.proximity, before.x.size(), from);
  for (std::size_t first = 0; first < before.overlaps.size(); first += before.x.size())
    for (const int i : from) state.overlaps.push_back(before.overlaps[first + static_cast<std::size_t>(i)]);
  if (before.shapes) state.shapes = remapped(*before.shapes, std::ssize(before.x), from);
  return state;
}

/// State of the same particles at other positions, after `steps` steps, awake, with empty contact caches and searches.
/// Particles that stay keep their contact distance.
template <class R>
State<R> moved_to(const State<R>& before, std::int64_t steps, const std::vector<Vec3>& x, const std::vector<Vec3>& v) {
  State<R> state{steps, {}, {}, {}, {}, {}, {}};
  const auto to_R = [](const Vec3& a) { return std::array<R, 3>{R(a[0]), R(a[1]), R(a[2])}; };
  set_positions(x, state);
  for (const Vec3& one : v) state.v.push_back(to_R(one));
  if (!before.rest.empty()) state.rest = {0, -1};
  state.overlaps.assign(before.overlaps.size(), -1.0f);
  if (!before.self.search.empty()) {
    state.self = unsearched(state.x, before.self);
    state.self.origin = {{0, 0, 0}};
  }
  if (!before.edges.x0.empty()) state.edges = unsearched_edges<R>(before.edges.valid.size(), state.x);
  const auto keep = [&](const std::vector<R>& from, std::vector<R>& to) {
    for (std::size_t i = 0; i < to.size(); ++i)
      if (state.x[i % x.size()] == before.x[i % x.size()]) to[i] = from[i];
  };
  if (before.shapes) state.shapes.emplace();
  keep(before.self.contact_distance, state.self.contact_distance);
  keep(before.edges.contact_distance, state.edges.contact_distance);
  return state;
}

/// Hash of positions and velocities, in the user's order.
template <class R>
std::uint64_t hash_state(const State<R>& state, const std::vector<int>& user_index) {
  std::uint64_t hash = hash_bytes(nullptr, 0);
  for (const int i : solver_of(user_index)) {
    hash = hash_bytes(&state.x[i], sizeof state.x[i], hash);
    hash = hash_bytes(&state.v[i], sizeof state.v[i], hash);
  }
  return hash;
}

}  // namespace malha
