// SPDX-License-Identifier: Apache-2.0
// Fields of the objects in a scene. Each object lists its keys once, in fields_of(): how each is read, and how it is
// written, in the order of the list.
#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/scene/json_reader.h"
#include "malha/scene.h"

namespace malha {

using Field = JsonReader::Field;
using Fields = std::vector<Field>;

inline void read_into(bool& to, const JsonReader& at) { to = at.boolean(); }
inline void read_into(std::string& to, const JsonReader& at) { to = at.text(); }
inline void read_into(double& to, const JsonReader& at, const Interval& range) { to = at.number(range); }
inline void read_into(int& to, const JsonReader& at, const Integers& range) { to = at.integer(range); }
template <class T, std::size_t N, class Of>
void read_into(std::array<T, N>& to, const JsonReader& at, const Of& range) {
  const std::vector<JsonReader> items = at.list_of(N, describe(range));
  for (std::size_t i = 0; i < N; ++i) read_into(to[i], items[i], range);
}
template <class T, class... Of>
void read_into(std::vector<T>& to, const JsonReader& at, const Of&... range) {
  for (const JsonReader& item : at.list()) read_into(to.emplace_back(), item, range...);
}
template <class T, class... Of>
void read_into(std::optional<T>& to, const JsonReader& at, const Of&... range) {
  T value{};
  read_into(value, at, range...);
  to = value;
}

template <class T>
void write_to(JsonValue& object, const std::string& key, const T& value) {
  object[key] = value;
}
template <class T>
void write_to(JsonValue& object, const std::string& key, const std::optional<T>& value) {
  if (value) object[key] = *value;
}

/// A number, a text, true or false, or a list of these. `range`: of numbers. An optional that is empty is not written.
template <class T, class... Of>
Field field(const std::string& key, T& to, const Of&... range) {
  return {key, [&to, range...](const JsonReader& at) { read_into(to, at, range...); }, false,
          [&to, key](JsonValue& object) { write_to(object, key, to); }};
}

/// A word for each value. `what` names the meaning of the words in messages.
template <class T>
Field choice(const std::string& key, const std::string& what, T& to,
             const std::vector<std::pair<std::string, T>>& words) {
  const auto read = [&to, what, words](const JsonReader& at) {
    std::vector<std::string> allowed;
    for (const auto& [word, value] : words) allowed.push_back(word);
    const std::string found = at.choice(what, allowed);
    for (const auto& [word, value] : words)
      if (word == found) to = value;
  };
  const auto write = [&to, key, words](JsonValue& object) {
    for (const auto& [word, value] : words)
      if (value == to) object[key] = word;
  };
  return {key, read, false, write};
}

/// Several of these words.
inline Field choices(const std::string& key, const std::string& what, std::vector<std::string>& to,
                     const std::vector<std::string>& words) {
  return {key, [&to, what, words](const JsonReader& at) { to = at.choices(what, words); }, false,
          [&to, key](JsonValue& object) { object[key] = to; }};
}

inline Field required(Field of) {
  of.required = true;
  return of;
}
inline Field written_if(bool is_written, Field of) {
  if (!is_written) of.write = {};
  return of;
}
/// Calls check(at) once the field is read.
template <class Check>
Field checked(Field of, const Check& check) {
  of.read = [read = of.read, check](const JsonReader& at) { read(at), check(at); };
  return of;
}

/// Writes an object with these fields.
inline JsonValue write(const Fields& fields) {
  JsonValue object = JsonValue::object();
  for (const Field& one : fields)
    if (one.write) one.write(object);
  return object;
}

/// Checks an object whose fields are read; the overloads for objects with fields that depend on each other refuse some.
/// The templates find them, and fields_of(), by the type of the object, and therefore not in an unnamed namespace.
template <class T>
void check(const JsonReader&, const T&) {}

/// Reads an object.
template <class T>
T read_object(const JsonReader& at) {
  T object;
  at.object(fields_of(object));
  check(at, object);
  return object;
}

/// An object, or one that may be missing.
template <class T>
Field part(const std::string& key, T& to) {
  return {key, [&to](const JsonReader& at) { to = read_object<T>(at); }, false,
          [&to, key](JsonValue& object) { object[key] = write(fields_of(to)); }};
}
template <class T>
Field part(const std::string& key, std::optional<T>& to) {
  return {key, [&to](const JsonReader& at) { to = read_object<T>(at); }, false,
          [&to, key](JsonValue& object) {
            if (to) object[key] = write(fields_of(*to));
          }};
}

/// The object T of a variant, written where the variant holds one.
template <class T, class Variant>
Field alternative(const std::string& key, Variant& to) {
  return {key, [&to](const JsonReader& at) { to = read_object<T>(at); }, false,
          [&to, key](JsonValue& object) {
            if (T* held = std::get_if<T>(&to)) object[key] = write(fields_of(*held));
          }};
}
/// The same for a T of one value.
template <class T, class Variant, class Value, class... Of>
Field alternative(const std::string& key, Variant& to, Value T::*value, const Of&... range) {
  const auto read = [&to, value, range...](const JsonReader& at) {
    T held;
    read_into(held.*value, at, range...);
    to = held;
  };
  return {key, read, false, [&to, key, value](JsonValue& object) {
            if (T* held = std::get_if<T>(&to)) object[key] = held->*value;
          }};
}

/// A list of objects, which read_one(at) and write_one(object) read and write.
template <class T, class Read, class Write>
Field list(const std::string& key, std::vector<T>& to, const Read& read_one, const Write& write_one) {
  const auto read = [&to, read_one](const JsonReader& at) {
    at.for_each([&](const JsonReader& item) { to.push_back(read_one(item)); });
  };
  return {key, read, false, [&to, key, write_one](JsonValue& object) {
            object[key] = JsonValue::array();
            for (T& one : to) object[key].push_back(write_one(one));
          }};
}

/// parse_scene() and to_json() for a value instead of its text.
Scene read_scene(const JsonValue& tree, const std::string& file, const std::string& folder);
JsonValue write_scene(Scene scene, const std::string& folder);

// The parts of a scene, shared by scene*.cpp.

/// A name that is also valid as a file name: without '/' and '\', and without '.' in front.
Field name_field(std::string& name);

enum class ShapeUse { Body, Environment, Any };  // shapes of the environment have faces, or are exact
/// Mesh paths are read and written relative to `folder`. They are written as absolute ones if it is empty.
Field shape_field(Shape& shape, ShapeUse use, const std::string& folder);
/// The path of a file or folder, read and written as those of meshes.
Field path_field(const std::string& key, std::string& path, const std::string& folder);
/// The rest shape of a body. Paths are as those of shapes.
Field rest_field(std::optional<RestSpec>& rest, const std::string& folder);
Fields fields_of(Transform& transform);
/// A rotation: its axis and angle.
Field rotation_field(Vec3& axis, double& degrees);
/// An axis-aligned box (m): "min" and "max".
Fields box_fields(Vec3& min, Vec3& max);
/// Refuses min > max.
void check_box(const JsonReader& at, const Vec3& min, const Vec3& max);

/// Keyframes at increasing times.
Field motion_field(std::vector<Keyframe>& motion);

Fields fields_of(SolverSpec& solver);
SolverSpec read_solver(const JsonReader& at);
Fields fields_of(BodySpec& body, const std::string& folder);
BodySpec read_body(const JsonReader& at, const std::string& folder);
/// Selectors of particles of a body with this shape.
Fields selectors(Selector& to, const Shape& shape);
Field pins_field(BodySpec& body);
Field attachments_field(BodySpec& body);
Fields fields_of(Tear& tear);
/// The seams of a scene whose bodies are read. `bodies`: their names; empty if they are unknown.
Field seams_field(Scene& scene, const std::vector<std::string>& bodies);
Fields fields_of(EnvironmentSpec& object, const std::string& folder);
EnvironmentSpec read_environment(const JsonReader& at, const std::string& folder);
Fields fields_of(OutputSpec& outputs);
/// `bodies` are the names of the bodies of the scene; empty if they are unknown.
Fields fields_of(Expect& expect, const std::vector<std::string>& bodies);
Expect read_expect(const JsonReader& at, const std::vector<std::string>& bodies);

constexpr double max_particles = 2e7;  // of a shape that is generated or part of the scene
constexpr int max_steps = 1000000000;  // of a run, and of intervals of steps

}  // namespace malha
