// SPDX-License-Identifier: Apache-2.0
#include "host/model/tear.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "host/mesh/topology.h"
#include "host/mesh/vectors.h"
#include "host/model/ordering/index_map.h"
#include "malha/error.h"

namespace malha {

namespace {

/// Number of faces and lines; lines are numbered after the faces.
int elements_of(const Mesh& mesh) { return static_cast<int>(mesh.faces.size() + mesh.lines.size()); }

/// Calls visit(corner) for each corner of a face or line.
template <class Visit>
void each_corner(const Mesh& mesh, int element, const Visit& visit) {
  const int faces = static_cast<int>(mesh.faces.size());
  if (element >= faces)
    for (const int end : mesh.lines[element - faces]) visit(end);
  else
    for (const int corner : mesh.faces[element])
      if (corner >= 0) visit(corner);
}

/// Finds the splits of one body.
class Tearer {
 public:
  /// `x` are the positions of the body's particles, `pinned` whether each of them is pinned.
  Tearer(int body, const RestShape& shape, const Vec3* x, std::vector<bool> pinned)
      : body_(body),
        shape_(shape),
        mesh_(shape.mesh()),
        x_(x),
        excluded_(std::move(pinned)),
        incident_(mesh_.points.size()) {
    for (int e = 0; e < elements_of(mesh_); ++e)
      each_corner(mesh_, e, [&](int corner) { incident_[corner].push_back(e); });
  }

  std::vector<Split> find(double limit) {
    struct Strained {
      double strain;
      Edge edge;
    };
    std::vector<Strained> strained;
    for (const Edge& e : edges(mesh_)) {
      const double strain = norm(minus(x_[e[1]], x_[e[0]])) / std::sqrt(shape_.squared_length(e[1], e[0])) - 1;
      if (strain > limit) strained.push_back({strain, e});
    }
    std::ranges::stable_sort(strained, [](const Strained& a, const Strained& b) { return a.strain > b.strain; });
    std::vector<Split> splits;
    for (const Strained& s : strained)
      for (const int end : {0, 1})
        if (split(s.edge[end], s.edge[1 - end], splits)) break;
    return splits;
  }

 private:
  bool split(int vertex, int along, std::vector<Split>& splits) {
    if (excluded_[vertex]) return false;
    const Vec3 direction = minus(x_[along], x_[vertex]);
    const int faces = static_cast<int>(mesh_.faces.size());
    Split split{body_, vertex, {}, {}};
    std::size_t stay = 0;
    for (const int element : incident_[vertex]) {
      if (dot(minus(centre(element), x_[vertex]), direction) >= 0)
        ++stay;
      else if (element < faces)
        split.faces.push_back(element);
      else
        split.lines.push_back(element - faces);
    }
    if (stay == 0 || stay == incident_[vertex].size()) return false;
    for (const int element : incident_[vertex])
      each_corner(mesh_, element, [this](int corner) { excluded_[corner] = true; });
    splits.push_back(std::move(split));
    return true;
  }

  Vec3 centre(int element) const {
    Vec3 sum{0, 0, 0};
    int corners = 0;
    each_corner(mesh_, element, [&](int i) {
      for (int k = 0; k < 3; ++k) sum[k] += x_[i][k];
      ++corners;
    });
    return {sum[0] / corners, sum[1] / corners, sum[2] / corners};
  }

  int body_;
  const RestShape& shape_;
  const Mesh& mesh_;
  const Vec3* x_;
  std::vector<bool> excluded_;              // pinned, or in the neighbourhood of a vertex that splits now
  std::vector<std::vector<int>> incident_;  // faces and lines of each vertex; lines are numbered after the faces
};

/// The cut through one body, in the body's numbering. It runs on the side of the first ends of the edges.
class Cutter {
 public:
  Cutter(int body, const Mesh& mesh, const std::set<Edge>& crossed) : body_(body), mesh_(mesh), crossed_(crossed) {}

