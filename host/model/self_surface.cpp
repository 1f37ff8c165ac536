#include "host/model/self_surface.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "host/error.h"
#include "host/mesh/topology.h"
#include "host/mesh/vectors.h"
#include "host/model/tear.h"

namespace malha {

namespace {

/// Elements of one body in its own numbering: every particle and every edge belongs to the first that has it.
void add_simplices(const Mesh& mesh, SelfSurface& surface) {
  const int particles = static_cast<int>(mesh.points.size());
  std::vector<Simplex> own;
  for (const Triangle& t : triangles(mesh)) own.push_back({{t[0], t[1], t[2]}, 1 << 6});
  surface.triangles += static_cast<int>(own.size());
  for (const Edge& line : mesh.lines) own.push_back({{line[0], line[1], line[1]}, 0});
  std::vector<bool> has_one(particles, false);
  for (const Simplex& e : own)
    for (const int corner : e.corner) has_one[corner] = true;
  for (int i = 0; i < particles; ++i)
    if (!has_one[i]) own.push_back({{i, i, i}, 0});

  struct Side {
    int low, high, simplex, k;
  };
  std::vector<Side> sides;
  std::vector<bool> taken(particles, false);
  for (int e = 0; e < static_cast<int>(own.size()); ++e)
    for (int k = 0; k < 3; ++k) {
      const int i = own[e].corner[k];
      if (!taken[i]) own[e].has |= 1 << k, taken[i] = true;
      const auto [low, high] = std::minmax({own[e].from(k), own[e].to(k)});
      if (low != high) sides.push_back({low, high, e, k});
    }
  std::stable_sort(sides.begin(), sides.end(),
                   [](const Side& a, const Side& b) { return a.low != b.low ? a.low < b.low : a.high < b.high; });
  for (std::size_t s = 0; s < sides.size(); ++s)
    if (s == 0 || sides[s].low != sides[s - 1].low || sides[s].high != sides[s - 1].high) {
      own[sides[s].simplex].has |= 1 << (3 + sides[s].k);
      ++surface.edges;
    }
  surface.particles += particles;
  surface.simplices.insert(surface.simplices.end(), own.begin(), own.end());
}

}  // namespace

SelfSurface self_surface(const Model& model) {
  const Appearance& look = model.look;
  const std::vector<std::string>& named = model.scene.self_collision->bodies;
  SelfSurface surface;
  std::vector<int> solver_of(model.user_of.size());
  for (std::size_t i = 0; i < solver_of.size(); ++i) solver_of[model.user_of[i]] = static_cast<int>(i);
  surface.takes_part.resize(solver_of.size(), 0), surface.body.resize(solver_of.size(), 0);
  for (std::size_t b = 0; b + 1 < look.body_begin.size(); ++b) {
    const int first = look.body_begin[b], particles = look.body_begin[b + 1] - first;
    for (int i = 0; i < particles; ++i) surface.body[solver_of[first + i]] = static_cast<int>(b);
    if (!named.empty() && std::find(named.begin(), named.end(), model.scene.bodies[b].name) == named.end()) continue;
    const std::size_t before = surface.simplices.size();
    add_simplices(body_mesh(look, b), surface);
    for (std::size_t e = before; e < surface.simplices.size(); ++e)
      for (int& corner : surface.simplices[e].corner) corner = solver_of[first + corner];
    for (int i = 0; i < particles; ++i) surface.takes_part[solver_of[first + i]] = 1;
  }
  const auto lowest = [](const Simplex& e) { return std::min({e.corner[0], e.corner[1], e.corner[2]}); };
  std::stable_sort(surface.simplices.begin(), surface.simplices.end(),
                   [&](const Simplex& a, const Simplex& b) { return lowest(a) < lowest(b); });
  return surface;
}

namespace {

/// Sign of the volume that d - a, c - a and b - a span: 0 where rounding could have made it.
int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 u = minus(b, a), v = minus(c, a), w = minus(d, a);
  double volume = 0, size = 0;
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3, m = (k + 2) % 3;
    volume += u[k] * (v[l] * w[m] - v[m] * w[l]);
    size += std::abs(u[k]) * (std::abs(v[l] * w[m]) + std::abs(v[m] * w[l]));
  }
  const double rounding = 1e-15 * size;
  return volume > rounding ? 1 : volume < -rounding ? -1 : 0;
}

