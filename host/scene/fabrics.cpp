// SPDX-License-Identifier: Apache-2.0
#include "malha/fabrics.h"

#include <algorithm>

#include "host/base/spelling_suggestion.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {

const std::vector<Fabric>& fabrics() {
  static const std::vector<Fabric> all{
      {"black denim",
       "jeans, 99 % cotton, 1 % spandex",
       0.324,
       {426, 2050},
       62.6,
       0.019,
       {2.42e-05, 1.6e-05},
       8.27e-06},
      {"camel ponte roma",
       "jacket, 60 % polyester, 40 % rayon",
       0.284,
       {90.7, 176},
       35.7,
       0.028,
       {9.29e-06, 9.09e-06},
       3.66e-06},
      {"gray interlock",
       "T-shirt, 60 % cotton, 40 % polyester",
       0.187,
       {49.5, 283},
       39.1,
       0.073,
       {3.57e-06, 5.8e-06},
       3.85e-06},
      {"ivory rib knit",
       "underwear, 95 % cotton, 5 % spandex",
       0.276,
       {91.5, 244},
       66.5,
       0.008,
       {8.06e-06, 1.16e-05},
       2.6e-06},
      {"navy sparkle sweat",
       "sweater, 96 % polyester, 4 % spandex",
       0.224,
       {32.9, 135},
       14.2,
       0.16,
       {1.14e-05, 1.49e-05},
       3.45e-06},
      {"pink ribbon brown", "blanket, polyester", 0.228, {256, 460}, 60.1, 0.31, {1.49e-05, 2.93e-05}, 1.08e-05},
      {"royal target",
       "trousers, 65 % cotton, 35 % polyester",
       0.22,
       {4090, 4140},
       110,
       0.01,
       {3.14e-05, 3.14e-05},
       1.13e-05},
      {"tango red jet set", "jacket, polyester", 0.113, {87, 399}, 22.4, 0.2, {5.09e-06, 3.57e-06}, 3.32e-06},
      {"white dots on black",
       "tablecloth, polyester",
       0.128,
       {4070, 4130},
       43.9,
       0.0072,
       {7.82e-06, 1.29e-05},
       4.98e-06},
      {"white swim solid",
       "swimsuit, 87 % nylon, 13 % spandex",
       0.204,
       {87.7, 212},
       53.3,
       0.13,
       {1.28e-05, 1.51e-05},
       7.75e-06},
  };
  return all;
}

std::string fabric_table() {
  std::string table =
      "| `material` | what it is sewn to | `density` (kg/m^2) | `young_modulus` (N/m) | `shear_modulus` (N/m) | "
      "`poisson_ratio` | `rigidity` (N m) | `twisting_rigidity` (N m) |\n|---|---|---|---|---|---|---|---|\n";
  for (const Fabric& of : fabrics())
    table += "| `" + std::string(of.name) + "` | " + of.use + " | " + shown(of.density) + " | " +
             shown(of.young_modulus[0]) + ", " + shown(of.young_modulus[1]) + " | " + shown(of.shear_modulus) + " | " +
             shown(of.poisson_ratio) + " | " + shown(of.rigidity[0]) + ", " + shown(of.rigidity[1]) + " | " +
             shown(of.twisting_rigidity) + " |\n";
  return table;
}

std::vector<ConstraintSpec> constraints_of(const Fabric& fabric) {
  ConstraintSpec membrane, plate;
  membrane.type = "membrane", membrane.parameter = fabric.poisson_ratio;
  membrane.young_modulus = fabric.young_modulus[0];
  membrane.orthotropy = Orthotropy{fabric.young_modulus[1], fabric.shear_modulus};
  plate.type = "plate", plate.parameter = 0;  // the database has no Poisson's ratio of bending
  plate.rigidity = fabric.rigidity[0];
  plate.orthotropy = Orthotropy{fabric.rigidity[1], fabric.twisting_rigidity};
  return {membrane, plate};
}

void apply_material(BodySpec& body, const std::string& name) {
  const auto fabric = std::ranges::find(fabrics(), name, &Fabric::name);
  if (fabric == fabrics().end()) {
    std::vector<std::string> names;
    for (const Fabric& known : fabrics()) names.push_back(known.name);
    throw InputError("body '" + body.name + "': found unknown material '" + name + "'" + did_you_mean(name, names) +
                     "; allowed: " + join(names));
  }
  body.material = name;
  if (!body.mass && !body.density) body.density = fabric->density;
  const auto has = [&](const std::vector<std::string>& types) {
    return std::ranges::any_of(
        body.constraints, [&](const ConstraintSpec& own) { return std::ranges::find(types, own.type) != types.end(); });
  };
  const bool stretches = has({"membrane", "distance"}), bends = has({"plate", "bending", "isometric_bending"});
  const std::vector<ConstraintSpec> own = constraints_of(*fabric);
  if (!stretches) body.constraints.push_back(own[0]);
  if (!bends) body.constraints.push_back(own[1]);
}

}  // namespace malha
