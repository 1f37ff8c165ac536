// SPDX-License-Identifier: Apache-2.0
#include "host/scene/scene_write.h"

#include <nlohmann/json.hpp>

#include "host/scene/constraint_schema.h"

namespace malha {
namespace {

using Json = nlohmann::ordered_json;  // keeps the order in which keys are added

Json rotation(const Vec3& axis, double degrees) { return {{"axis", axis}, {"degrees", degrees}}; }

namespace fs = std::filesystem;

/// The absolute path, which is valid in any folder, or the path relative to `folder`, if that is not empty. The name of
/// the file is kept even if it is a link, since its extension gives the format.
std::string path_from(const std::string& folder, const fs::path& path) {
  const fs::path whole = fs::absolute(path);
  if (folder.empty()) return whole.string();
  std::error_code gone;  // the folder may have been removed meanwhile
  const fs::path relative = fs::relative(whole.parent_path(), folder, gone);
  return gone || relative.empty() ? whole.string() : (relative / whole.filename()).lexically_normal().string();
}

struct ShapeWriter {
  const std::string& folder;

  Json operator()(const MeshFile& s) const {
    Json json{{"mesh", path_from(folder, s.path)}};
    if (s.weld) json["weld"] = *s.weld;
    return json;
  }
  Json operator()(const GridShape& s) const { return {{"grid", {{"size", s.size}, {"cells", s.cells}}}}; }
  Json operator()(const SphereShape& s) const {
    return {{"sphere", {{"radius", s.radius}, {"subdivisions", s.subdivisions}}}};
  }
  Json operator()(const BoxShape& s) const { return {{"box", {{"size", s.size}, {"cells", s.cells}}}}; }
  Json operator()(const BarShape& s) const {
    return {{"bar", {{"length", s.length}, {"width", s.width}, {"cells", s.cells}}}};
  }
  Json operator()(const ChainShape& s) const {
    return {{"chain", {{"from", s.from}, {"to", s.to}, {"segments", s.segments}}}};
  }
  Json operator()(const LatticeShape& s) const {
    return {{"lattice", {{"min", s.min}, {"max", s.max}, {"count", s.count}}}};
  }
  Json operator()(const MeshDataShape& s) const {
    Json json{{"points", s.points}};
    for (const Quad& face : s.faces)
      json["faces"].push_back(is_triangle(face) ? Json{face[0], face[1], face[2]} : Json(face));
    if (!s.lines.empty()) json["lines"] = s.lines;
    if (!s.tetrahedra.empty()) json["tetrahedra"] = s.tetrahedra;
    return {{"mesh_data", json}};
  }
  Json operator()(const TetBoxShape& s) const { return {{"tet_box", {{"size", s.size}, {"cells", s.cells}}}}; }
};

struct PinWriter {
  Json operator()(const RowPin& p) const { return {{"row", p.last ? "last" : "first"}}; }
  Json operator()(const BoxPin& p) const { return {{"box", {{"min", p.min}, {"max", p.max}}}}; }
  Json operator()(const SpherePin& p) const { return {{"sphere", {{"center", p.center}, {"radius", p.radius}}}}; }
  Json operator()(const NearestPin& p) const { return {{"nearest", p.point}}; }
  Json operator()(const ListPin& p) const { return {{"particles", p.particles}}; }
};

Json write(const std::vector<Keyframe>& motion) {
  Json json = Json::array();
  for (const Keyframe& key : motion)
    json.push_back({{"time", key.time}, {"translate", key.translate}, {"rotate", rotation(key.axis, key.degrees)}});
  return json;
}

Json write(const Pin& pin) {
  Json json = std::visit(PinWriter{}, pin.at);
  if (!pin.motion.empty()) json["motion"] = write(pin.motion);
  if (pin.release_time) json["release_time"] = *pin.release_time;
  return json;
}

Json write(const Attachment& a) {
  Json json{{"at", std::visit(PinWriter{}, a.at)}};
  if (!a.environment.empty()) json["to"] = {{"environment", a.environment}};
  if (a.point) json["to"]["point"] = *a.point;
  if (!a.motion.empty()) json["motion"] = write(a.motion);
  if (a.compliance) {
    json["compliance"] = *a.compliance;
  } else {
    json["stiffness"] = a.stiffness;
  }
  if (a.release_time) json["release_time"] = *a.release_time;
  return json;
}

Json write(const Transform& t) {
  return {{"translate", t.translate}, {"rotate", rotation(t.axis, t.degrees)}, {"scale", t.scale}};
}

Json write(const ConstraintSpec& c) {
  Json json{{"type", c.type}};
  bool accepts_stiffness = false;
  for (const ConstraintSchema& kind : constraint_kinds()) {
    if (kind.name != c.type) continue;
    if (kind.on_edges) json["elements"] = c.elements;
    json[kind.parameter] = c.parameter;
    accepts_stiffness = kind.accepts_stiffness;
  }
  if (c.rigidity) {
    json["rigidity"] = *c.rigidity;
  } else if (c.young_modulus) {
    json["young_modulus"] = *c.young_modulus;
  } else if (c.compliance) {
    json["compliance"] = *c.compliance;
  } else if (accepts_stiffness) {
    json["stiffness"] = c.stiffness;
  }
  return json;
}

Json write(const BodySpec& b, const std::string& folder) {
  Json json{{"name", b.name}, {"shape", std::visit(ShapeWriter{folder}, b.shape)}, {"transform", write(b.transform)}};
  json["velocity"] = b.velocity;
  json["spin"] = b.spin;
  if (b.mass) json["mass"] = *b.mass;
  if (b.density) json["density"] = *b.density;
  json["damping"] = b.damping;
  json["pins"] = Json::array();
  for (const Pin& pin : b.pins) json["pins"].push_back(write(pin));
  if (!b.attachments.empty()) json["attachments"] = Json::array();
  for (const Attachment& attachment : b.attachments) json["attachments"].push_back(write(attachment));
  if (b.tear) json["tear"] = {{"strain", b.tear->strain}};
  json["constraints"] = Json::array();
  for (const ConstraintSpec& constraint : b.constraints) json["constraints"].push_back(write(constraint));
  return json;
}

Json write(const EnvironmentSpec& e, const std::string& folder) {
  Json json{{"name", e.name}, {"shape", std::visit(ShapeWriter{folder}, e.shape)}, {"transform", write(e.transform)}};
  json["sides"] = e.sides == Sides::Solid ? "solid" : e.sides == Sides::OneSided ? "one_sided" : "two_sided";
  if (e.push_out) json["start_inside"] = "push_out";
  if (e.thickness != 0) json["thickness"] = e.thickness;
  json["friction"] = e.friction;
  json["restitution"] = e.restitution;
  if (e.edges) json["edges"] = true;
  json["motion"] = write(e.motion);
  return json;
}

Json write(const OutputSpec& o) {
  Json json = Json::object();
  if (!o.formats.empty()) json["frames"] = {{"every", o.every}, {"formats", o.formats}};
  if (o.picture || o.picture_every > 0) {
    const PictureSpec picture = o.picture.value_or(PictureSpec{});
    json["pictures"] = {{"every", o.picture_every}, {"size", picture.size}};
    if (const auto& camera = picture.camera) {
      json["pictures"]["camera"] = {
          {"eye", camera->eye}, {"target", camera->target}, {"fov_degrees", camera->fov_degrees}};
    }
  }
  if (o.page) json["page"] = {{"max_megabytes", o.page->max_megabytes}};
  if (o.checkpoint_every) json["checkpoint_every"] = *o.checkpoint_every;
  return json;
}

Json write(const SolverSpec& s) {
  Json json{{"type", s.type}, {"dt", s.dt}, {"substeps", s.substeps}, {"iterations", s.iterations}};
  json["precision"] = s.precision == Precision::Double ? "double" : "float";
  if (s.type == "pbd") {
    json["corrector"] = s.keeps_momenta ? "inertia" : "off";
    json["levels"] = s.levels > 0 ? Json(s.levels) : Json(s.levels == 0 ? "off" : "auto");
    if (s.levels_interval > 0) json["levels_interval"] = s.levels_interval;
    json["stiffness_basis"] = s.stiffness_of_step ? "step" : "projections";
  }
  if (s.type != "desbrun") return json;
  const DesbrunSpec& desbrun = s.desbrun;
  json["spring_constant"] = desbrun.spring_constant;
  json["filter"] = desbrun.filter == FilterKind::Dense    ? "dense"
                   : desbrun.filter == FilterKind::Sparse ? "sparse"
                                                          : "auto";
  if (desbrun.storage)
    json["storage"] = *desbrun.storage == Storage::Double  ? "double"
                      : *desbrun.storage == Storage::Int16 ? "int16"
                                                           : "float";
  json["filter_external_forces"] = desbrun.filter_external_forces;
  if (desbrun.corrector)
    json["corrector"] = *desbrun.corrector == Corrector::Inertia ? "inertia"
                        : *desbrun.corrector == Corrector::Paper ? "paper"
                                                                 : "off";
  json["refinement_iterations"] = desbrun.refinement_iterations;
  if (desbrun.tolerance) json["tolerance"] = *desbrun.tolerance;
  if (desbrun.time_budget) json["time_budget"] = *desbrun.time_budget;
  return json;
}

Json write(const Wind& w) {
  Json json{{"velocity", w.velocity}, {"drag", w.drag}};
  if (w.density > 0) {
    json["density"] = w.density;
    json["drag_coefficient"] = w.drag_coefficient;
    json["lift_coefficient"] = w.lift_coefficient;
  }
  return json;
}

/// A range; with `count` its bounds are written as integers.
Json write(const Range& bounds, bool count) {
  const auto number = [count](double x) { return count ? Json(static_cast<std::int64_t>(x)) : Json(x); };
  if (!bounds.at_least) return number(*bounds.at_most);
  Json json{{"at_least", number(*bounds.at_least)}};
  if (bounds.at_most) json["at_most"] = number(*bounds.at_most);
  return json;
}

Json write(const Expect& e) {
  Json json = Json::object();
  const auto bound = [&](const char* key, const Range& bounds, bool count = false) {
    if (bounds) json[key] = write(bounds, count);
  };
  const auto add = [&](const char* key, const auto& value) {
    if (value) json[key] = *value;
  };
  bound("max_strain", e.max_strain);
  bound("rms_strain", e.rms_strain);
  bound("max_penetration", e.max_penetration);
  bound("max_crossings", e.max_crossings, true);
  add("energy_not_above", e.energy_not_above);
  add("energy_not_below", e.energy_not_below);
  bound("max_speed", e.max_speed);
  if (e.bounds_min && e.bounds_max) json["bounds"] = {{"min", *e.bounds_min}, {"max", *e.bounds_max}};
  for (const ExpectOfBody& body : e.bodies)
    json["bodies"].push_back({{"name", body.name}, {"bounds", {{"min", body.bounds_min}, {"max", body.bounds_max}}}});
  add("volume_ratio", e.volume_ratio);
  bound("inverted_tetrahedra", e.inverted_tetrahedra, true);
  return json;
}

}  // namespace

std::string to_json(const Scene& scene) { return to_json(scene, ""); }

std::string to_json(const Scene& scene, const std::string& folder) {
  Json json{{"name", scene.name}};
  json["solver"] = write(scene.solver);
  json["gravity"] = scene.gravity;
  if (scene.wind) json["wind"] = write(*scene.wind);
  if (scene.sleep) json["sleep"] = {{"speed", scene.sleep->speed}, {"after", scene.sleep->after}};
  for (const BodySpec& body : scene.bodies) json["bodies"].push_back(write(body, folder));
  json["environment"] = Json::array();
  for (const EnvironmentSpec& object : scene.environment) json["environment"].push_back(write(object, folder));
  if (const auto& self = scene.self_collision) {
    json["self_collision"] = {{"thickness", self->thickness}, {"friction", self->friction}};
    if (!self->bodies.empty()) json["self_collision"]["bodies"] = self->bodies;
    json["self_collision"]["crossing_at_start"] = self->ignores_crossings ? "ignore" : "refuse";
  }
  json["duration"] = scene.duration;
  json["outputs"] = write(scene.outputs);
  json["expect"] = write(scene.expect);
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";  // paths may contain invalid UTF-8
}

}  // namespace malha
