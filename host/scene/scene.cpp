// SPDX-License-Identifier: Apache-2.0
#include "malha/scene.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "host/base/file.h"
#include "host/base/spelling_suggestion.h"
#include "host/mesh/io/mesh_io.h"
#include "host/scene/scene_read.h"
#include "malha/error.h"

namespace malha {
namespace {

Wind read_wind(const JsonReader& at) {
  Wind wind;
  at.object({
      {"velocity", [&](const JsonReader& v) { wind.velocity = v.vec3(any("m/s")); }, true},
      {"drag", [&](const JsonReader& v) { wind.drag = v.number(at_least(0, "N s/m per particle")); }},
      {"density", [&](const JsonReader& v) { wind.density = v.number(at_least(0, "kg/m^3 of air")); }},
      {"drag_coefficient", [&](const JsonReader& v) { wind.drag_coefficient = v.number(at_least(0, "")); }},
      {"lift_coefficient", [&](const JsonReader& v) { wind.lift_coefficient = v.number(at_least(0, "")); }},
  });
  if (!at.has("drag") && !at.has("density"))
    at.refuse("neither 'drag' nor 'density'", "'drag' (acts on particles), 'density' (acts on faces) or both");
  for (const char* key : {"drag_coefficient", "lift_coefficient"})
    if (at.has(key) && !at.has("density"))
      at.at(key).refuse("'" + std::string(key) + "' without 'density'", "'density' beside it");
  return wind;
}

Sleep read_sleep(const JsonReader& at) {
  Sleep sleep;
  at.object({
      {"speed", [&](const JsonReader& v) { sleep.speed = v.number(above(0, "m/s")); }},
      {"after", [&](const JsonReader& v) { sleep.after = v.number(at_least(0, "s")); }},
  });
  return sleep;
}

SelfCollision read_self_collision(const JsonReader& at) {
  SelfCollision self;
  at.object({
      {"thickness", [&](const JsonReader& v) { self.thickness = v.number(above(0, "m")); }, true},
      {"crossing_at_start",
       [&](const JsonReader& v) {
         self.ignores_crossings = v.choice("crossing_at_start", {"refuse", "ignore"}) == "ignore";
       }},
      {"friction", [&](const JsonReader& v) { self.friction = v.number(at_least(0, "")); }},
      {"bodies",
       [&](const JsonReader& v) {
         for (const JsonReader& item : v.list()) self.bodies.push_back(item.text());
         if (self.bodies.empty()) v.refuse("no body", "at least one, or no key for all bodies");
       }},
  });
  return self;
}

std::vector<std::string> names_of(const std::vector<BodySpec>& bodies) {
  std::vector<std::string> names;
  for (const BodySpec& body : bodies) names.push_back(body.name);
  return names;
}

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

}  // namespace

std::string read_name(const JsonReader& at) {
  const std::string name = at.text();
  if (name.front() == '.' || name.find_first_of("/\\") != std::string::npos) {
    at.refuse_value("a name without '/' and '\\', and without '.' in front");
  }
  return name;
}

Scene parse_scene(const std::string& text, const std::string& file, const std::string& folder) {
  const JsonValue tree = parse_json(text, file);
  ErrorList errors;
  const JsonReader root(tree, file, "", &errors);
  Scene scene;
  scene.file = file;
  std::set<std::string> names;
  std::vector<std::string> known;  // names of the bodies; empty if bodies have errors
  errors.collect([&] {
    root.object({
        {"$schema", [](const JsonReader& v) { v.text(); }},
        {"name", [&](const JsonReader& v) { scene.name = read_name(v); }, true},
        {"solver", [&](const JsonReader& v) { scene.solver = read_solver(v); }, true},
        {"gravity", [&](const JsonReader& v) { scene.gravity = v.vec3(any("m/s^2")); }},
        {"wind", [&](const JsonReader& v) { scene.wind = read_wind(v); }},
        {"sleep", [&](const JsonReader& v) { scene.sleep = read_sleep(v); }},
        {"bodies",
         [&](const JsonReader& v) {
           v.for_each([&](const JsonReader& item) {
             scene.bodies.push_back(read_body(item, folder));
             refuse_duplicate_name(item, scene.bodies.back().name, names);
           });
           if (scene.bodies.empty()) v.refuse("no body", "at least one");
           known = names_of(scene.bodies);
         },
         true},
        {"environment",
         [&](const JsonReader& v) {
           v.for_each([&](const JsonReader& item) {
             scene.environment.push_back(read_environment(item, folder));
             refuse_duplicate_name(item, scene.environment.back().name, names);
           });
         }},
        {"self_collision",
         [&](const JsonReader& v) {
           scene.self_collision = read_self_collision(v);
           check_self_collision(v, *scene.self_collision, known);
         }},
        {"duration", [&](const JsonReader& v) { scene.duration = v.number(above(0, "s")); }, true},
        {"outputs", [&](const JsonReader& v) { scene.outputs = read_outputs(v); }},
        {"expect", [&](const JsonReader& v) { scene.expect = read_expect(v, known); }},
    });
    if (scene.duration / scene.solver.dt > max_steps) {
      root.at("duration").refuse_value("at most " + std::to_string(max_steps) + " steps of /solver/dt");
    }
  });
  errors.throw_all();
  return scene;
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
  const auto resolve_at_target = [&](Shape& shape) {
    auto* mesh = std::get_if<MeshFile>(&shape);
    if (mesh == nullptr || none || fs::exists(mesh->path)) return;
    const fs::path at_target = (target / fs::path(mesh->path).lexically_relative(folder.empty() ? "." : folder));
    if (fs::exists(at_target)) mesh->path = at_target.lexically_normal().string();
  };
  for (BodySpec& body : scene.bodies) resolve_at_target(body.shape);
  for (EnvironmentSpec& object : scene.environment) resolve_at_target(object.shape);
  return scene;
}

}  // namespace malha
