// SPDX-License-Identifier: Apache-2.0
#include "host/mesh/rest_shape.h"

#include <gtest/gtest.h>

#include <cmath>

#include "host/mesh/geodesic.h"
#include "host/mesh/vectors.h"

namespace malha {
namespace {

void expect_place(const Vec3& found, const Vec3& wanted) {
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(found[k], wanted[k], 1e-14) << "coordinate " << k;
}

/// Two triangles at the edge 0-1, with the points 2 and 3 beyond it.
Mesh two_triangles() {
  return {{{0, 0, 0}, {0, 1, 0}, {-1, 0.5, 0.3}, {1, 0.5, 0.3}}, {{0, 1, 2, -1}, {1, 0, 3, -1}}, {}, {}};
}

/// Their pattern: the second triangle lies apart, turned by a quarter, and as large as `scale` says.
Mesh apart(double scale = 1) {
  return {{{0, 0, 0}, {0, 1, 0}, {-1, 0.25, 0}, {5, 5, 0}, {5 + scale, 5, 0}, {5 + 0.25 * scale, 5 + 2 * scale, 0}},
          {{0, 1, 2, -1}, {4, 3, 5, -1}},
          {},
          {}};
}

TEST(RestShape, WithoutARestMeshIsTheMesh) {
  const Mesh mesh = two_triangles();
  const RestShape shape(mesh);
  EXPECT_FALSE(shape.has_seams());
  const int hinge[] = {0, 1, 2, 3};
  Vec3 X[4];
  shape.corners(Element::Hinges, hinge, X);
  for (int j = 0; j < 4; ++j) EXPECT_EQ(X[j], mesh.points[hinge[j]]);
  EXPECT_EQ(shape.squared_length(0, 2), squared_distance(mesh.points[0], mesh.points[2]));
}

TEST(RestShape, UnfoldsTheNeighbourBeyondASeam) {
  const Mesh mesh = two_triangles(), rest = apart();
  const RestShape shape(mesh, &rest);
  ASSERT_TRUE(shape.has_seams());
  const int hinge[] = {0, 1, 2, 3};
  Vec3 X[4];
  shape.corners(Element::Hinges, hinge, X);
  expect_place(X[0], {0, 0, 0}), expect_place(X[1], {0, 1, 0}), expect_place(X[2], {-1, 0.25, 0});
  expect_place(X[3], {2, 0.25, 0});  // a quarter along the edge from point 0, two beyond it
  const int from_beyond[] = {1, 0, 3, 2};
  shape.corners(Element::Hinges, from_beyond, X);
  expect_place(X[0], {6, 5, 0}), expect_place(X[1], {5, 5, 0}), expect_place(X[2], {5.25, 7, 0});
  expect_place(X[3], {5.25, 4, 0});
}

/// The neighbour's corner of the hinge between the two triangles, by their pattern `rest`.
Vec3 neighbour_at(const Mesh& rest) {
  const Mesh mesh = two_triangles();
  const int hinge[] = {0, 1, 2, 3};
  Vec3 X[4];
  RestShape(mesh, &rest).corners(Element::Hinges, hinge, X);
  return X[3];
}

TEST(RestShape, MirroredNeighbourIsUnfoldedAlike) {
  Mesh rest = apart();
  rest.points[5][1] = 3;  // on the other side of its edge
  expect_place(neighbour_at(rest), {2, 0.25, 0});
}

TEST(RestShape, NeighbourFoldedOntoTheTriangleIsUnfolded) {
  Mesh rest = apart();
  rest.points[5] = {-2, 0.75, 0}, rest.faces[1] = {1, 0, 5, -1};  // at the same edge, on the same side
  expect_place(neighbour_at(rest), {2, 0.75, 0});
}

TEST(RestShape, NeighbourAtTheSameEdgeKeepsItsAngle) {
  Mesh rest = apart();
  rest.points[5] = {0, 0.75, 2}, rest.faces[1] = {1, 0, 5, -1};
  EXPECT_EQ(neighbour_at(rest), rest.points[5]);
}

TEST(RestShape, EdgeOfASeamHasTheMeanOfItsLengths) {
  const Mesh mesh = two_triangles(), rest = apart(1.5);
  const RestShape shape(mesh, &rest);
  EXPECT_NEAR(shape.length(0, 1), 1.25, 1e-15);
  EXPECT_NEAR(shape.squared_length(1, 0), 1.25 * 1.25, 1e-15);
  EXPECT_NEAR(shape.length(1, 3), 1.5 * std::hypot(0.75, 2), 1e-14) << "of the other side alone";
  const int ends[] = {0, 1};
  Vec3 X[2];
  shape.corners(Element::Edges, ends, X);
  expect_place(X[0], {0, 0, 0}), expect_place(X[1], {0, 1.25, 0});
  EXPECT_NEAR(shape.area(0, 1, 3), 1.5 * 1.5, 1e-14);
  const Ease ease = largest_ease(shape);
  EXPECT_NEAR(ease.most, 0.5, 1e-14);
  EXPECT_EQ(std::minmax(ease.at[0], ease.at[1]), std::minmax(0, 1));
}

TEST(RestShape, GeodesicsCrossSeamsStraight) {
  const Mesh mesh = two_triangles(), rest = apart();
  const Geodesics found = geodesics(RestShape(mesh, &rest), {2});
  EXPECT_NEAR(found.distance[3], 3, 1e-12) << "straight across, a quarter along the edge";
  EXPECT_NEAR(found.distance[1], std::hypot(1, 0.75), 1e-12);
}

TEST(RestShape, DiagonalsAreThoseOfTheirQuad) {
  const Mesh mesh{
      {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 0, 0}, {2, 1, 0}}, {{0, 1, 2, 3}, {1, 4, 5, 2}}, {}, {}};
  const Mesh rest{{{0, 0, 0}, {3, 0, 0}, {3, 4, 0}, {0, 4, 0}, {9, 9, 0}, {12, 9, 0}, {12, 13, 0}, {9, 13, 0}},
                  {{0, 1, 2, 3}, {4, 5, 6, 7}},
                  {},
                  {}};
  const RestShape shape(mesh, &rest);
  EXPECT_NEAR(shape.length(0, 2), 5, 1e-15);
  EXPECT_NEAR(shape.length(4, 2), 5, 1e-15);
  const int plate[] = {1, 2, 3, 0, 0, 0};  // the half 1 2 3, with a wing in its own quad at every side
  Vec3 X[6];
  shape.corners(Element::WingedTriangles, plate, X);
  EXPECT_EQ(X[3 + 1], rest.points[0]) << "beyond the diagonal from 3 to 1";
}

}  // namespace
}  // namespace malha
