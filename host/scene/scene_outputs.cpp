#include <limits>

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
        {"every", [&](const JsonReader& v) { outputs.every = v.integer(0, most_steps); }, true},
        {"formats",
         [&](const JsonReader& v) {
           outputs.formats = v.words("format", {"vtp", "pc2", "ply", "obj"});
         },
         true},
    });
  };
  const auto read_pictures = [&](const JsonReader& pictures) {
    PictureSpec picture;
    pictures.object({
        {"every", [&](const JsonReader& v) { outputs.picture_every = v.integer(0, most_steps); }},
        {"size", [&](const JsonReader& v) { picture.size = v.integers<2>(1, widest_picture); }},
        {"camera", [&](const JsonReader& v) { picture.camera = read_camera(v); }},
    });
    outputs.picture = picture;
  };
  at.object({
      {"frames", read_frames},
      {"pictures", read_pictures},
      {"checkpoint_every", [&](const JsonReader& v) { outputs.checkpoint_every = v.integer(0, most_steps); }},
  });
  return outputs;
}

Expect read_expect(const JsonReader& at) {
  Expect expect;
  const auto read_inside = [&](const JsonReader& v) {
    Vec3 min, max;
    read_box(v, min, max);
    expect.inside_min = min;
    expect.inside_max = max;
  };
  const auto read_volume_ratio = [&](const JsonReader& v) {
    expect.volume_ratio = v.numbers<2>(above(0, ""));
    if ((*expect.volume_ratio)[0] > (*expect.volume_ratio)[1]) {
      v.list()[1].refuse_value("a number not below the first");
    }
  };
  at.object({
      {"max_strain", [&](const JsonReader& v) { expect.max_strain = v.number(at_least(0, "")); }},
      {"rms_strain", [&](const JsonReader& v) { expect.rms_strain = v.number(at_least(0, "")); }},
      {"max_penetration", [&](const JsonReader& v) { expect.max_penetration = v.number(at_least(0, "m")); }},
      {"max_crossings", [&](const JsonReader& v) { expect.max_crossings = v.integer(0, most_steps); }},
      {"energy_not_above", [&](const JsonReader& v) { expect.energy_not_above = v.number(any("J")); }},
      {"max_speed", [&](const JsonReader& v) { expect.max_speed = v.number(at_least(0, "m/s")); }},
      {"inside", read_inside},
      {"volume_ratio", read_volume_ratio},
      {"inverted_tetrahedra",
       [&](const JsonReader& v) { expect.inverted_tetrahedra = v.integer(0, std::numeric_limits<int>::max()); }},
  });
  return expect;
}

}  // namespace malha