  std::vector<Split> find() {
    std::map<int, Split> splits;  // of each vertex on the cut; crossed faces and lines get its duplicate
    std::vector<int> incident(mesh_.points.size(), 0);
    const int faces = static_cast<int>(mesh_.faces.size());
    for (int e = 0; e < elements_of(mesh_); ++e) {
      std::vector<int> corners;
      each_corner(mesh_, e, [&](int corner) { corners.push_back(corner); });
      for (const int corner : corners) ++incident[corner];
      for (const int corner : on_the_cut(corners)) {
        Split& split = splits.try_emplace(corner, Split{body_, corner, {}, {}}).first->second;
        e < faces ? split.faces.push_back(e) : split.lines.push_back(e - faces);
      }
    }
    std::vector<Split> found;
    for (auto& [vertex, split] : splits)
      if (static_cast<int>(split.faces.size() + split.lines.size()) < incident[vertex])
        found.push_back(std::move(split));
    return found;
  }

 private:
  /// The corners at which a crossed face or line gets duplicates; none if it is not crossed.
  std::vector<int> on_the_cut(const std::vector<int>& corners) const {
    const std::size_t n = corners.size();
    std::vector<bool> cut(n, false), beyond(n, false);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j)
        if (crossed_.count({corners[i], corners[j]})) cut[i] = beyond[j] = true;
    // A face that the knife crosses completely is separated from all corners on one side of it. Otherwise the knife
    // ended inside of it.
    std::vector<bool> crossed_sides(n);
    for (std::size_t i = 0; i < n; ++i) crossed_sides[i] = is_crossed(corners[i], corners[(i + 1) % n]);
    if (std::ranges::count(crossed_sides, true) > 1)
      for (std::size_t round = 0; round < n; ++round)
        for (std::size_t i = 0; i < n; ++i) {
          const std::size_t next = (i + 1) % n;
          if (crossed_sides[i] || cut[i] == cut[next]) continue;
          const std::size_t other = cut[i] ? next : i;
          if (!beyond[other]) cut[other] = true;
        }
    std::vector<int> found;
    for (std::size_t i = 0; i < n; ++i)
      if (cut[i]) found.push_back(corners[i]);
    return found;
  }
  bool is_crossed(int a, int b) const { return crossed_.count({a, b}) || crossed_.count({b, a}); }

  int body_;
  const Mesh& mesh_;
  const std::set<Edge>& crossed_;
};

/// The body of an edge that is cut. Throws InputError for an edge that cannot be cut.
int body_to_cut(const Model& model, const Edge& edge) {
  for (const int end : edge)
    if (end < 0 || end >= model.count())
      throw InputError("cut: found particle " + std::to_string(end) + "; allowed: 0 to " +
                       std::to_string(model.count() - 1));
  const int body = body_of(model, edge[0]);
  if (body != body_of(model, edge[1]))
    throw InputError("cut: found " + particle_name(model, edge[0]) + " and " + particle_name(model, edge[1]) +
                     "; allowed: both of one body");
  if (!model.scene.bodies[body].tear)
    throw InputError("cut: found body '" + model.scene.bodies[body].name +
                     "', which does not tear; allowed: one with \"tear\"");
  return body;
}

}  // namespace

void apply(const Split& split, Mesh& mesh) {
  const int duplicate = static_cast<int>(mesh.points.size());
  mesh.points.push_back(Vec3(mesh.points[split.vertex]));
  for (const int f : split.faces) std::ranges::replace(mesh.faces[f], split.vertex, duplicate);
  for (const int l : split.lines) std::ranges::replace(mesh.lines[l], split.vertex, duplicate);
}

Mesh body_mesh(const RenderMesh& render_mesh, std::size_t body) {
  const int first = render_mesh.body_begin[body];
  Mesh mesh{{render_mesh.points.begin() + first, render_mesh.points.begin() + render_mesh.body_begin[body + 1]},
            {render_mesh.faces.begin() + render_mesh.face_begin[body],
             render_mesh.faces.begin() + render_mesh.face_begin[body + 1]},
            {render_mesh.lines.begin() + render_mesh.line_begin[body],
             render_mesh.lines.begin() + render_mesh.line_begin[body + 1]},
            {},
            render_mesh.vertices[body]};
  for (Quad& face : mesh.faces)
    for (int& corner : face)
      if (corner >= 0) corner -= first;
  for (Edge& line : mesh.lines)
    for (int& end : line) end -= first;
  return mesh;
}

