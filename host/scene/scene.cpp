// SPDX-License-Identifier: Apache-2.0
#include "malha/scene.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "host/base/file.h"
#include "host/base/spelling_suggestion.h"
#include "host/mesh/io/mesh_io.h"
#include "host/scene/json.h"
#include "host/scene/scene_fields.h"
#include "malha/error.h"

namespace malha {

static Fields fields_of(Wind& wind) {
  return {required(field("velocity", wind.velocity, any("m/s"))),
          field("drag", wind.drag, at_least(0, "N s/m per particle")),
          written_if(wind.density > 0, field("density", wind.density, at_least(0, "kg/m^3 of air"))),
          written_if(wind.density > 0, field("drag_coefficient", wind.drag_coefficient, at_least(0, ""))),
          written_if(wind.density > 0, field("lift_coefficient", wind.lift_coefficient, at_least(0, "")))};
}
static void check(const JsonReader& at, const Wind&) {
  if (!at.has("drag") && !at.has("density"))
    at.refuse("neither 'drag' nor 'density'", "'drag' (acts on particles), 'density' (acts on faces) or both");
  for (const char* key : {"drag_coefficient", "lift_coefficient"})
    if (at.has(key) && !at.has("density"))
      at.at(key).refuse("'" + std::string(key) + "' without 'density'", "'density' beside it");
}

static Fields fields_of(Sleep& sleep) {
  return {field("speed", sleep.speed, above(0, "m/s")), field("after", sleep.after, at_least(0, "s"))};
}

static Fields fields_of(SelfCollision& self) {
  return {
      required(field("thickness", self.thickness, above(0, "m"))), field("friction", self.friction, at_least(0, "")),
      written_if(!self.bodies.empty(), checked(field("bodies", self.bodies),
                                               [&self](const JsonReader& at) {
                                                 if (self.bodies.empty())
                                                   at.refuse("no body", "at least one, or no key for all bodies");
                                               })),
      choice("crossing_at_start", "crossing_at_start", self.ignores_crossings, {{"refuse", false}, {"ignore", true}})};
}

namespace {

/// Refuses names that are not those of bodies, and repeated ones.
void check_self_collision(const JsonReader& at, const SelfCollision& self, const std::vector<std::string>& known) {
  if (self.bodies.empty() || known.empty()) return;
  std::set<std::string> named;
  for (const JsonReader& item : at.at("bodies").list()) {
    const std::string name = item.text();
    if (std::find(known.begin(), known.end(), name) == known.end())
      item.refuse("unknown body '" + name + "'" + did_you_mean(name, known), join(known));
    if (!named.insert(item.text()).second) item.refuse_value("each body once");
  }
}

void refuse_duplicate_name(const JsonReader& at, const std::string& name, std::set<std::string>& names) {
  if (!names.insert(name).second) at.at("name").refuse_value("a name that no other body or environment object has");
}

/// The names in a scene, as they are read.
struct Names {
  std::set<std::string> all;
  std::vector<std::string> bodies;  // empty if bodies have errors
};

Fields fields_of(Scene& scene, const std::string& folder, Names& names) {
  const auto read_body_of_scene = [&](const JsonReader& at) {
    BodySpec body = read_body(at, folder);
    refuse_duplicate_name(at, body.name, names.all);
    return body;
  };
  const auto read_object_of_scene = [&](const JsonReader& at) {
    EnvironmentSpec object = read_environment(at, folder);
    refuse_duplicate_name(at, object.name, names.all);
    return object;
  };
  const auto write_one = [&](auto& one) { return write(fields_of(one, folder)); };
  const auto note_names = [&](const JsonReader& at) {
    if (scene.bodies.empty()) at.refuse("no body", "at least one");
    for (const BodySpec& body : scene.bodies) names.bodies.push_back(body.name);
  };
  return {
      {"$schema", [](const JsonReader& at) { at.text(); }},
      required(name_field(scene.name)),
      {"solver", [&](const JsonReader& at) { scene.solver = read_solver(at); }, true,
       [&](JsonValue& json) { json["solver"] = write(fields_of(scene.solver)); }},
      field("gravity", scene.gravity, any("m/s^2")),
      part("wind", scene.wind),
      part("sleep", scene.sleep),
      required(checked(written_if(!scene.bodies.empty(), list("bodies", scene.bodies, read_body_of_scene, write_one)),
                       note_names)),
      seams_field(scene, names.bodies),
      list("environment", scene.environment, read_object_of_scene, write_one),
      checked(part("self_collision", scene.self_collision),
              [&](const JsonReader& at) { check_self_collision(at, *scene.self_collision, names.bodies); }),
      required(field("duration", scene.duration, above(0, "s"))),
      part("outputs", scene.outputs),
      {"expect", [&](const JsonReader& at) { scene.expect = read_expect(at, names.bodies); }, false,
       [&](JsonValue& json) { json["expect"] = write(fields_of(scene.expect, {})); }},
  };
}

}  // namespace

Field name_field(std::string& name) {
  return checked(field("name", name), [&name](const JsonReader& at) {
    if (name.front() == '.' || name.find_first_of("/\\") != std::string::npos)
      at.refuse_value("a name without '/' and '\\', and without '.' in front");
  });
}

Scene read_scene(const JsonValue& tree, const std::string& file, const std::string& folder) {
  ErrorList errors;
  const JsonReader root(tree, file, "", &errors);
  Scene scene;
  scene.file = file;
  Names names;
  errors.collect([&] {
    root.object(fields_of(scene, folder, names));
    if (scene.duration / scene.solver.dt > max_steps) {
      root.at("duration").refuse_value("at most " + std::to_string(max_steps) + " steps of /solver/dt");
    }
  });
  errors.throw_all();
  return scene;
}

JsonValue write_scene(Scene scene, const std::string& folder) {
  Names names;
  return write(fields_of(scene, folder, names));
}

Scene parse_scene(const std::string& text, const std::string& file, const std::string& folder) {
  return read_scene(parse_json(text, file), file, folder);
}

std::string to_json(const Scene& scene, const std::string& folder) {
  return write_scene(scene, folder).indented() + "\n";
}

Scene load_scene(const std::string& path) {
  const std::string text = read_input(path == "-" ? "/dev/stdin" : path, "a readable scene file (JSON)");
  namespace fs = std::filesystem;
  if (path == "-") return parse_scene(text, "standard input", "");
  const fs::path folder = fs::path(path).parent_path();
  if (is_mesh_file(path))
    refuse(path, "", "a mesh",
           "a scene that names it, such as {\"name\": \"a body\", \"solver\": {\"type\": \"pbd\"}, \"gravity\": [0, "
           "-9.81, 0], \"duration\": 2, \"bodies\": [{\"name\": \"body\", \"mass\": 1, \"shape\": {\"mesh\": \"" +
               fs::path(path).filename().string() +
               "\"}, \"constraints\": [{\"type\": \"distance\"}]}]} (scenes/README.md, Meshes from files); malha view "
               "shows it");
  Scene scene = parse_scene(text, path, folder.string());
  std::error_code none;
  if (!fs::is_symlink(path, none)) return scene;
  const fs::path target = fs::weakly_canonical(path, none).parent_path();
  // Of a pattern of files the folder counts.
  const auto is_there = [](const fs::path& of) {
    return fs::exists(of.string().find('*') == std::string::npos ? of : of.parent_path());
  };
  const auto resolve_at_target = [&](std::string& of) {
    if (of.empty() || none || is_there(of)) return;
    const fs::path at_target = target / fs::path(of).lexically_relative(folder.empty() ? "." : folder);
    if (is_there(at_target)) of = at_target.lexically_normal().string();
  };
  const auto resolve_shape = [&](Shape& shape) {
    if (auto* mesh = std::get_if<MeshFile>(&shape)) resolve_at_target(mesh->path);
  };
  for (BodySpec& body : scene.bodies) {
    resolve_shape(body.shape);
    if (body.rest)
      if (auto* mesh = std::get_if<RestMesh>(&*body.rest)) resolve_at_target(mesh->path);
    for_each_map(body, [&](VertexMap& map) { resolve_at_target(map.picture); });
  }
  for (EnvironmentSpec& object : scene.environment) {
    resolve_shape(object.shape);
    if (object.animation) resolve_at_target(object.animation->file), resolve_at_target(object.animation->frames);
  }
  return scene;
}

}  // namespace malha
