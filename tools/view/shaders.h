// SPDX-License-Identifier: Apache-2.0
// Shaders (GLSL 3.30). Input and output colours are sRGB, lighting is linear.
#pragma once

namespace malha::view {

inline constexpr const char* kSurfaceVertex = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 colour;
uniform mat4 place, camera, light;
out vec3 world, across, tint;
out vec4 lit;
void main() {
  vec4 at = place * vec4(position, 1);
  world = at.xyz, across = mat3(place) * normal, tint = pow(colour, vec3(2.2));
  lit = light * at;
  gl_Position = camera * at;
})";

/// Lights surfaces by a hemisphere of sky and a sun with a shadow, on both sides alike.
inline constexpr const char* kSurfaceFragment = R"(#version 330 core
in vec3 world, across, tint;
in vec4 lit;
uniform vec3 eye, sun;
uniform sampler2DShadow shadow;
uniform int faceted, shadowed;
out vec4 colour;
void main() {
  vec3 n = faceted != 0 ? cross(dFdx(world), dFdy(world)) : across;
  n = normalize(n);
  vec3 to_eye = normalize(eye - world);
  if (dot(n, to_eye) < 0) n = -n;
  float facing = max(dot(n, sun), 0), seen = 1;
  if (shadowed != 0) {
    vec3 at = 0.5 * lit.xyz / lit.w + 0.5;
    at.z -= 0.0015 + 0.003 * (1 - facing);
    seen = 0;
    float texel = 1.0 / textureSize(shadow, 0).x;
    for (int i = -1; i <= 1; ++i)
      for (int j = -1; j <= 1; ++j) seen += texture(shadow, at + texel * vec3(i, j, 0)) / 9;
  }
  float sky = 0.42 + 0.13 * n.y, rim = 0.06 * dot(n, to_eye);
  float shine = pow(max(dot(n, normalize(to_eye + sun)), 0), 40) * 0.08 * seen;
  vec3 light = tint * (sky + rim + 0.62 * facing * seen) + shine;
  colour = vec4(pow(light, vec3(1 / 2.2)), 1);
})";

inline constexpr const char* kPlainVertex = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 2) in vec3 colour;
uniform mat4 place, camera;
uniform float size;
out vec3 tint;
void main() {
  tint = colour;
  gl_Position = camera * (place * vec4(position, 1));
  gl_PointSize = max(size / gl_Position.w, 2.0);
})";

inline constexpr const char* kPlainFragment = R"(#version 330 core
in vec3 tint;
uniform float shade;
out vec4 colour;
void main() { colour = vec4(tint * shade, 1); })";

/// Draws points as balls.
inline constexpr const char* kBallFragment = R"(#version 330 core
in vec3 tint;
out vec4 colour;
void main() {
  vec2 at = 2 * gl_PointCoord - 1;
  float square = dot(at, at);
  if (square > 1) discard;
  colour = vec4(tint * (0.55 + 0.45 * sqrt(1 - square) - 0.15 * at.y), 1);
})";

inline constexpr const char* kDepthFragment = R"(#version 330 core
void main() {})";

}  // namespace malha::view