std::vector<bool> pinned_now(const Model& model, double time, const std::vector<int>& held) {
  std::vector<bool> pinned(model.x.size(), false);
  for (int i = 0; i < model.count(); ++i) pinned[model.user_index[i]] = !(model.w[i] > 0);
  for (const MovedPins& pins : model.moved)
    for (const int i : pins.particles) pinned[model.user_index[i]] = !pins.release_time || time < *pins.release_time;
  for (const int user : held) pinned[user] = true;
  return pinned;
}

std::vector<Split> find_tears(const Model& model, const std::vector<Vec3>& x, const std::vector<bool>& pinned) {
  std::vector<Split> all;
  for (std::size_t b = 0; b < model.scene.bodies.size(); ++b) {
    const auto& tear = model.scene.bodies[b].tear;
    if (!tear) continue;
    const int begin = model.render_mesh.body_begin[b], end = model.render_mesh.body_begin[b + 1];
    const Mesh mesh = body_mesh(model.render_mesh, b);
    const RestShape shape = rest_shape(model.render_mesh, b, mesh);
    Tearer tearer(static_cast<int>(b), shape, &x[begin], {pinned.begin() + begin, pinned.begin() + end});
    const std::vector<Split> found = tearer.find(tear->strain);
    all.insert(all.end(), found.begin(), found.end());
  }
  return all;
}

TearableEdges tearable_edges(const Model& model) {
  const std::vector<int> number = solver_of(model.user_index);
  TearableEdges found;
  for (std::size_t b = 0; b < model.scene.bodies.size(); ++b) {
    const auto& tear = model.scene.bodies[b].tear;
    if (!tear) continue;
    const Mesh mesh = body_mesh(model.render_mesh, b);
    const RestShape shape = rest_shape(model.render_mesh, b, mesh);
    for (const Edge& e : edges(mesh)) {
      const int first = model.render_mesh.body_begin[b];
      const Edge ends{number[first + e[0]], number[first + e[1]]};
      if (!(model.w[ends[0]] > 0) && !(model.w[ends[1]] > 0)) continue;  // neither end can split
      found.ends.push_back(ends);
      found.max_length.push_back((1 + tear->strain) * std::sqrt(shape.squared_length(e[1], e[0])));
    }
  }
  return found;
}

bool can_tear(const Scene& scene) {
  return std::ranges::any_of(scene.bodies, [](const BodySpec& b) { return b.tear.has_value(); });
}

std::vector<int> ancestors(const Model& before, const Model& after, const std::vector<Split>& splits,
                           std::size_t first) {
  const std::vector<int>&old = before.render_mesh.body_begin, &now = after.render_mesh.body_begin;
  std::vector<int> user;  // the user's index in `before` for each of `after`
  for (std::size_t b = 0; b + 1 < now.size(); ++b) {
    for (int i = old[b]; i < old[b + 1]; ++i) user.push_back(i);
    for (std::size_t s = first; s < splits.size(); ++s)
      if (splits[s].body == static_cast<int>(b)) user.push_back(user[now[b] + splits[s].vertex]);
  }
  const std::vector<int> number = solver_of(before.user_index);
  std::vector<int> from;
  for (const int u : after.user_index) from.push_back(number[user[u]]);
  return from;
}

std::vector<int> encode_splits(const std::vector<Split>& splits) {
  std::vector<int> numbers;
  for (const Split& split : splits) {
    numbers.insert(numbers.end(), {split.body, split.vertex});
    for (const auto* list : {&split.faces, &split.lines}) {
      numbers.push_back(static_cast<int>(list->size()));
      numbers.insert(numbers.end(), list->begin(), list->end());
    }
  }
  return numbers;
}

