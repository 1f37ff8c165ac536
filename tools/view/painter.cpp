// SPDX-License-Identifier: Apache-2.0
#include "tools/view/painter.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "host/attachments/object_motion.h"
#include "host/mesh/topology.h"
#include "host/render/picture.h"
#include "host/render/stage.h"
#include "tools/view/shaders.h"

namespace malha::view {

namespace {

enum Attribute : GLuint { kPosition, kNormal, kColour };
const Eigen::Vector3d kSun = Eigen::Vector3d(0.45, 0.8, 0.4).normalized();

void attribute(GLuint place, const Buffer& buffer, GLenum type) {
  buffer.bind(GL_ARRAY_BUFFER);
  glEnableVertexAttribArray(place);
  glVertexAttribPointer(place, 3, type, type == GL_UNSIGNED_BYTE ? GL_TRUE : GL_FALSE, 0, nullptr);
}

Eigen::Matrix4d matrix_of(const Pose& pose) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  if (!pose.moves) return matrix;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) matrix(i, j) = pose.r[3 * i + j];
  matrix(0, 3) = pose.t.x, matrix(1, 3) = pose.t.y, matrix(2, 3) = pose.t.z;
  return matrix;
}

/// Computes vertex normals as area-weighted means over the triangles around each point.
void mean_normals(const std::vector<Point3f>& x, const std::vector<std::array<unsigned, 3>>& triangles,
                  std::vector<Point3f>& normals) {
  normals.assign(x.size(), {0, 0, 0});
  for (const auto& t : triangles) {
    const Eigen::Vector3f a(x[t[0]].data()), b(x[t[1]].data()), c(x[t[2]].data());
    const Eigen::Vector3f n = (b - a).cross(c - a);
    for (const unsigned i : t)
      for (int k = 0; k < 3; ++k) normals[i][k] += n[k];
  }
}

}  // namespace

struct Painter::Programs {
  Program surface{kSurfaceVertex, kSurfaceFragment}, depth{kPlainVertex, kDepthFragment},
      plain{kPlainVertex, kPlainFragment}, balls{kPlainVertex, kBallFragment};
  ShadowMap shadow;
};

/// GPU buffers of points that are drawn as faces, lines or balls.
struct Painter::Shapes {
  VertexArray array;
  Buffer x, normals, colours, triangles, edges, loose;
  GLsizei triangle_count = 0, edge_count = 0, loose_count = 0, count = 0;

  Shapes() {
    array.bind();
    attribute(kPosition, x, GL_FLOAT), attribute(kNormal, normals, GL_FLOAT);
    attribute(kColour, colours, GL_UNSIGNED_BYTE);
  }
  void draw(GLenum mode, const Buffer& elements, GLsizei numbers) const {
    array.bind();
    elements.bind(GL_ELEMENT_ARRAY_BUFFER);
    glDrawElements(mode, numbers, GL_UNSIGNED_INT, nullptr);
  }
  void draw_all(GLenum mode) const {
    array.bind();
    glDrawArrays(mode, 0, count);
  }
};

/// GPU buffers of an environment object.
struct Painter::Obstacle {
  VertexArray array;
  Buffer x, normals;
  GLsizei count = 0;
  const EnvironmentMesh& object;
  std::vector<Triangle> faces;
  double time = NAN;  // of the buffers of an object that deforms, s

  explicit Obstacle(const EnvironmentMesh& mesh) : object(mesh), faces(triangles(mesh.mesh)) {
    array.bind();
    attribute(kPosition, x, GL_FLOAT), attribute(kNormal, normals, GL_FLOAT);
    count = GLsizei(3 * faces.size());
    if (!deforms(object)) fill(object.mesh.points, GL_STATIC_DRAW);
  }
  /// Moves the vertices of an object that deforms to a time (s).
  void move(double to) {
    if (!deforms(object) || to == time) return;
    fill(points_at(object, to), GL_STREAM_DRAW), time = to;
  }
  /// The pose of the buffers at a time (s).
  Pose pose(double at) const { return deforms(object) ? Pose{} : pose_at(object.spec.motion, at); }
  void fill(const std::vector<Vec3>& at, GLenum use) {
    std::vector<Point3f> points, corners;
    for (const Vec3& p : at) points.push_back(to_point3f(p));
    for (const Triangle& t : faces)
      for (const int i : t) corners.push_back(points[i]);
    array.bind();
    x.fill(GL_ARRAY_BUFFER, corners, use), normals.fill(GL_ARRAY_BUFFER, corner_normals(points, faces), use);
  }
  void draw() const {
    array.bind();
    const std::array<float, 3> grey = stone_colour();
    glVertexAttrib3f(kColour, grey[0], grey[1], grey[2]);
    glDrawArrays(GL_TRIANGLES, 0, count);
  }
};

