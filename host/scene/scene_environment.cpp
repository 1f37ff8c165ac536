// SPDX-License-Identifier: Apache-2.0
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
