// SPDX-License-Identifier: Apache-2.0
// Fields of seams.
#include <algorithm>
#include <limits>

#include "host/scene/scene_fields.h"

namespace malha {

namespace {

/// The shape of a body of the scene, on which selectors by rows depend.
const Shape& shape_of(const Scene& scene, const std::string& body) {
  static const Shape none = MeshFile{};
  const auto found = std::ranges::find(scene.bodies, body, &BodySpec::name);
  return found == scene.bodies.end() ? none : found->shape;
}

/// An end of a seam. `at`: a selector to read into or to write from.
Fields fields_of(SeamEnd& end, Selector& at, const Scene& scene, const std::vector<std::string>& bodies,
                 bool may_be_surface) {
  const auto read_body = [&](const JsonReader& reader) {
    end.body = bodies.empty() ? reader.text() : reader.choice("body", bodies);
  };
  Fields fields{{"body", read_body, true, [&](JsonValue& json) { json["body"] = end.body; }}};
  for (Field& one : selectors(at, shape_of(scene, end.body))) {
    one.read = [&end, &at, read = one.read](const JsonReader& reader) { read(reader), end.at = at; };
    if (!end.at) one.write = {};
    fields.push_back(std::move(one));
  }
  if (may_be_surface || end.surface) fields.push_back(written_if(end.surface, field("surface", end.surface)));
  return fields;
}

SeamEnd read_end(const JsonReader& at, const Scene& scene, const std::vector<std::string>& bodies, bool may_be_surface,
                 bool has_pairs) {
  SeamEnd end;
  Selector selector;
  if (at.has("body") && at.at("body").value().is_string()) end.body = at.at("body").text();  // rows depend on its shape
  const Fields fields = fields_of(end, selector, scene, bodies, may_be_surface);
  at.object(fields);
  std::string keys;
  int found = 0;
  for (const Field& one : fields) {
    if (one.key == "body") continue;
    keys += (keys.empty() ? "" : ", ") + one.key;
    found += at.has(one.key);
  }
  if (has_pairs && found > 0) at.refuse("a selector beside 'pairs'", "'body' alone");
  if (at.has("surface") && !end.surface) at.at("surface").refuse_value("true, or a selector instead");
  if (!has_pairs && found != 1) at.refuse(found == 0 ? "no selector" : "several selectors", "one of " + keys);
  return end;
}

JsonValue write_end(SeamEnd& end, const Scene& scene) {
  Selector at = end.at.value_or(Selector{});
  return write(fields_of(end, at, scene, {}, false));
}

/// `at`: null where fields are written.
Fields fields_of(SeamSpec& seam, const Scene& scene, const std::vector<std::string>& bodies, bool has_pairs) {
  const auto end_field = [&, has_pairs](const std::string& key, SeamEnd& end, bool may_be_surface) {
    const auto read = [&end, &scene, &bodies, may_be_surface, has_pairs](const JsonReader& at) {
      end = read_end(at, scene, bodies, may_be_surface, has_pairs);
    };
    return Field{key, read, true, [&end, &scene, key](JsonValue& json) { json[key] = write_end(end, scene); }};
  };
  const Integers numbers{0, std::numeric_limits<int>::max()};
  return {end_field("from", seam.from, false),
          end_field("to", seam.to, true),
          field("within", seam.within, above(0, "m")),
          checked(written_if(!seam.pairs.empty(), field("pairs", seam.pairs, numbers)),
                  [&seam](const JsonReader& at) {
                    if (seam.pairs.empty()) at.refuse_value("a list of pairs of vertices, from 0");
                  }),
          field("closing", seam.closing, at_least(0, "s")),
          field("compliance", seam.compliance, at_least(0, "m/N"))};
}

}  // namespace

Field seams_field(Scene& scene, const std::vector<std::string>& bodies) {
  const auto read_one = [&scene, &bodies](const JsonReader& at) {
    SeamSpec seam;
    const bool has_pairs = at.has("pairs");
    at.object(fields_of(seam, scene, bodies, has_pairs));
    if (at.has("within") == has_pairs)
      at.refuse(has_pairs ? "both 'within' and 'pairs'" : "neither 'within' nor 'pairs'", "exactly one of them");
    if (seam.to.surface && seam.to.body == seam.from.body)
      at.at("to").refuse("the surface of the body whose particles are attached to it", "that of another body");
    return seam;
  };
  const auto write_one = [&scene, &bodies](SeamSpec& seam) {
    return write(fields_of(seam, scene, bodies, !seam.pairs.empty()));
  };
  return written_if(!scene.seams.empty(), list("seams", scene.seams, read_one, write_one));
}

}  // namespace malha
