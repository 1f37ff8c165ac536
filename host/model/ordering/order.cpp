// SPDX-License-Identifier: Apache-2.0
#include "host/model/ordering/order.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <numeric>
#include <span>
#include <unordered_map>

#include "host/mesh/bounding_box.h"
#include "host/model/ordering/index_map.h"

namespace malha {

namespace {

/// Spreads the lower 21 bits of a, so that two zero bits follow each of them.
std::uint64_t spread(std::uint64_t a) {
  a &= 0x1fffff;
  a = (a | a << 32) & 0x1f00000000ffff;
  a = (a | a << 16) & 0x1f0000ff0000ff;
  a = (a | a << 8) & 0x100f00f00f00f00f;
  a = (a | a << 4) & 0x10c30c30c30c30c3;
  return (a | a << 2) & 0x1249249249249249;
}

/// Morton codes within the bounding box of each component, so that the order of a body does not depend on the others.
/// `sorted` are the particles by component.
std::vector<std::uint64_t> morton_codes(const std::vector<Vec3>& points, const std::vector<int>& component,
                                        const std::vector<int>& sorted) {
  std::vector<std::uint64_t> codes(points.size());
  for (auto begin = sorted.begin(), end = begin; begin != sorted.end(); begin = end) {
    end = std::find_if(begin, sorted.end(), [&](int i) { return component[i] != component[*begin]; });
    const auto [low, high] = bounds_of(points, std::span(begin, end));
    const double side = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2], 1e-300});
    for (auto i = begin; i != end; ++i)
      for (int k = 0; k < 3; ++k)
        codes[*i] |= spread(static_cast<std::uint64_t>((points[*i][k] - low[k]) / side * 0x1fffff)) << k;
  }
  return codes;
}

/// The distance in memory between neighbours, in particles, summed over the edges of each component.
std::vector<double> edge_distances(const std::vector<int>& position, const std::vector<int>& component, int components,
                                   const std::vector<Edge>& edges) {
  std::vector<double> sum(components, 0);
  for (const Edge& e : edges) sum[component[e[0]]] += std::abs(position[e[0]] - position[e[1]]);
  return sum;
}

constexpr int kMaxBandWidth = 160;  // columns: a dozen rows of a band fit into a core's L1 cache

// Bands are multiples of this wide: every second particle of a row then makes whole packs, and as many as of the next
// row.
constexpr int kBandMultiple = 32;

/// The length of a row if the particles of a component are numbered row by row: the most frequent distance in memory of
/// neighbours that are not adjacent there. 0: they are not numbered like that.
int row_length(const std::vector<int>& apart) {
  std::unordered_map<int, int> times;
  for (const int d : apart)
    if (d > 1) ++times[d];
  int best = 0, most = 0;
  for (const auto& [d, n] : times)
    if (n > most || (n == most && d < best)) best = d, most = n;
  return 5 * static_cast<std::size_t>(most) >= apart.size() ? best : 0;
}

/// Reorders wide sheets into bands of columns, each row by row, so that patches of several rows are small enough.
void cut_into_bands(std::vector<int>& order, const std::vector<int>& component, int components,
                    const std::vector<Edge>& edges) {
  const std::vector<int> position = solver_of(order);
  std::vector<std::vector<int>> apart(components);
  for (const Edge& e : edges) apart[component[e[0]]].push_back(std::abs(position[e[0]] - position[e[1]]));
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    const int c = component[order[begin]];
    while (end < order.size() && component[order[end]] == c) ++end;
    const int row = row_length(apart[c]);
    if (row <= kMaxBandWidth || static_cast<std::size_t>(row) > (end - begin) / 2) continue;
    const int bands = (row + kMaxBandWidth - 1) / kMaxBandWidth,
              width = ((row + bands - 1) / bands + kBandMultiple - 1) / kBandMultiple * kBandMultiple;
    const auto band = [&](int i) { return (position[i] - static_cast<int>(begin)) % row / width; };
    std::stable_sort(order.begin() + begin, order.begin() + end, [&](int a, int b) { return band(a) < band(b); });
  }
}

}  // namespace

std::vector<int> solver_order(const std::vector<Vec3>& points, const std::vector<int>& component, int components,
                              const std::vector<Edge>& edges) {
  std::vector<int> user(points.size());
  std::iota(user.begin(), user.end(), 0);
  std::ranges::stable_sort(user, [&](int a, int b) { return component[a] < component[b]; });

  const std::vector<std::uint64_t> code = morton_codes(points, component, user);
  std::vector<int> morton = user;
  std::ranges::stable_sort(morton, [&](int a, int b) {
    return component[a] != component[b] ? component[a] < component[b] : code[a] < code[b];
  });

  const auto by_user = edge_distances(solver_of(user), component, components, edges);
  const auto by_morton = edge_distances(solver_of(morton), component, components, edges);
  // Each component has the same range in both orders, so that the better order can be chosen for each component.
  for (std::size_t i = 0; i < user.size(); ++i) {
    const int c = component[user[i]];
    if (4 * by_morton[c] < by_user[c]) user[i] = morton[i];
  }
  cut_into_bands(user, component, components, edges);
  return user;
}

}  // namespace malha
