// SPDX-License-Identifier: Apache-2.0
#include "host/mesh/io/mesh_io.h"
#include "host/scene/scene_fields.h"

namespace malha {

namespace {

Fields fields_of(Keyframe& key) {
  return {required(field("time", key.time, at_least(0, "s"))), field("translate", key.translate, any("m")),
          rotation_field(key.axis, key.degrees)};
}

}  // namespace

Field motion_field(std::vector<Keyframe>& motion) {
  const auto read_one = [&motion](const JsonReader& at) {
    Keyframe key;
    at.object(fields_of(key));
    if (!motion.empty() && key.time <= motion.back().time)
      at.at("time").refuse_value("a time after that of the keyframe before it (s)");
    return key;
  };
  return list("motion", motion, read_one, [](Keyframe& key) { return write(fields_of(key)); });
}

namespace {

/// A clip by its number or its name.
Field clip_field(std::variant<int, std::string>& clip) {
  const auto read = [&clip](const JsonReader& at) {
    if (at.value().is_string())
      clip = at.text();
    else if (at.value().is_number())
      clip = at.integer({0, 1000000});
    else
      at.refuse_value("the name of a clip, or its number from 0");
  };
  return {"clip", read, false,
          [&clip](JsonValue& object) { std::visit([&](const auto& of) { object["clip"] = of; }, clip); }};
}

Fields fields_of(AnimationSpec& of, const std::string& folder) {
  return {written_if(!of.file.empty(), path_field("file", of.file, folder)),
          written_if(of.frames.empty() && !of.from_code, clip_field(of.clip)),
          written_if(!of.frames.empty(), path_field("frames", of.frames, folder)),
          field("frames_per_second", of.frames_per_second, above(0, "1/s")),
          written_if(!of.from_code, field("speed", of.speed, above(0, ""))),
          written_if(!of.from_code, field("offset", of.offset, any("s"))),
          written_if(!of.from_code, field("loop", of.loop)),
          written_if(of.from_code, field("from_code", of.from_code))};
}

/// Refuses keys that do not go together.
void check_animation(const JsonReader& at, const AnimationSpec& of, const Shape& shape) {
  const auto refuse_beside = [&](const std::string& one, std::vector<std::string> others) {
    for (const std::string& other : others)
      if (at.has(other)) at.at(other).refuse("'" + other + "' beside '" + one + "'", "one of them");
  };
  if (of.from_code)
    return refuse_beside("from_code", {"file", "clip", "frames", "frames_per_second", "speed", "offset", "loop"});
  if (at.has("from_code")) at.at("from_code").refuse_value("true, or no 'from_code'");
  if (!of.frames.empty()) {
    refuse_beside("frames", {"file", "clip"});
    if (!of.frames_per_second) at.refuse("no 'frames_per_second'", "'frames_per_second' beside 'frames'");
    return;
  }
  if (at.has("frames_per_second"))
    at.at("frames_per_second").refuse("'frames_per_second' without 'frames'", "'speed' for a clip");
  const auto* mesh = std::get_if<MeshFile>(&shape);
  if (!of.file.empty() && !is_gltf_file(of.file))
    at.at("file").refuse_value("a .glb or .gltf file; others by 'frames'");
  const bool was_refused = mesh && mesh->path.empty();
  if (of.file.empty() && !was_refused && !(mesh && is_gltf_file(mesh->path)))
    at.refuse("no file for a shape of another kind than glTF",
              "'file', 'frames' or 'from_code', or a .glb or .gltf file as shape");
}

/// The animation, which is checked against the shape, read before it.
Field animation_field(EnvironmentSpec& object, const std::string& folder) {
  const auto read = [&object, folder](const JsonReader& at) {
    AnimationSpec of;
    at.object(fields_of(of, folder));
    check_animation(at, of, object.shape);
    object.animation = of;
  };
  return {"animation", read, false, [&object, folder](JsonValue& json) {
            if (object.animation) json["animation"] = write(fields_of(*object.animation, folder));
          }};
}

}  // namespace

Fields fields_of(EnvironmentSpec& object, const std::string& folder) {
  return {
      required(name_field(object.name)),
      required(shape_field(object.shape, ShapeUse::Environment, folder)),
      part("transform", object.transform),
      written_if(!is_exact(object.shape),
                 choice("sides", "value of sides", object.sides,
                        {{"solid", Sides::Solid}, {"one_sided", Sides::OneSided}, {"two_sided", Sides::TwoSided}})),
      written_if(object.push_out,
                 choice("start_inside", "start_inside", object.push_out, {{"refuse", false}, {"push_out", true}})),
      written_if(object.thickness != 0, field("thickness", object.thickness, above(0, "m"))),
      field("friction", object.friction, at_least(0, "")),
      field("restitution", object.restitution, between(0, 1, "")),
      written_if(object.edges, field("edges", object.edges)),
      motion_field(object.motion),
      animation_field(object, folder),
  };
}

/// Refuses what an exact shape cannot have.
static void check_exact(const JsonReader& at, const EnvironmentSpec& object) {
  if (object.sides != Sides::Solid)
    at.at("sides").refuse_value(
        "\"solid\" for an exact shape; for a sheet a mesh (\"grid\", or a sphere with "
        "\"subdivisions\", or a box with \"cells\")");
  const Vec3& scale = object.transform.scale;
  const bool round =
      !std::holds_alternative<PlaneShape>(object.shape) && !std::holds_alternative<BoxShape>(object.shape);
  if (round && (scale[0] != scale[1] || scale[0] != scale[2]))
    at.at("transform")
        .at("scale")
        .refuse("different scales of an exact round shape",
                "one scale, or a sphere with \"subdivisions\", which is a mesh");
  if (object.edges && !std::holds_alternative<BoxShape>(object.shape))
    at.at("edges").refuse("'edges' of an exact shape that is not a box",
                          "false, because a plane and round shapes have no straight edges and corners; for a sphere "
                          "of triangles \"subdivisions\"");
}

EnvironmentSpec read_environment(const JsonReader& at, const std::string& folder) {
  EnvironmentSpec object;
  object.thickness = 0;  // the default, see EnvironmentSpec
  at.object(fields_of(object, folder));
  if (is_exact(object.shape)) check_exact(at, object);
  if (at.has("start_inside") && object.sides != Sides::Solid)
    at.at("start_inside").refuse("'start_inside' of a sheet, which has no inside", "\"sides\": \"solid\" beside it");
  return object;
}

}  // namespace malha
