// SPDX-License-Identifier: Apache-2.0
// Readers of pins, attachments and tearing.
#include <limits>

#include "host/scene/scene_read.h"

namespace malha {
namespace {

SpherePin read_sphere_pin(const JsonReader& at) {
  SpherePin sphere;
  at.object({
      {"center", [&](const JsonReader& v) { sphere.center = v.vec3(any("m")); }, true},
      {"radius", [&](const JsonReader& v) { sphere.radius = v.number(above(0, "m")); }, true},
  });
  return sphere;
}

ListPin read_list_pin(const JsonReader& at) {
  ListPin pin;
  for (const JsonReader& item : at.list()) {
    pin.particles.push_back(item.integer(0, std::numeric_limits<int>::max()));
  }
  if (pin.particles.empty()) at.refuse_value("a list of particle numbers, from 0");
  return pin;
}

RowPin read_row_pin(const JsonReader& at, const Shape& shape) {
  const RowPin pin{at.choice("row", {"first", "last"}) == "last"};
  if (!std::holds_alternative<GridShape>(shape) && !std::holds_alternative<ChainShape>(shape)) {
    at.refuse("a row of a shape that has no rows", "rows of a grid or a chain");
  }
  return pin;
}

std::vector<JsonReader::Field> selectors(Selector& to, const Shape& shape) {
  return {
      {"row", [&](const JsonReader& v) { to = read_row_pin(v, shape); }},
      {"box",
       [&](const JsonReader& v) {
         BoxPin box;
         read_box(v, box.min, box.max);
         to = box;
       }},
      {"sphere", [&](const JsonReader& v) { to = read_sphere_pin(v); }},
      {"nearest", [&](const JsonReader& v) { to = NearestPin{v.vec3(any("m"))}; }},
      {"particles", [&](const JsonReader& v) { to = read_list_pin(v); }},
  };
}

/// Reads the motion of particles from their positions at the start. The first keyframe must be the identity, otherwise
/// they would jump.
std::vector<Keyframe> read_motion_from_start(const JsonReader& at) {
  const std::vector<Keyframe> motion = read_motion(at);
  if (!motion.empty() && (motion.front().translate != Vec3{0, 0, 0} || motion.front().degrees != 0))
    at.list().front().refuse("a first keyframe that moves the particles", "one without translate and rotate");
  return motion;
}

JsonReader::Field release_field(std::optional<double>& release_time) {
  return {"release_time", [&](const JsonReader& v) { release_time = v.number(above(0, "s")); }};
}

void read_target(const JsonReader& at, Attachment& attachment) {
  at.one_of({
      {"environment", [&](const JsonReader& v) { attachment.environment = v.text(); }},
      {"point", [&](const JsonReader& v) { attachment.point = v.vec3(any("m")); }},
  });
}

}  // namespace

Pin read_pin(const JsonReader& at, const Shape& shape) {
  Pin pin;
  at.one_of(selectors(pin.at, shape), {{"motion", [&](const JsonReader& v) { pin.motion = read_motion_from_start(v); }},
                                       release_field(pin.release_time)});
  return pin;
}

Attachment read_attachment(const JsonReader& at, const Shape& shape) {
  Attachment attachment;
  at.object({
      {"at", [&](const JsonReader& v) { v.one_of(selectors(attachment.at, shape)); }, true},
      {"to", [&](const JsonReader& v) { read_target(v, attachment); }},
      {"motion",
       [&](const JsonReader& v) {
         attachment.motion = read_motion_from_start(v);
         if (!attachment.environment.empty())
           v.refuse("'motion' of an attachment to an environment object", "the 'motion' of that object");
       }},
      {"stiffness", [&](const JsonReader& v) { attachment.stiffness = v.number(between(0, 1, "")); }},
      {"compliance",
       [&](const JsonReader& v) {
         attachment.compliance = v.number(at_least(0, "m/N"));
         if (at.has("stiffness")) v.refuse("both 'stiffness' and 'compliance'", "one of them");
       }},
      release_field(attachment.release_time),
  });
  return attachment;
}

Tear read_tear(const JsonReader& at) {
  Tear tear;
  at.object({{"strain", [&](const JsonReader& v) { tear.strain = v.number(above(0, "")); }, true}});
  return tear;
}

}  // namespace malha
