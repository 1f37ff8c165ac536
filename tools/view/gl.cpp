// SPDX-License-Identifier: Apache-2.0
#include "tools/view/gl.h"

#include <stdexcept>

namespace malha::view {

namespace {

GLuint compiled(GLenum kind, const std::string& source) {
  const GLuint id = glCreateShader(kind);
  const char* text = source.c_str();
  glShaderSource(id, 1, &text, nullptr);
  glCompileShader(id);
  GLint good = 0;
  glGetShaderiv(id, GL_COMPILE_STATUS, &good);
  if (good) return id;
  std::string log(4096, '\0');
  GLsizei length = 0;
  glGetShaderInfoLog(id, GLsizei(log.size()), &length, log.data());
  throw std::runtime_error("OpenGL: a shader does not compile: " + log.substr(0, std::size_t(length)));
}

}  // namespace

Program::Program(const std::string& vertex, const std::string& fragment) : id_(glCreateProgram()) {
  for (const GLuint shader : {compiled(GL_VERTEX_SHADER, vertex), compiled(GL_FRAGMENT_SHADER, fragment)}) {
    glAttachShader(id_, shader);
    glDeleteShader(shader);
  }
  glLinkProgram(id_);
  GLint good = 0;
  glGetProgramiv(id_, GL_LINK_STATUS, &good);
  if (!good) throw std::runtime_error("OpenGL: the shaders do not link");
}

void Program::set(const char* name, const Eigen::Matrix4d& matrix) const {
  const Eigen::Matrix4f numbers = matrix.cast<float>();
  glUniformMatrix4fv(place(name), 1, GL_FALSE, numbers.data());
}
void Program::set(const char* name, const Eigen::Vector3d& vector) const {
  const Eigen::Vector3f numbers = vector.cast<float>();
  glUniform3fv(place(name), 1, numbers.data());
}

ShadowMap::ShadowMap() {
  glGenTextures(1, &texture_);
  glBindTexture(GL_TEXTURE_2D, texture_);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, kSide, kSide, 0, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_BORDER);
  const float lit[] = {1, 1, 1, 1};
  glTexParameterfv(GL_TEXTURE_2D, GL_TEXTURE_BORDER_COLOR, lit);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
  glGenFramebuffers(1, &frame_);
  glBindFramebuffer(GL_FRAMEBUFFER, frame_);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, texture_, 0);
  glDrawBuffer(GL_NONE), glReadBuffer(GL_NONE);
  const bool whole = glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  if (!whole) throw std::runtime_error("OpenGL: the driver cannot draw into a depth texture");
}

ShadowMap::~ShadowMap() {
  glDeleteFramebuffers(1, &frame_);
  glDeleteTextures(1, &texture_);
}

void ShadowMap::begin() const {
  glBindFramebuffer(GL_FRAMEBUFFER, frame_);
  glViewport(0, 0, kSide, kSide);
  glClear(GL_DEPTH_BUFFER_BIT);
}

void ShadowMap::bind() const {
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, texture_);
}

}  // namespace malha::view
