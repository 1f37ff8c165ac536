// SPDX-License-Identifier: Apache-2.0
// Fields of pins, attachments and tearing.
#include <limits>

#include "host/scene/scene_fields.h"

namespace malha {

static Fields fields_of(BoxPin& box) { return box_fields(box.min, box.max); }
static void check(const JsonReader& at, const BoxPin& box) { check_box(at, box.min, box.max); }

static Fields fields_of(SpherePin& sphere) {
  return {required(field("center", sphere.center, any("m"))), required(field("radius", sphere.radius, above(0, "m")))};
}

Fields fields_of(Tear& tear) { return {required(field("strain", tear.strain, above(0, "")))}; }

namespace {

Field row_field(Selector& to, const Shape& shape) {
  const auto read = [&](const JsonReader& at) {
    to = RowPin{at.choice("row", {"first", "last"}) == "last"};
    const auto* file = std::get_if<MeshFile>(&shape);
    const bool was_refused = file != nullptr && file->path.empty();
    if (!was_refused && !std::holds_alternative<GridShape>(shape) && !std::holds_alternative<ChainShape>(shape))
      at.refuse("a row of a shape that has no rows", "rows of a grid or a chain");
  };
  return {"row", read, false, [&to](JsonValue& json) {
            if (const auto* row = std::get_if<RowPin>(&to)) json["row"] = row->last ? "last" : "first";
          }};
}

/// "all", or a point.
Field rim_field(Selector& to) {
  const auto read = [&to](const JsonReader& at) {
    RimPin rim;
    if (at.value().is_string())
      at.choice("rim", {"all"});
    else if (at.value().is_array())
      read_into(rim.nearest, at, any("m"));
    else
      at.refuse_value("\"all\", or a point (m) to which one line of the boundary is the nearest");
    to = rim;
  };
  return {"rim", read, false, [&to](JsonValue& json) {
            if (const auto* rim = std::get_if<RimPin>(&to))
              json["rim"] = rim->nearest ? JsonValue(*rim->nearest) : JsonValue("all");
          }};
}

}  // namespace

Fields selectors(Selector& to, const Shape& shape) {
  const Integers numbers{0, std::numeric_limits<int>::max()};
  return {row_field(to, shape),
          alternative<BoxPin>("box", to),
          alternative<SpherePin>("sphere", to),
          alternative("nearest", to, &NearestPin::point, any("m")),
          checked(alternative("particles", to, &ListPin::particles, numbers),
                  [](const JsonReader& at) {
                    if (at.list().empty()) at.refuse_value("a list of particle numbers, from 0");
                  }),
          rim_field(to)};
}

namespace {

/// The motion of particles from their positions at the start. The first keyframe must be the identity, otherwise they
/// would jump.
Field motion_from_start(std::vector<Keyframe>& motion) {
  const auto check_first = [&motion](const JsonReader& at) {
    if (!motion.empty() && (motion.front().translate != Vec3{0, 0, 0} || motion.front().degrees != 0))
      at.list().front().refuse("a first keyframe that moves the particles", "one without translate and rotate");
  };
  return written_if(!motion.empty(), checked(motion_field(motion), check_first));
}

Field release_field(std::optional<double>& release_time) { return field("release_time", release_time, above(0, "s")); }

Fields pin_options(Pin& pin) { return {motion_from_start(pin.motion), release_field(pin.release_time)}; }

Fields target_fields(Attachment& attachment) {
  return {written_if(!attachment.environment.empty(), field("environment", attachment.environment)),
          field("point", attachment.point, any("m"))};
}

Fields fields_of(Attachment& attachment, const Shape& shape) {
  return {
      {"at", [&](const JsonReader& at) { at.one_of(selectors(attachment.at, shape)); }, true,
       [&](JsonValue& json) { json["at"] = write(selectors(attachment.at, shape)); }},
      written_if(!attachment.environment.empty() || attachment.point,
                 {"to", [&](const JsonReader& at) { at.one_of(target_fields(attachment)); }, false,
                  [&](JsonValue& json) { json["to"] = write(target_fields(attachment)); }}),
      checked(motion_from_start(attachment.motion),
              [&](const JsonReader& at) {
                if (!attachment.environment.empty())
                  at.refuse("'motion' of an attachment to an environment object", "the 'motion' of that object");
              }),
      written_if(!attachment.compliance, field("stiffness", attachment.stiffness, between(0, 1, ""))),
      field("compliance", attachment.compliance, at_least(0, "m/N")),
      release_field(attachment.release_time),
  };
}

/// Reads a list only where the shape of the body has been read, because pins by rows depend on it.
Field if_shaped(const BodySpec& body, Field of) {
  of.read = [&body, read = of.read](const JsonReader& at) {
    const auto* const file = std::get_if<MeshFile>(&body.shape);
    if (!file || !file->path.empty()) read(at);
  };
  return of;
}

}  // namespace

Field pins_field(BodySpec& body) {
  const auto read_one = [&body](const JsonReader& at) {
    Pin pin;
    at.one_of(selectors(pin.at, body.shape), pin_options(pin));
    return pin;
  };
  const auto write_one = [&body](Pin& pin) {
    JsonValue json = write(selectors(pin.at, body.shape));
    json.update(write(pin_options(pin)));
    return json;
  };
  return if_shaped(body, list("pins", body.pins, read_one, write_one));
}

Field attachments_field(BodySpec& body) {
  const auto read_one = [&body](const JsonReader& at) {
    Attachment attachment;
    at.object(fields_of(attachment, body.shape));
    if (attachment.compliance && at.has("stiffness"))
      at.at("compliance").refuse("both 'stiffness' and 'compliance'", "one of them");
    return attachment;
  };
  const auto write_one = [&body](Attachment& one) { return write(fields_of(one, body.shape)); };
  return written_if(!body.attachments.empty(),
                    if_shaped(body, list("attachments", body.attachments, read_one, write_one)));
}

}  // namespace malha
