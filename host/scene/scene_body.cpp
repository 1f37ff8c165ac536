// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "host/base/spelling_suggestion.h"
#include "host/scene/constraint_schema.h"
#include "host/scene/scene_fields.h"
#include "malha/fabrics.h"
#include "malha/text.h"

namespace malha {

namespace {

/// Returns the kind of this name, or null.
const ConstraintSchema* kind_of(const std::string& type) {
  const auto kind = std::ranges::find(constraint_kinds(), type, &ConstraintSchema::name);
  return kind == constraint_kinds().end() ? nullptr : &*kind;
}

/// The modulus at `key`, or two of them: [along, across].
Field moduli_field(const std::string& key, ConstraintSpec& spec, const Interval& range) {
  const auto read = [&spec, key, range](const JsonReader& at) {
    std::optional<double>& along = modulus_of(spec, key);
    if (!spec.orthotropy) return read_into(along, at, range);
    std::array<double, 2> both{};
    read_into(both, at, range);
    along = both[0], spec.orthotropy->across = both[1];
  };
  const auto write = [&spec, key](JsonValue& json) {
    const std::optional<double>& along = modulus_of(spec, key);
    if (along && spec.orthotropy)
      json[key] = std::array{*along, spec.orthotropy->across};
    else
      write_to(json, key, along);
  };
  return {key, read, false, write};
}

/// A key that only a material of two moduli has.
template <class T>
Field of_two_moduli(const std::string& key, ConstraintSpec& spec, T Orthotropy::*value, const Interval& range) {
  const auto read = [&spec, value, range](const JsonReader& at) {
    if (spec.orthotropy) read_into((*spec.orthotropy).*value, at, range);
  };
  const auto write = [&spec, value, key](JsonValue& json) {
    if (spec.orthotropy) write_to(json, key, (*spec.orthotropy).*value);
  };
  return {key, read, false, write};
}

/// `kind`: null for a type that does not exist. What was set in code although the kind lacks it is written too, so that
/// check_scene() refuses it.
Fields fields_of(ConstraintSpec& spec, const ConstraintSchema* kind, const std::string& folder) {
  Fields fields{{"type", [](const JsonReader&) {}, true, [&spec](JsonValue& json) { json["type"] = spec.type; }}};
  if (kind && kind->on_edges) fields.push_back(choices("elements", "element", spec.elements, {"edges", "shear"}));
  if (kind) {
    const Interval range = std::isfinite(kind->parameter_max) ? between(kind->parameter_min, kind->parameter_max, "")
                           : kind->min_included               ? at_least(kind->parameter_min, "")
                                                              : above(kind->parameter_min, "");
    fields.push_back(field(kind->parameter, spec.parameter, range));
  }
  if (spec.type == "pressure" || !spec.with.empty())
    fields.push_back(written_if(!spec.with.empty(), checked(field("with", spec.with), [&spec](const JsonReader& at) {
      if (spec.with.empty()) at.refuse("no body", "at least one, or no key");
    })));
  for (const char* key : {"rigidity", "young_modulus"}) {
    const bool has_it = kind && kind->modulus == key;
    Field modulus = moduli_field(key, spec, above(0, has_it ? kind->unit : ""));
    modulus.required = has_it && !kind->accepts_stiffness;
    if (has_it || modulus_of(spec, key)) fields.push_back(modulus);
  }
  if ((kind && !kind->shear.empty()) || spec.orthotropy) {
    const bool has_two = kind && !kind->shear.empty();
    fields.push_back(of_two_moduli(has_two ? kind->shear : "shear_modulus", spec, &Orthotropy::shear,
                                   above(0, has_two ? kind->unit : "")));
    fields.push_back(of_two_moduli("along", spec, &Orthotropy::along, any("")));
  }
  const bool has_modulus = spec.rigidity || spec.young_modulus, accepts = kind && kind->accepts_stiffness;
  if (accepts || spec.compliance)
    fields.push_back(written_if(!has_modulus, field("compliance", spec.compliance,
                                                    at_least(0,
                                                             "m/N for lengths, rad/(N m) for angles, m^5/N for "
                                                             "volumes"))));
  if (accepts)
    fields.push_back(
        written_if(!has_modulus && !spec.compliance, field("stiffness", spec.stiffness, between(0, 1, ""))));
  const bool takes_maps = kind && kind->takes_maps;
  if (takes_maps || spec.map) fields.push_back(map_field("map", spec.map, folder));
  if (takes_maps || spec.parameter_map)
    fields.push_back(map_field((kind ? kind->parameter : "parameter") + "_map", spec.parameter_map, folder));
  return fields;
}

/// Refuses what belongs to two moduli beside a single one.
void check_single_modulus(const JsonReader& at, const ConstraintSchema& kind) {
  for (const std::string& key : {kind.shear, std::string("along")})
    if (at.has(key))
      at.at(key).refuse("'" + key + "' beside a single '" + kind.modulus + "'",
                        "two moduli, \"" + kind.modulus + "\": [along, across]");
}

void check_orthotropy(const JsonReader& at, const ConstraintSchema& kind, const ConstraintSpec& spec) {
  const auto& [across, shear, along] = *spec.orthotropy;
  if (along && *along == Vec3{0, 0, 0}) at.at("along").refuse_value("a direction that is not 0");
  // The ratio the other way is that times across / along; the material is stable where their product is below 1.
  const double first = spec.rigidity ? *spec.rigidity : spec.young_modulus.value();
  const double most = kind.parameter_max * std::sqrt(first / across);
  if (spec.parameter > most)
    (at.has(kind.parameter) ? at.at(kind.parameter) : at)
        .refuse(shown(spec.parameter) + " of a material that is " + shown(across / first) +
                    " times as stiff across as along",
                "'" + kind.parameter + "' <= " + shown(most) + ", so that every strain stores energy");
}

/// Refuses maps of constraints that have no elements with a number each.
void check_takes_maps(const JsonReader& at, const ConstraintSchema& kind) {
  std::vector<std::string> names;
  for (const ConstraintSchema& other : constraint_kinds())
    if (other.takes_maps) names.push_back(other.name);
  for (const std::string& key : {std::string("map"), kind.parameter + "_map"})
    if (at.has(key) && !kind.takes_maps) at.at(key).refuse("a map of '" + kind.name + "'", "one of " + join(names));
}

void check_maps(const JsonReader& at, const ConstraintSchema& kind, const ConstraintSpec& spec) {
  if (spec.map && !spec.rigidity && !spec.young_modulus && !(spec.compliance.value_or(0) > 0))
    at.at("map").refuse(
        "'map' of a constraint that does not give way",
        "'map' beside " + (kind.modulus.empty() ? "" : "'" + kind.modulus + "' or ") + "a 'compliance' > 0");
  if (!spec.parameter_map) return;
  const std::string key = kind.parameter + "_map";
  if (spec.orthotropy)
    at.at(key).refuse("'" + key + "' beside two moduli", "one of a single '" + kind.modulus + "', or no map");
  if (spec.parameter == 0)
    at.at(key).refuse("factors of the '" + kind.parameter + "' 0", "'" + kind.parameter + "' > 0");
}

ConstraintSpec read_constraint(const JsonReader& at, const std::string& folder) {
  std::vector<std::string> names;
  for (const ConstraintSchema& kind : constraint_kinds()) names.push_back(kind.name);
  ConstraintSpec spec;
  spec.type = at.at("type").choice("constraint", names);
  const ConstraintSchema& kind = *kind_of(spec.type);
  spec.parameter = kind.parameter_default;
  if (kind.on_edges) spec.elements = {"edges"};
  if (spec.type == "pressure" && at.has("pressure"))  // the former name of the key
    at.at("pressure").refuse("'pressure', which is a ratio of volumes, not a pressure", "'volume_ratio'");
  check_takes_maps(at, kind);
  // The modulus decides, before it is read, whether the material has two of them.
  if (!kind.shear.empty() && at.has(kind.modulus) && at.at(kind.modulus).value().is_array()) spec.orthotropy.emplace();
  at.object(fields_of(spec, &kind, folder));
  if (spec.orthotropy)
    check_orthotropy(at, kind, spec);
  else if (!kind.shear.empty())
    check_single_modulus(at, kind);
  if (at.has("stiffness") && at.has("compliance"))
    at.at("compliance").refuse("both 'stiffness' and 'compliance'", "one of them");
  if (at.has(kind.modulus) && (at.has("stiffness") || at.has("compliance")))
    at.at(kind.modulus).refuse("'" + kind.modulus + "' beside 'stiffness' or 'compliance'", "one of them");
  check_maps(at, kind, spec);
  return spec;
}

Field material_field(std::string& material) {
  const auto read = [&material](const JsonReader& at) {
    std::vector<std::string> names;
    for (const Fabric& fabric : fabrics()) names.push_back(fabric.name);
    material = at.choice("material", names);
  };
  return {"material", read, false, [&material](JsonValue& json) {
            if (!material.empty()) json["material"] = material;
          }};
}

}  // namespace

Fields fields_of(BodySpec& body, const std::string& folder) {
  return {
      required(name_field(body.name)),
      required(shape_field(body.shape, ShapeUse::Body, folder)),
      part("transform", body.transform),
      rest_field(body.rest, folder),
      field("velocity", body.velocity, any("m/s")),
      field("spin", body.spin, any("rad/s")),
      field("mass", body.mass, above(0, "kg")),
      field("density", body.density, above(0, "kg/m^2 of surface, kg/m of lines, kg/m^3 of tetrahedra")),
      field("damping", body.damping, between(0, 1, "")),
      map_field("density_map", body.density_map, folder),
      map_field("friction_map", body.friction_map, folder),
      map_field("thickness_map", body.thickness_map, folder),
      pins_field(body, folder),
      attachments_field(body, folder),
      part("tear", body.tear),
      material_field(body.material),
      list(
          "constraints", body.constraints, [folder](const JsonReader& at) { return read_constraint(at, folder); },
          [folder](ConstraintSpec& spec) { return write(fields_of(spec, kind_of(spec.type), folder)); }),
  };
}

BodySpec read_body(const JsonReader& at, const std::string& folder) {
  BodySpec body;
  at.object(fields_of(body, folder));
  if (!body.material.empty()) apply_material(body, body.material);
  if (body.density && is_loose(body.shape)) {
    at.at(at.has("density") ? "density" : "material").refuse("a density of loose particles", "'mass' (kg)");
  }
  if (body.tear) {
    const bool closed = std::any_of(body.constraints.begin(), body.constraints.end(),
                                    [](const ConstraintSpec& c) { return c.type == "pressure"; });
    if (closed)
      at.at("tear").refuse("'tear' of a body with pressure", "a body without pressure, which needs a closed mesh");
    if (is_loose(body.shape)) at.at("tear").refuse("'tear' of loose particles", "a body with edges");
  }
  if (body.rest && is_loose(body.shape)) at.at("rest").refuse("'rest' of loose particles", "a body with edges");
  if (body.rest && std::holds_alternative<RestUv>(*body.rest) && !std::holds_alternative<MeshFile>(body.shape))
    at.at("rest").at("uv").refuse("'uv' beside a shape without texture coordinates",
                                  "'uv' beside 'mesh', or a list of 'points'");
  if (body.mass.has_value() == body.density.has_value()) {
    at.refuse(body.mass ? "both 'mass' and 'density'" : "neither 'mass' nor 'density'", "exactly one of them");
  }
  return body;
}

}  // namespace malha
