// SPDX-License-Identifier: Apache-2.0
// Fabrics by name: measured densities and moduli.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "malha/scene.h"

namespace malha {

/// A fabric of the database of H. Wang, J. F. O'Brien, R. Ramamoorthi, "Data-driven elastic models for cloth: modeling
/// and measurement", ACM Transactions on Graphics 30(4), 2011, which ARCSim's material files hold. scenes/README.md,
/// Fabrics by name, says how its tables became one modulus each. The database has no friction.
struct Fabric {
  const char* name;
  const char* use;                      ///< what it is sewn to, and its fibres
  double density;                       ///< kg/m^2
  std::array<double, 2> young_modulus;  ///< N/m, along and across the first direction of its tables
  double shear_modulus;                 ///< N/m
  double poisson_ratio;                 ///< contraction across over stretch along
  std::array<double, 2> rigidity;       ///< N m, along and across
  double twisting_rigidity;             ///< N m
};

const std::vector<Fabric>& fabrics();

/// Table of the fabrics in Markdown, that of scenes/README.md.
std::string fabric_table();

/// The constraints that a fabric stands for: a `membrane` and a `plate`.
std::vector<ConstraintSpec> constraints_of(const Fabric& fabric);

/// Makes a body of this fabric, as the key "material" of a scene does: the fabric's density where the body has neither
/// mass nor density, its `membrane` where no `membrane` or `distance` says how the body stretches, and its `plate`
/// where no `plate`, `bending` or `isometric_bending` says how it bends. Throws InputError for a name that no fabric
/// has.
void apply_material(BodySpec& body, const std::string& name);

}  // namespace malha
