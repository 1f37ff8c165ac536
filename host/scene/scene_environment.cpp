// SPDX-License-Identifier: Apache-2.0
#include "host/scene/scene_read.h"

namespace malha {
namespace {

Sides read_sides(const JsonReader& at) {
  const std::string sides = at.choice("value of sides", {"solid", "one_sided", "two_sided"});
  if (sides == "one_sided") return Sides::OneSided;
  return sides == "two_sided" ? Sides::TwoSided : Sides::Solid;
}

Keyframe read_keyframe(const JsonReader& at) {
  Keyframe key;
  at.object({
      {"time", [&](const JsonReader& v) { key.time = v.number(at_least(0, "s")); }, true},
      {"translate", [&](const JsonReader& v) { key.translate = v.vec3(any("m")); }},
      {"rotate", [&](const JsonReader& v) { read_rotation(v, key.axis, key.degrees); }},
  });
  return key;
}

}  // namespace

std::vector<Keyframe> read_motion(const JsonReader& at) {
  std::vector<Keyframe> motion;
  for (const JsonReader& item : at.list()) {
    const Keyframe key = read_keyframe(item);
    if (!motion.empty() && key.time <= motion.back().time) {
      item.at("time").refuse_value("a time after that of the keyframe before it (s)");
    }
    motion.push_back(key);
  }
  return motion;
}

EnvironmentSpec read_environment(const JsonReader& at, const std::string& folder) {
  EnvironmentSpec object;
  object.thickness = 0;  // the default, see EnvironmentSpec
  at.object({
      {"name", [&](const JsonReader& v) { object.name = read_name(v); }, true},
      {"shape", [&](const JsonReader& v) { object.shape = read_shape(v, ShapeUse::Environment, folder); }, true},
      {"transform", [&](const JsonReader& v) { object.transform = read_transform(v); }},
      {"sides", [&](const JsonReader& v) { object.sides = read_sides(v); }},
      {"start_inside",
       [&](const JsonReader& v) {
         object.push_out = v.choice("start_inside", {"refuse", "push_out"}) == "push_out";
       }},
      {"thickness", [&](const JsonReader& v) { object.thickness = v.number(above(0, "m")); }},
      {"friction", [&](const JsonReader& v) { object.friction = v.number(at_least(0, "")); }},
      {"restitution", [&](const JsonReader& v) { object.restitution = v.number(between(0, 1, "")); }},
      {"edges", [&](const JsonReader& v) { object.edges = v.boolean(); }},
      {"motion", [&](const JsonReader& v) { object.motion = read_motion(v); }},
  });
  if (at.has("start_inside") && object.sides != Sides::Solid)
    at.at("start_inside").refuse("'start_inside' of a sheet, which has no inside", "\"sides\": \"solid\" beside it");
  return object;
}

}  // namespace malha
