// SPDX-License-Identifier: Apache-2.0
#include "host/scene/scene_fields.h"

namespace malha {

static Fields fields_of(Camera& camera) {
  return {required(field("eye", camera.eye, any("m"))), required(field("target", camera.target, any("m"))),
          field("fov_degrees", camera.fov_degrees, between(1, 170, "degrees"))};
}
static void check(const JsonReader& at, const Camera& camera) {
  if (camera.eye == camera.target) at.at("target").refuse("the same point as 'eye'", "another point");
}

static Fields fields_of(PageSpec& page) { return {field("max_megabytes", page.max_megabytes, between(2, 400, "MB"))}; }

namespace {

Fields frame_fields(OutputSpec& outputs) {
  return {required(field("every", outputs.every, Integers{0, max_steps})),
          required(choices("formats", "format", outputs.formats, kFrameFormats))};
}

Fields picture_fields(PictureSpec& picture, int& every) {
  constexpr int widest_picture = 16384;  // pixels
  return {field("every", every, Integers{0, max_steps}), field("size", picture.size, Integers{1, widest_picture}),
          part("camera", picture.camera)};
}

}  // namespace

Fields fields_of(OutputSpec& outputs) {
  const auto read_pictures = [&](const JsonReader& at) {
    PictureSpec picture;
    at.object(picture_fields(picture, outputs.picture_every));
    outputs.picture = picture;
  };
  const auto write_pictures = [&](JsonValue& json) {
    PictureSpec picture = outputs.picture.value_or(PictureSpec{});
    if (outputs.picture || outputs.picture_every > 0)
      json["pictures"] = write(picture_fields(picture, outputs.picture_every));
  };
  return {
      written_if(!outputs.formats.empty(),
                 {"frames", [&](const JsonReader& at) { at.object(frame_fields(outputs)); }, false,
                  [&](JsonValue& json) { json["frames"] = write(frame_fields(outputs)); }}),
      {"pictures", read_pictures, false, write_pictures},
      part("page", outputs.page),
      field("checkpoint_every", outputs.checkpoint_every, Integers{0, max_steps}),
  };
}

namespace {

/// A range: a number is the upper bound, an object has "at_least", "at_most" or both.
template <class Number, class Limits>
Field range_field(const std::string& key, Range& to, const std::string& number, const Limits& limits) {
  const auto read = [=, &to](const JsonReader& at) {
    std::optional<Number> least, most;
    if (at.value().is_number())
      read_into(most, at, limits);
    else if (at.value().is_object())
      at.object({field("at_least", least, limits), field("at_most", most, limits)});
    else
      at.refuse_value(number + ", or an object with at_least, at_most");
    if (!least && !most) at.refuse("an empty object", "at least one of at_least, at_most");
    if (least && most && *least > *most) at.at("at_most").refuse_value("a number not below that of 'at_least'");
    to.at_least = least, to.at_most = most;
  };
  const auto write = [&to, key](JsonValue& json) {
    if (to.at_least) json[key]["at_least"] = Number(*to.at_least);
    if (to.at_least && to.at_most) json[key]["at_most"] = Number(*to.at_most);
    if (!to.at_least && to.at_most) json[key] = Number(*to.at_most);
  };
  return {key, read, false, write};
}
Field number_range(const std::string& key, Range& to, const std::string& unit) {
  return range_field<double>(key, to, "a number >= 0", at_least(0, unit));
}
Field count_range(const std::string& key, Range& to) {
  return range_field<int>(key, to, "an integer >= 0", Integers{0, max_steps});
}

void read_box(const JsonReader& at, Vec3& min, Vec3& max) { at.object(box_fields(min, max)), check_box(at, min, max); }

Fields fields_of(ExpectOfBody& expect, const std::vector<std::string>& bodies) {
  const auto read_body = [&](const JsonReader& at) {
    expect.name = bodies.empty() ? at.text() : at.choice("body", bodies);
  };
  return {{"name", read_body, true, [&](JsonValue& json) { json["name"] = expect.name; }},
          {"bounds", [&](const JsonReader& at) { read_box(at, expect.bounds_min, expect.bounds_max); }, true,
           [&](JsonValue& json) { json["bounds"] = write(box_fields(expect.bounds_min, expect.bounds_max)); }}};
}

}  // namespace

Fields fields_of(Expect& expect, const std::vector<std::string>& bodies) {
  const auto read_body = [&](const JsonReader& at) {
    ExpectOfBody body;
    at.object(fields_of(body, bodies));
    for (const ExpectOfBody& earlier : expect.bodies)
      if (earlier.name == body.name) at.at("name").refuse_value("each body once");
    return body;
  };
  const auto write_body = [&](ExpectOfBody& body) { return write(fields_of(body, bodies)); };
  const auto require_one = [&](const JsonReader& at) {
    if (expect.bodies.empty()) at.refuse("no body", "at least one");
  };
  const auto read_bounds = [&](const JsonReader& at) {
    Vec3 min, max;
    read_box(at, min, max);
    expect.bounds_min = min, expect.bounds_max = max;
  };
  const auto write_bounds = [&](JsonValue& json) {
    if (expect.bounds_min && expect.bounds_max)
      json["bounds"] = write(box_fields(*expect.bounds_min, *expect.bounds_max));
  };
  return {
      number_range("max_strain", expect.max_strain, ""),
      number_range("rms_strain", expect.rms_strain, ""),
      number_range("max_penetration", expect.max_penetration, "m"),
      count_range("max_crossings", expect.max_crossings),
      field("energy_not_above", expect.energy_not_above, any("J")),
      field("energy_not_below", expect.energy_not_below, any("J")),
      number_range("max_speed", expect.max_speed, "m/s"),
      {"bounds", read_bounds, false, write_bounds},
      checked(written_if(!expect.bodies.empty(), list("bodies", expect.bodies, read_body, write_body)), require_one),
      checked(field("volume_ratio", expect.volume_ratio, above(0, "")),
              [&expect](const JsonReader& at) {
                if ((*expect.volume_ratio)[0] > (*expect.volume_ratio)[1])
                  at.list()[1].refuse_value("a number not below the first");
              }),
      number_range("max_seam_gap", expect.max_seam_gap, "m"),
      count_range("inverted_tetrahedra", expect.inverted_tetrahedra),
  };
}

Expect read_expect(const JsonReader& at, const std::vector<std::string>& bodies) {
  Expect expect;
  at.object(fields_of(expect, bodies));
  if (expect.energy_not_above && expect.energy_not_below && *expect.energy_not_above < *expect.energy_not_below)
    at.at("energy_not_above").refuse_value("a number not below 'energy_not_below' (J)");
  return expect;
}

}  // namespace malha
