// SPDX-License-Identifier: Apache-2.0
#include "host/scene/scene_read.h"

namespace malha {
namespace {

Camera read_camera(const JsonReader& at) {
  Camera camera;
  at.object({
      {"eye", [&](const JsonReader& v) { camera.eye = v.vec3(any("m")); }, true},
      {"target", [&](const JsonReader& v) { camera.target = v.vec3(any("m")); }, true},
      {"fov_degrees", [&](const JsonReader& v) { camera.fov_degrees = v.number(between(1, 170, "degrees")); }},
  });
  if (camera.eye == camera.target) at.at("target").refuse("the same point as 'eye'", "another point");
  return camera;
}

}  // namespace

OutputSpec read_outputs(const JsonReader& at) {
  constexpr int widest_picture = 16384;  // pixels
  OutputSpec outputs;
  const auto read_frames = [&](const JsonReader& frames) {
    frames.object({
        {"every", [&](const JsonReader& v) { outputs.every = v.integer(0, max_steps); }, true},
        {"formats", [&](const JsonReader& v) { outputs.formats = v.choices("format", kFrameFormats); }, true},
    });
  };
  const auto read_pictures = [&](const JsonReader& pictures) {
    PictureSpec picture;
    pictures.object({
        {"every", [&](const JsonReader& v) { outputs.picture_every = v.integer(0, max_steps); }},
        {"size", [&](const JsonReader& v) { picture.size = v.integers<2>(1, widest_picture); }},
        {"camera", [&](const JsonReader& v) { picture.camera = read_camera(v); }},
    });
    outputs.picture = picture;
  };
  const auto read_page = [&](const JsonReader& page) {
    outputs.page.emplace();
    page.object({{"max_megabytes",
                  [&](const JsonReader& v) { outputs.page->max_megabytes = v.number(between(2, 400, "MB")); }}});
  };
  at.object({
      {"frames", read_frames},
      {"pictures", read_pictures},
      {"page", read_page},
      {"checkpoint_every", [&](const JsonReader& v) { outputs.checkpoint_every = v.integer(0, max_steps); }},
  });
  return outputs;
}

namespace {

/// Reads a range: a number is the upper bound, an object has "at_least", "at_most" or both. `one` reads such a number.
template <class One>
Range read_range(const JsonReader& at, const std::string& what, One&& one) {
  if (at.value().type == JsonValue::Type::Number) return Range(one(at));
  if (at.value().type != JsonValue::Type::Object) at.refuse_value(what + ", or an object with at_least, at_most");
  Range bounds;
  at.object({{"at_least", [&](const JsonReader& v) { bounds.at_least = one(v); }},
             {"at_most", [&](const JsonReader& v) { bounds.at_most = one(v); }}});
  if (!bounds) at.refuse("an empty object", "at least one of at_least, at_most");
  if (bounds.at_least && bounds.at_most && *bounds.at_least > *bounds.at_most)
    at.at("at_most").refuse_value("a number not below that of 'at_least'");
  return bounds;
}

ExpectOfBody read_body_expect(const JsonReader& at, const std::vector<std::string>& bodies) {
  ExpectOfBody expect;
  at.object({
      {"name", [&](const JsonReader& v) { expect.name = bodies.empty() ? v.text() : v.choice("body", bodies); }, true},
      {"bounds", [&](const JsonReader& v) { read_box(v, expect.bounds_min, expect.bounds_max); }, true},
  });
  return expect;
}

}  // namespace

Expect read_expect(const JsonReader& at, const std::vector<std::string>& bodies) {
  Expect expect;
  const auto bounds = [](Range& to, const std::string& unit) {
    return [&to, unit](const JsonReader& v) {
      to = read_range(v, "a number >= 0", [&](const JsonReader& one) { return one.number(at_least(0, unit)); });
    };
  };
  const auto counts = [](Range& to) {
    return [&to](const JsonReader& v) {
      to = read_range(v, "an integer >= 0", [](const JsonReader& one) { return one.integer(0, max_steps); });
    };
  };
  const auto read_bodies = [&](const JsonReader& v) {
    for (const JsonReader& item : v.list()) {
      const ExpectOfBody body = read_body_expect(item, bodies);
      for (const ExpectOfBody& earlier : expect.bodies)
        if (earlier.name == body.name) item.at("name").refuse_value("each body once");
      expect.bodies.push_back(body);
    }
    if (expect.bodies.empty()) v.refuse("no body", "at least one");
  };
  const auto read_bounds = [&](const JsonReader& v) {
    Vec3 min, max;
    read_box(v, min, max);
    expect.bounds_min = min;
    expect.bounds_max = max;
  };
  const auto read_volume_ratio = [&](const JsonReader& v) {
    expect.volume_ratio = v.numbers<2>(above(0, ""));
    if ((*expect.volume_ratio)[0] > (*expect.volume_ratio)[1]) {
      v.list()[1].refuse_value("a number not below the first");
    }
  };
  at.object({
      {"max_strain", bounds(expect.max_strain, "")},
      {"rms_strain", bounds(expect.rms_strain, "")},
      {"max_penetration", bounds(expect.max_penetration, "m")},
      {"max_crossings", counts(expect.max_crossings)},
      {"energy_not_above", [&](const JsonReader& v) { expect.energy_not_above = v.number(any("J")); }},
      {"energy_not_below", [&](const JsonReader& v) { expect.energy_not_below = v.number(any("J")); }},
      {"max_speed", bounds(expect.max_speed, "m/s")},
      {"bounds", read_bounds},
      {"bodies", read_bodies},
      {"volume_ratio", read_volume_ratio},
      {"inverted_tetrahedra", counts(expect.inverted_tetrahedra)},
  });
  if (expect.energy_not_above && expect.energy_not_below && *expect.energy_not_above < *expect.energy_not_below)
    at.at("energy_not_above").refuse_value("a number not below 'energy_not_below' (J)");
  return expect;
}

}  // namespace malha
