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
#include "host/environment/layout_map.h"
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

/// Contact caches in another layout, of a layout with this many particles. Groups of particles that were not in one
/// group have entries of their own: what a box says holds at its centre.
inline ProximityMemory remapped(const ProximityMemory& before, std::size_t particles, const LayoutMap& map) {
  ProximityMemory all;
  if (before.boxes.empty()) return all;
  const std::vector<int>& from = map.particles;
  const std::size_t words = groups_of(particles), count = from.size();
  // Entries and records follow each other mesh by mesh.
  std::vector<const CacheEntry*> entries{before.entries.data()};
  for (std::size_t mesh = 0; (mesh + 1) * words < before.boxes.size(); ++mesh)
    entries.push_back(entries.back() + count_entries(before.boxes.data() + mesh * words, particles));
  constexpr CacheEntry unknown{0, 0, 0, -INFINITY};
  for (std::size_t mesh = 0; mesh < map.meshes.size(); ++mesh) {
    if (map.meshes[mesh] == LayoutMap::kNew) {
      all.boxes.insert(all.boxes.end(), groups_of(count), GroupBox{});
      continue;
    }
    const auto then = static_cast<std::size_t>(map.meshes[mesh]);
    const GroupBox* const boxes = before.boxes.data() + then * words;
    const CacheEntry* place = entries[then];
    std::vector<CacheEntry> places(particles);
    for (std::size_t i = 0; i < particles; ++i) {
      const GroupBox& box = boxes[i / kGroupSize];
      places[i] = box.has_entries() ? *place++ : box.entry(box.centre);
    }
    for (std::size_t word = 0; word < groups_of(count); ++word) {
      const int *const own = from.data() + word * kGroupSize, *const end = own + particles_in_group(word, count);
      const auto box_of = [&](int i) { return i == LayoutMap::kNew ? nullptr : boxes + i / kGroupSize; };
      const GroupBox* const first = box_of(own[0]);
      const bool together = std::all_of(own, end, [&](int i) { return box_of(i) == first; });
      const auto is_unknown = [&](int i) { return box_of(i) == nullptr || box_of(i)->distance == 0; };
      if (together && first != nullptr && !first->has_entries()) {
        all.boxes.push_back(*first);
      } else if (std::all_of(own, end, is_unknown)) {
        all.boxes.push_back(GroupBox{});
      } else {
        all.boxes.push_back({{}, {1, 0, 0}, GroupBox::kPerParticle});
        for (const int* i = own; i < end; ++i) all.entries.push_back(*i == LayoutMap::kNew ? unknown : places[*i]);
      }
    }
    std::vector<const ClosestPointRecord*> last(particles, nullptr);
    const auto first_pair = static_cast<long long>(then * particles);
    auto near = std::ranges::lower_bound(before.near, first_pair, {}, &PairRecord::pair);
    for (; near != before.near.end() && near->pair < first_pair + static_cast<long long>(particles); ++near)
      last[near->pair - first_pair] = &near->record;
    for (std::size_t i = 0; i < count; ++i)
      if (const auto* const record = from[i] == LayoutMap::kNew ? nullptr : last[from[i]])
        all.near.push_back({static_cast<long long>(mesh * count + i), *record});
  }
  return all;
}

/// A state with other numbers, into which all of a state in single precision go without rounding.
template <class To, class From>
State<To> converted(const State<From>& from) {
  const auto rows = []<class Row>(const auto& values, std::vector<Row>& to) {
    for (const auto& row : values) {
      Row& now = to.emplace_back();
      for (std::size_t k = 0; k < row.size(); ++k) now[k] = static_cast<To>(row[k]);
    }
  };
  const auto numbers = [](const std::vector<From>& values) { return std::vector<To>(values.begin(), values.end()); };
  State<To> to;
  to.steps = from.steps, to.rest = from.rest, to.proximity = from.proximity;
  to.overlaps = from.overlaps, to.shapes = from.shapes;
  rows(from.x, to.x), rows(from.v, to.v), rows(from.low, to.low);
  rows(from.self.x0, to.self.x0), rows(from.self.from, to.self.from), rows(from.self.way, to.self.way);
  to.self.contact_distance = numbers(from.self.contact_distance);
  to.self.origin = from.self.origin, to.self.search = from.self.search;
  to.self.substeps_kinematic_penetration = from.self.substeps_kinematic_penetration;
  rows(from.edges.x0, to.edges.x0), rows(from.edges.from, to.edges.from), rows(from.edges.way, to.edges.way);
  to.edges.contact_distance = numbers(from.edges.contact_distance), to.edges.valid = from.edges.valid;
  return to;
}

