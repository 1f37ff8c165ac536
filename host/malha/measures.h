// SPDX-License-Identifier: Apache-2.0
// Measures of a state, for reports and expectations.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

namespace malha {

struct Measures {
  bool has_strain = false;                   ///< whether the scene has distance constraints
  double strain_rms = 0, strain_max = 0;     ///< of |l - l0| / l0 over the distance constraints
  std::array<double, 3> momentum{};          ///< kg m/s, of the movable particles
  std::array<double, 3> angular_momentum{};  ///< kg m^2/s, about their centre of mass
  double kinetic = 0, potential = 0;         ///< J; the potential of gravity is 0 at the origin
  double elastic = 0;                        ///< J, of constraints and springs with a compliance
  double speed_max = 0;                      ///< m/s
  int contacts = 0;                          ///< with the environment that pushed in the last substep
  int self_contacts = 0;                     ///< between and within bodies that pushed in the last substep
  int edge_contacts = 0;                     ///< with edges and corners of the environment that pushed in it
  std::int64_t crossings = 0;                ///< edges that cross triangles of colliding bodies, if counted
  double penetration_max = 0;                ///< m, the largest depth below the surface of a solid
  int max_pinched = 0;                       ///< particles without a place between deforming surfaces, in any substep
  std::int64_t degenerate = 0;               ///< projections skipped for lack of a gradient
  std::vector<double> volume_ratios;         ///< volume / rest volume of each body with pressure or tetrahedra
  bool has_seams = false;
  double max_seam_gap = 0;  ///< m, the largest distance of what a seam joins; while it closes, the gap that is left
  bool has_tetrahedra = false;
  std::int64_t inverted_tetrahedra = 0;  ///< tetrahedra of negative volume
  double energy() const { return kinetic + potential + elastic; }
};

}  // namespace malha