std::vector<Split> decode_splits(const std::vector<int>& numbers, const Scene& scene, const RenderMesh& intact,
                                 const std::string& file) {
  const auto require = [&file](bool good, const std::string& found, const std::string& allowed) {
    if (!good) refuse(file, "tears", found, allowed);
  };
  std::vector<Mesh> meshes;
  std::vector<std::vector<std::size_t>> incident;  // number of faces and lines of each vertex
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    meshes.push_back(scene.bodies[b].tear ? body_mesh(intact, b) : Mesh{});
    auto& counts = incident.emplace_back(meshes[b].points.size(), 0);
    for (int e = 0; e < elements_of(meshes[b]); ++e) each_corner(meshes[b], e, [&](int corner) { ++counts[corner]; });
  }
  std::vector<Split> splits;
  std::size_t at = 0;
  const auto left = [&] { return numbers.size() - at; };
  while (left() > 0) {
    require(left() >= 2, "a list that ends in a tear", "whole tears");
    Split split{numbers[at], numbers[at + 1], {}, {}};
    at += 2;
    require(split.body >= 0 && split.body < int(meshes.size()) && scene.bodies[split.body].tear.has_value(),
            "body " + std::to_string(split.body), "a body that tears");
    Mesh& mesh = meshes[split.body];
    require(split.vertex >= 0 && split.vertex < int(mesh.points.size()), "vertex " + std::to_string(split.vertex),
            "0 to " + std::to_string(mesh.points.size() - 1));
    const auto read = [&](std::vector<int>& list, const auto& elements, const std::string& what) {
      require(left() >= 1 && numbers[at] >= 0 && std::size_t(numbers[at]) < left(), "a list that ends in a tear",
              "whole tears");
      const auto first = numbers.begin() + std::ptrdiff_t(at) + 1;
      list.assign(first, first + numbers[at]);
      at += 1 + list.size();
      for (std::size_t i = 0; i < list.size(); ++i) {
        const int e = list[i];
        require((i == 0 || e > list[i - 1]) && e >= 0 && e < int(elements.size()) &&
                    std::ranges::find(elements[e], split.vertex) != elements[e].end(),
                what + " " + std::to_string(e), "those of vertex " + std::to_string(split.vertex) + ", ascending");
      }
    };
    read(split.faces, mesh.faces, "face"), read(split.lines, mesh.lines, "line");
    const std::size_t moved = split.faces.size() + split.lines.size();
    std::size_t& all = incident[split.body][split.vertex];
    require(moved > 0 && moved < all, std::to_string(moved) + " faces and lines that get the duplicate",
            "1 to " + std::to_string(int(all) - 1) + " at vertex " + std::to_string(split.vertex));
    all -= moved;
    incident[split.body].push_back(moved);
    apply(split, mesh);
    splits.push_back(std::move(split));
  }
  return splits;
}

std::vector<Split> find_cuts(const Model& model, const std::vector<Edge>& crossed, const std::vector<bool>& pinned) {
  std::map<int, std::vector<Edge>> of_bodies;
  for (const Edge& edge : crossed) of_bodies[body_to_cut(model, edge)].push_back(edge);
  std::vector<Split> all;
  for (const auto& [body, edges] : of_bodies) {
    std::set<int> pinned_ends[2];  // on either side
    for (const Edge& edge : edges)
      for (const int side : {0, 1})
        if (pinned[edge[side]]) pinned_ends[side].insert(edge[side]);
    const int side = pinned_ends[1].size() < pinned_ends[0].size() ? 1 : 0, first = model.render_mesh.body_begin[body];
    std::set<Edge> directed;
    for (const Edge& edge : edges) directed.insert({edge[side] - first, edge[1 - side] - first});
    const Mesh mesh = body_mesh(model.render_mesh, body);
    const std::vector<Split> found = Cutter(body, mesh, directed).find();
    all.insert(all.end(), found.begin(), found.end());
  }
  return all;
}

}  // namespace malha
