// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "host/scene/constraint_schema.h"
#include "host/scene/scene_read.h"

namespace malha {

ConstraintSpec read_constraint(const JsonReader& at) {
  std::vector<std::string> names;
  for (const ConstraintSchema& kind : constraint_kinds()) names.push_back(kind.name);
  ConstraintSpec spec;
  spec.type = at.at("type").choice("constraint", names);
  const auto kind = std::find_if(constraint_kinds().begin(), constraint_kinds().end(),
                                 [&](const ConstraintSchema& k) { return k.name == spec.type; });
  spec.parameter = kind->parameter_default;
  const Interval range = std::isfinite(kind->parameter_max) ? between(kind->parameter_min, kind->parameter_max, "")
                         : kind->min_included               ? at_least(kind->parameter_min, "")
                                                            : above(kind->parameter_min, "");

  if (spec.type == "pressure" && at.has("pressure"))  // the former name of the key
    at.at("pressure").refuse("'pressure', which is a ratio of volumes, not a pressure", "'volume_ratio'");
  std::vector<JsonReader::Field> fields{
      {"type", [](const JsonReader&) {}, true},
  };
  if (kind->accepts_stiffness) {
    fields.push_back({"stiffness", [&](const JsonReader& v) { spec.stiffness = v.number(between(0, 1, "")); }});
    fields.push_back({"compliance", [&](const JsonReader& v) {
                        spec.compliance =
                            v.number(at_least(0, "m/N for lengths, rad/(N m) for angles, m^5/N for volumes"));
                        if (at.has("stiffness")) v.refuse("both 'stiffness' and 'compliance'", "one of them");
                      }});
  }
  fields.push_back({kind->parameter, [&](const JsonReader& v) { spec.parameter = v.number(range); }});
  if (!kind->modulus.empty())
    fields.push_back({kind->modulus,
                      [&](const JsonReader& v) {
                        modulus_of(spec, kind->modulus) = v.number(above(0, kind->unit));
                        if (kind->accepts_stiffness && (at.has("stiffness") || at.has("compliance")))
                          v.refuse("'" + kind->modulus + "' beside 'stiffness' or 'compliance'", "one of them");
                      },
                      !kind->accepts_stiffness});
  if (kind->on_edges) {
    spec.elements = {"edges"};
    fields.push_back({"elements", [&](const JsonReader& v) {
                        spec.elements = v.choices("element", {"edges", "shear"});
                      }});
  }
  at.object(fields);
  return spec;
}

BodySpec read_body(const JsonReader& at, const std::string& folder) {
  BodySpec body;
  bool has_shape = false;  // without a valid shape, pins by rows cannot be checked
  at.object({
      {"name", [&](const JsonReader& v) { body.name = read_name(v); }, true},
      {"shape", [&](const JsonReader& v) { body.shape = read_shape(v, ShapeUse::Body, folder), has_shape = true; },
       true},
      {"transform", [&](const JsonReader& v) { body.transform = read_transform(v); }},
      {"velocity", [&](const JsonReader& v) { body.velocity = v.vec3(any("m/s")); }},
      {"spin", [&](const JsonReader& v) { body.spin = v.vec3(any("rad/s")); }},
      {"mass", [&](const JsonReader& v) { body.mass = v.number(above(0, "kg")); }},
      {"density",
       [&](const JsonReader& v) {
         body.density = v.number(above(0, "kg/m^2 of surface, kg/m of lines, kg/m^3 of tetrahedra"));
       }},
      {"damping", [&](const JsonReader& v) { body.damping = v.number(between(0, 1, "")); }},
      {"pins",
       [&](const JsonReader& v) {
         if (has_shape) v.for_each([&](const JsonReader& item) { body.pins.push_back(read_pin(item, body.shape)); });
       }},
      {"attachments",
       [&](const JsonReader& v) {
         if (has_shape)
           v.for_each([&](const JsonReader& item) { body.attachments.push_back(read_attachment(item, body.shape)); });
       }},
      {"tear", [&](const JsonReader& v) { body.tear = read_tear(v); }},
      {"constraints",
       [&](const JsonReader& v) {
         v.for_each([&](const JsonReader& item) { body.constraints.push_back(read_constraint(item)); });
       }},
  });
  if (body.density && is_loose(body.shape)) {
    at.at("density").refuse("a density of loose particles", "'mass' (kg)");
  }
  if (body.tear) {
    const bool closed = std::any_of(body.constraints.begin(), body.constraints.end(),
                                    [](const ConstraintSpec& c) { return c.type == "pressure"; });
    if (closed)
      at.at("tear").refuse("'tear' of a body with pressure", "a body without pressure, which needs a closed mesh");
    if (is_loose(body.shape)) at.at("tear").refuse("'tear' of loose particles", "a body with edges");
  }
  if (body.mass.has_value() == body.density.has_value()) {
    at.refuse(body.mass ? "both 'mass' and 'density'" : "neither 'mass' nor 'density'", "exactly one of them");
  }
  return body;
}

}  // namespace malha