/// The state in another layout of a state in any precision, in double. `start`: the state at the start of that layout,
/// in its precision, which new particles have; what it has no memory for is left out. Searches are valid where all
/// particles are the same.
inline State<double> remapped(const State<double>& before, const LayoutMap& map, State<double> start) {
  State<double> state = std::move(start);
  const bool compensates = !state.low.empty(), compensated = !before.low.empty();
  const std::size_t count = map.particles.size(), count_before = before.x.size();
  const std::array<double, 3> origin =
      before.self.origin.empty()
          ? std::array<double, 3>{}
          : std::array<double, 3>{before.self.origin[0].x, before.self.origin[0].y, before.self.origin[0].z};
  const bool same = map.has_same_particles(count_before);
  const bool remembers_self = !before.self.x0.empty() && compensates == compensated;
  state.steps = before.steps;
  if (!state.rest.empty()) state.rest = before.rest.empty() ? std::vector<std::int64_t>{0, -1} : before.rest;
  std::vector<std::array<double, 3>> x0_self, x0_edges;
  for (std::size_t i = 0; i < count; ++i) {
    const bool is_new = map.particles[i] == LayoutMap::kNew;
    const auto from = static_cast<std::size_t>(is_new ? 0 : map.particles[i]);
    std::array<double, 3> place = state.x[i];
    if (!is_new) {
      state.v[i] = before.v[from], state.x[i] = place = before.x[from];
      for (std::size_t k = 0; k < 3; ++k) {
        if (compensated) place[k] += before.low[from][k];
        if (compensates && compensated) state.low[i][k] = before.low[from][k];
        if (compensates && !compensated) state.x[i][k] = float(place[k]), state.low[i][k] = place[k] - state.x[i][k];
        if (!compensates) state.x[i][k] = place[k];
      }
    } else if (compensates) {
      for (std::size_t k = 0; k < 3; ++k) place[k] += state.low[i][k];
    }
    if (!state.self.x0.empty()) {
      for (std::size_t k = 0; k < 3; ++k) place[k] -= remembers_self ? origin[k] : 0;
      x0_self.push_back(remembers_self && !is_new ? before.self.x0[from] : place);
    }
    if (!state.edges.x0.empty())
      x0_edges.push_back(!is_new && !before.edges.x0.empty() ? before.edges.x0[from] : state.x[i]);
  }
  if (!state.self.x0.empty()) {
    const bool ignores = state.self.search[0].crosses != 0;
    state.self = unsearched(std::move(x0_self), remembers_self ? before.self : SelfMemory<double>{});
    if (remembers_self && map.keeps_self_distances && same) {
      state.self.from = before.self.from, state.self.way = before.self.way, state.self.search = before.self.search;
    }
    state.self.search[0].crosses = ignores ? 1 : state.self.search[0].crosses;
    for (std::size_t i = 0; map.keeps_self_distances && i < count; ++i)
      if (const int from = map.particles[i]; from != LayoutMap::kNew)
        state.self.contact_distance[i] = before.self.contact_distance[static_cast<std::size_t>(from)];
  }
  if (!state.edges.x0.empty()) {
    state.edges = unsearched_edges<double>(state.edges.valid.size(), x0_edges);
    for (std::size_t pair = 0; pair < state.edges.contact_distance.size(); ++pair) {
      const std::size_t group = pair / count, i = pair % count;
      if (map.is_new(map.edge_groups, group, i)) continue;
      const auto then = static_cast<std::size_t>(map.edge_groups[group]);
      const std::size_t pair_then = then * count_before + static_cast<std::size_t>(map.particles[i]);
      state.edges.contact_distance[pair] = before.edges.contact_distance[pair_then];
      if (!same || compensates != compensated) continue;
      state.edges.from[pair] = before.edges.from[pair_then], state.edges.way[pair] = before.edges.way[pair_then];
      state.edges.valid[group] = before.edges.valid[then];
    }
  }
  state.proximity = remapped(before.proximity, count_before, map);
  const bool all_overlaps = before.overlaps.empty() || before.overlaps[0] < 0;  // are found at the next detection
  for (std::size_t pair = 0; pair < state.overlaps.size(); ++pair) {
    const std::size_t k = pair / count, i = pair % count;
    state.overlaps[pair] = all_overlaps ? -1.0f : 0.0f;
    if (!all_overlaps && !map.is_new(map.deforming, k, i))
      state.overlaps[pair] = before.overlaps[static_cast<std::size_t>(map.deforming[k]) * count_before +
                                             static_cast<std::size_t>(map.particles[i])];
  }
  if (state.shapes) state.shapes = before.shapes ? remapped(*before.shapes, std::ssize(before.x), map) : ShapeMemory{};
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