Painter::Painter()
    : programs_(std::make_unique<Programs>()), body_(std::make_unique<Shapes>()), marks_(std::make_unique<Shapes>()) {}
Painter::~Painter() = default;

void Painter::update(const Picture& picture) {
  const Frame& frame = *picture.frame;
  const DecimatedMesh* const decimated = picture.decimated && frame.body->decimated ? &*frame.body->decimated : nullptr;
  const auto& triangles = decimated ? decimated->triangles : frame.body->triangles;
  if (frame.body != built_ || decimated_ != (decimated != nullptr)) {
    built_ = frame.body, decimated_ = decimated != nullptr;
    const auto fill = [&](Buffer& buffer, const auto& list, GLsizei& numbers, int each) {
      body_->array.bind();
      buffer.fill(GL_ELEMENT_ARRAY_BUFFER, list, GL_STATIC_DRAW);
      numbers = GLsizei(list.size()) * each;
    };
    fill(body_->triangles, triangles, body_->triangle_count, 3);
    fill(body_->edges, decimated ? decimated->edges : built_->edges, body_->edge_count, 2);
    fill(body_->loose, decimated ? std::vector<unsigned>() : built_->loose, body_->loose_count, 1);
  }
  const auto chosen = [&]<class T>(const std::vector<T>& all) {
    std::vector<T> some;
    for (const unsigned i : decimated->particles) some.push_back(all[i]);
    return some;
  };
  if (decimated)
    show(chosen(frame.x), chosen(picture.colours), triangles);
  else
    show(frame.x, picture.colours, triangles);
}

void Painter::show(const std::vector<Point3f>& x, const std::vector<Colour>& colours,
                   const std::vector<std::array<unsigned, 3>>& triangles) {
  body_->array.bind();
  body_->x.fill(GL_ARRAY_BUFFER, x, GL_STREAM_DRAW);
  body_->colours.fill(GL_ARRAY_BUFFER, colours, GL_STREAM_DRAW);
  body_->count = GLsizei(x.size());
  smooth_ = triangles.size() <= kManyTriangles;
  if (smooth_) mean_normals(x, triangles, normals_);
  normals_.resize(x.size());
  body_->normals.fill(GL_ARRAY_BUFFER, normals_, GL_STREAM_DRAW);
}

void Painter::update_environment(const Frame& frame) {
  if (frame.environment != environment_) {
    obstacles_.clear();
    environment_ = frame.environment;
    for (const EnvironmentMesh& mesh : *environment_) obstacles_.emplace_back(mesh);
  }
  for (Obstacle& one : obstacles_) one.move(frame.time);
}

/// Returns the matrix of the light, whose view contains the bodies.
Eigen::Matrix4d Painter::light(const Frame& frame) const {
  Eigen::AlignedBox3d box;
  for (const Point3f& x : frame.x)
    if (std::isfinite(x[0] + x[1] + x[2])) box.extend(Eigen::Vector3d(x[0], x[1], x[2]));
  if (box.isEmpty()) box.extend(Eigen::Vector3d::Zero());
  const double radius = std::max(0.75 * box.diagonal().norm(), 1e-3);
  const Eigen::Vector3d right = kSun.unitOrthogonal(), up = kSun.cross(right);
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.block<1, 3>(0, 0) = right.transpose() / radius, matrix.block<1, 3>(1, 0) = up.transpose() / radius;
  matrix.block<1, 3>(2, 0) = -kSun.transpose() / (2 * radius);
  matrix.block<3, 1>(0, 3) = -matrix.block<3, 3>(0, 0) * box.center();
  return matrix;
}

void Painter::draw_surfaces(const Picture& picture, const Program& program) const {
  program.set("place", Eigen::Matrix4d(Eigen::Matrix4d::Identity()));
  if (picture.surface == Surface::Shaded) body_->draw(GL_TRIANGLES, body_->triangles, body_->triangle_count);
  program.set("faceted", 0);
  for (const Obstacle& one : obstacles_) {
    program.set("place", matrix_of(one.pose(picture.frame->time)));
    one.draw();
  }
}