bool crosses(const std::vector<Vec3>& x, const Edge& edge, const Triangle& t) {
  const Vec3 &p = x[edge[0]], &q = x[edge[1]], &a = x[t[0]], &b = x[t[1]], &c = x[t[2]];
  if (orientation(a, b, c, p) * orientation(a, b, c, q) >= 0) return false;
  const int side = orientation(p, q, a, b);
  return side != 0 && orientation(p, q, b, c) == side && orientation(p, q, c, a) == side;
}

}  // namespace

// Edges and triangles are sorted into cubes as wide as the largest of most edges' boxes, in a map of cubes: slower than
// the solver's grid, and shares nothing with it.
std::int64_t count_crossings(const SelfSurface& surface, const std::vector<Vec3>& x, CrossingPair* first) {
  struct Item {
    std::array<int, 3> corner;
    Vec3 low, high;
  };
  std::vector<Item> edges, faces;
  double sides = 0;
  const auto item = [&x](int a, int b, int c) {
    Item made{{a, b, c}, {}, {}};
    for (int k = 0; k < 3; ++k) {
      made.low[k] = std::min({x[a][k], x[b][k], x[c][k]});
      made.high[k] = std::max({x[a][k], x[b][k], x[c][k]});
    }
    return made;
  };
  for (const Simplex& e : surface.simplices) {
    for (int k = 0; k < 3; ++k)
      if (e.owns_edge(k)) edges.push_back(item(e.from(k), e.to(k), e.to(k)));
    if (e.is_face()) faces.push_back(item(e.corner[0], e.corner[1], e.corner[2]));
  }
  if (edges.empty() || faces.empty()) return 0;
  for (const Item& e : edges)
    sides += std::max({e.high[0] - e.low[0], e.high[1] - e.low[1], e.high[2] - e.low[2]}) /
             static_cast<double>(edges.size());
  if (!(sides > 0) || !std::isfinite(sides)) return 0;
  const double cube = 2 * sides;
  const Vec3 origin = x[edges[0].corner[0]];
  using Key = std::array<std::int64_t, 3>;
  const auto key = [&](const Vec3& at) {
    Key k;
    for (int j = 0; j < 3; ++j)
      k[j] = static_cast<std::int64_t>(std::floor(std::clamp((at[j] - origin[j]) / cube, -1e15, 1e15)));
    return k;
  };
  const auto for_each_cube = [&](const Item& of, const auto& visit) {
    const Key low = key(of.low), high = key(of.high);
    for (std::int64_t i = low[0]; i <= high[0]; ++i)
      for (std::int64_t j = low[1]; j <= high[1]; ++j)
        for (std::int64_t k = low[2]; k <= high[2]; ++k) visit(Key{i, j, k});
  };
  std::vector<std::pair<Key, int>> in_cube;
  for (int f = 0; f < static_cast<int>(faces.size()); ++f)
    for_each_cube(faces[f], [&](const Key& k) { in_cube.emplace_back(k, f); });
  std::sort(in_cube.begin(), in_cube.end());

  std::int64_t count = 0;
  std::vector<int> near;
  for (const Item& e : edges) {
    near.clear();
    for_each_cube(e, [&](const Key& k) {
      for (auto at = std::lower_bound(in_cube.begin(), in_cube.end(), std::pair<Key, int>{k, -1});
           at != in_cube.end() && at->first == k; ++at)
        near.push_back(at->second);
    });
    std::sort(near.begin(), near.end());
    near.erase(std::unique(near.begin(), near.end()), near.end());
    for (const int f : near) {
      const auto& [a, b, c] = faces[f].corner;
      const int p = e.corner[0], q = e.corner[1];
      if (p == a || p == b || p == c || q == a || q == b || q == c || !crosses(x, {p, q}, {a, b, c})) continue;
      if (count++ == 0 && first != nullptr) *first = {{p, q}, {a, b, c}};
    }
  }
  return count;
}

void refuse_crossings(const Model& model) {
  CrossingPair pair;
  const std::int64_t count = count_crossings(self_surface(model), model.x, &pair);
  if (count == 0) return;
  const auto name = [&](int i) { return particle_name(model, model.user_of[i]); };
  refuse(model.scene.file, "/self_collision",
         "bodies that cross at the start: the edge from " + name(pair.edge[0]) + " to " + name(pair.edge[1]) +
             " goes through the triangle at " + name(pair.triangle[0]) + " (" + std::to_string(count) + " like it)",
         "bodies that do not cross each other or themselves");
}

}  // namespace malha
