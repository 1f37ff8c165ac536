// SPDX-License-Identifier: Apache-2.0
// OpenGL objects that free themselves.
#pragma once
#include <epoxy/gl.h>

#include <Eigen/Core>
#include <string>

namespace malha::view {

/// A shader program. Throws std::runtime_error with what the driver says.
class Program {
 public:
  Program(const std::string& vertex, const std::string& fragment);
  ~Program() { glDeleteProgram(id_); }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  void use() const { glUseProgram(id_); }
  void set(const char* name, const Eigen::Matrix4d& matrix) const;
  void set(const char* name, const Eigen::Vector3d& vector) const;
  void set(const char* name, float number) const { glUniform1f(place(name), number); }
  void set(const char* name, int number) const { glUniform1i(place(name), number); }

 private:
  GLint place(const char* name) const { return glGetUniformLocation(id_, name); }
  GLuint id_;
};

/// Of vertices or indices.
class Buffer {
 public:
  Buffer() { glGenBuffers(1, &id_); }
  ~Buffer() { glDeleteBuffers(1, &id_); }
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;

  template <class List>
  void fill(GLenum target, const List& list, GLenum usage) {
    glBindBuffer(target, id_);
    glBufferData(target, GLsizeiptr(list.size() * sizeof(list[0])), list.data(), usage);
  }
  void bind(GLenum target) const { glBindBuffer(target, id_); }

 private:
  GLuint id_ = 0;
};

/// Where the vertex attributes come from.
class VertexArray {
 public:
  VertexArray() { glGenVertexArrays(1, &id_); }
  ~VertexArray() { glDeleteVertexArrays(1, &id_); }
  VertexArray(const VertexArray&) = delete;
  VertexArray& operator=(const VertexArray&) = delete;
  void bind() const { glBindVertexArray(id_); }

 private:
  GLuint id_ = 0;
};

/// Depths as a light sees them.
class ShadowMap {
 public:
  static constexpr int kSide = 2048;  // pixels
  ShadowMap();
  ~ShadowMap();
  ShadowMap(const ShadowMap&) = delete;
  ShadowMap& operator=(const ShadowMap&) = delete;
  void begin() const;
  void bind() const;

 private:
  GLuint texture_ = 0, frame_ = 0;
};

}  // namespace malha::view