void Painter::draw_lines_and_balls(const Picture& picture, const OrbitCamera& camera, const Viewport& port) const {
  const Eigen::Matrix4d whole = camera.projection(port.aspect()) * camera.view();
  const Eigen::Matrix4d here = Eigen::Matrix4d::Identity();
  const auto begin = [&](const Program& program) {
    program.use();
    program.set("place", here), program.set("camera", whole);
  };
  begin(programs_->plain);
  programs_->plain.set("size", 1.0f);
  const bool few = body_->edge_count < 40'000;
  programs_->plain.set("shade", picture.surface == Surface::Wireframe || body_->triangle_count == 0 ? 1.0f : 0.72f);
  if (picture.surface == Surface::Wireframe || body_->triangle_count == 0 ||
      (few && picture.surface == Surface::Shaded))
    body_->draw(GL_LINES, body_->edges, body_->edge_count);
  const auto draw_marks = [this](const std::vector<Point3f>& x, const std::vector<Colour>& colours, GLenum mode) {
    marks_->array.bind();
    marks_->x.fill(GL_ARRAY_BUFFER, x, GL_STREAM_DRAW);
    marks_->colours.fill(GL_ARRAY_BUFFER, colours, GL_STREAM_DRAW);
    marks_->normals.fill(GL_ARRAY_BUFFER, x, GL_STREAM_DRAW);  // unused, but the buffer must have as many elements
    marks_->count = GLsizei(x.size());
    marks_->draw_all(mode);
  };
  programs_->plain.set("shade", 1.0f);
  draw_marks(picture.marks.lines, picture.marks.line_colours, GL_LINES);

  begin(programs_->balls);
  const double metre = 1 / camera.metres_per_pixel(port, 1);  // pixels a metre at a distance of 1 m
  const double wider = decimated_ ? std::sqrt(double(built_->mesh.points.size()) / double(body_->count)) : 1;
  const double spacing = built_->spacing > 0 ? wider * built_->spacing : 0.01 * camera.distance();
  programs_->balls.set("size", float(0.5 * spacing * metre));
  if (picture.surface == Surface::Particles)
    body_->draw_all(GL_POINTS);
  else
    body_->draw(GL_POINTS, body_->loose, body_->loose_count);
  programs_->balls.set("size", float(9 * camera.distance()));  // the same size in pixels at any distance
  glDepthFunc(GL_ALWAYS);
  draw_marks(picture.marks.balls, picture.marks.ball_colours, GL_POINTS);
  glDepthFunc(GL_LEQUAL);
}

void Painter::draw(const Picture& picture, const OrbitCamera& camera, const Viewport& port, int window_height) {
  update(picture), update_environment(*picture.frame);
  glEnable(GL_DEPTH_TEST), glDepthFunc(GL_LEQUAL), glEnable(GL_PROGRAM_POINT_SIZE), glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE), glDisable(GL_SCISSOR_TEST);
  const Eigen::Matrix4d sun = light(*picture.frame);
  if (smooth_) {
    programs_->shadow.begin();
    programs_->depth.use();
    programs_->depth.set("camera", sun), programs_->depth.set("size", 1.0f);
    draw_surfaces(picture, programs_->depth);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
  }
  const int bottom = window_height - port.top - port.height;
  glViewport(port.left, bottom, port.width, port.height);
  const Program& program = programs_->surface;
  program.use();
  programs_->shadow.bind();
  program.set("camera", Eigen::Matrix4d(camera.projection(port.aspect()) * camera.view()));
  program.set("light", sun), program.set("eye", camera.eye()), program.set("sun", kSun);
  program.set("shadow", 0), program.set("shadowed", smooth_ ? 1 : 0), program.set("faceted", smooth_ ? 0 : 1);
  glEnable(GL_POLYGON_OFFSET_FILL);
  glPolygonOffset(1, 1);
  draw_surfaces(picture, program);
  glDisable(GL_POLYGON_OFFSET_FILL);
  draw_lines_and_balls(picture, camera, port);
}

Image read_back(int width, int height) {
  Image image{width, height, std::vector<unsigned char>(3 * std::size_t(width) * height)};
  std::vector<unsigned char> rows(image.pixels.size());
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, rows.data());
  const std::size_t row = 3 * std::size_t(width);
  for (int y = 0; y < height; ++y)
    std::copy_n(rows.begin() + std::ptrdiff_t(row * (height - 1 - y)), row,
                image.pixels.begin() + std::ptrdiff_t(row * y));
  return image;
}

}  // namespace malha::view
