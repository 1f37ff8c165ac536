// SPDX-License-Identifier: Apache-2.0
#include "host/mesh/rest_shape.h"

#include <algorithm>
#include <cmath>

#include "host/mesh/topology.h"
#include "host/mesh/vectors.h"

namespace malha {

namespace {

constexpr double kRounding = 1e-12;   // relative
constexpr double kFolded = 1 - 1e-9;  // cosine between triangles that lie on each other

/// The corner of a face at which a point lies, or -1.
int corner_of(const Quad& face, int point) {
  const auto at = std::ranges::find(face, point);
  return at == face.end() ? -1 : static_cast<int>(at - face.begin());
}

Vec3 along(const Vec3& from, const Vec3& direction, double way) {
  return {from[0] + direction[0] * way, from[1] + direction[1] * way, from[2] + direction[2] * way};
}

}  // namespace

RestShape::RestShape(const Mesh& mesh, const Mesh* rest) : mesh_(&mesh), places_(rest ? rest : &mesh) {
  if (places_ == mesh_ || (places_->points.size() == mesh.points.size() && places_->faces == mesh.faces)) return;
  faces_ = std::make_shared<CompressedLists<int>>(mesh.points.size(), [&](const auto& add) {
    for (std::size_t f = 0; f < mesh.faces.size(); ++f)
      for (const int point : mesh.faces[f])
        if (point >= 0) add(point, static_cast<int>(f));
  });
}

void RestShape::triangle(int a, int b, int c, Vec3 (&X)[3]) const {
  for (const int f : (*faces_)[a]) {
    const Quad& face = mesh_->faces[f];
    const int at[3] = {corner_of(face, a), corner_of(face, b), corner_of(face, c)};
    if (at[1] < 0 || at[2] < 0) continue;
    for (int k = 0; k < 3; ++k) X[k] = place(places_->faces[f][at[k]]);
    return;
  }
}

void RestShape::edge(int a, int b, Vec3 (&X)[2]) const {
  double sum = 0;
  int count = 0;
  for (const int f : (*faces_)[a]) {
    const int at_a = corner_of(mesh_->faces[f], a), at_b = corner_of(mesh_->faces[f], b);
    if (at_b < 0) continue;
    const Vec3 &from = place(places_->faces[f][at_a]), &to = place(places_->faces[f][at_b]);
    if (count++ == 0) X[0] = from, X[1] = to;
    sum += distance(from, to);
  }
  const double first = distance(X[0], X[1]), mean = sum / count;
  if (std::abs(mean - first) > kRounding * first) X[1] = along(X[0], minus(X[1], X[0]), mean / first);
}

Vec3 RestShape::wing(const int (&from)[2], int point, const Vec3 (&own)[3]) const {
  Vec3 other[3];
  triangle(from[0], from[1], point, other);
  const auto& [a, b, c] = other;
  const Vec3 e = minus(b, a), E = minus(own[1], own[0]), r = minus(own[2], own[0]), n = cross(E, r);
  if (a == own[0] && b == own[1]) {
    const Vec3 beside = cross(E, minus(c, a));
    if (dot(n, beside) < kFolded * norm(n) * norm(beside)) return c;
  }
  const double foot = dot(minus(c, a), e) / dot(e, e), height = norm(normal(a, b, c)) / norm(e);
  const Vec3 away = along(r, E, -dot(r, E) / dot(E, E));  // from the edge to the triangle's third corner
  return along(along(own[0], E, foot), away, -height / norm(away));
}

void RestShape::corners(Element element, const int* points, Vec3* X) const {
  if (!faces_) {
    for (int j = 0; j < facts_of(element).particles; ++j) X[j] = place(points[j]);
    return;
  }
  if (element == Element::Edges) {
    Vec3 ends[2];
    edge(points[0], points[1], ends);
    X[0] = ends[0], X[1] = ends[1];
    return;
  }
  Vec3 own[3];
  triangle(points[0], points[1], points[2], own);
  for (int j = 0; j < 3; ++j) X[j] = own[j];
  if (element == Element::Hinges) X[3] = wing({points[0], points[1]}, points[3], own);
  if (element == Element::WingedTriangles)
    for (int i = 0; i < 3; ++i) {
      const int from = (i + 1) % 3, to = (i + 2) % 3;
      X[3 + i] = wing({points[from], points[to]}, points[3 + i], {own[from], own[to], own[i]});
    }
}

double RestShape::length(int a, int b) const {
  if (!faces_) return distance(place(a), place(b));
  Vec3 X[2];
  edge(a, b, X);
  return distance(X[0], X[1]);
}

double RestShape::squared_length(int a, int b) const {
  if (!faces_) return squared_distance(place(a), place(b));
  Vec3 X[2];
  edge(a, b, X);
  return squared_distance(X[0], X[1]);
}

double RestShape::area(int a, int b, int c) const {
  if (!faces_) return malha::area(place(a), place(b), place(c));
  Vec3 X[3];
  triangle(a, b, c, X);
  return malha::area(X[0], X[1], X[2]);
}

Ease largest_ease(const RestShape& shape) {
  Ease found;
  if (!shape.has_seams()) return found;
  const Mesh &mesh = shape.mesh(), &places = shape.places();
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    for (int k = 0, corners = is_triangle(mesh.faces[f]) ? 3 : 4; k < corners; ++k) {
      const int next = (k + 1) % corners, a = mesh.faces[f][k], b = mesh.faces[f][next];
      const double mean = shape.length(a, b);
      const double own = distance(places.points[places.faces[f][k]], places.points[places.faces[f][next]]);
      // The side beyond the seam is as much longer than the mean as this one is shorter.
      if (const double ease = (2 * mean - own) / own - 1; ease > found.most) found = {ease, {a, b}};
    }
  return found;
}

}  // namespace malha
