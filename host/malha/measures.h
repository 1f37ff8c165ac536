// SPDX-License-Identifier: Apache-2.0
// A state measured, for reports and expectations.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

namespace malha {

struct Measures {
  bool has_strain = false;                   ///< whether there are distance constraints
  double strain_rms = 0, strain_max = 0;     ///< of |l - l0| / l0 over them
  std::array<double, 3> momentum{};          ///< kg m/s, movable particles
  std::array<double, 3> angular_momentum{};  ///< kg m^2/s about the centre of mass
  double kinetic = 0, potential = 0;         ///< J; gravity's potential is 0 at the origin
  double elastic = 0;                        ///< J, in constraints and springs with a compliance
  double speed_max = 0;                      ///< m/s
  int contacts = 0;                          ///< that pushed in the last substep
  int self_contacts = 0;                     ///< of bodies among themselves, that pushed in the last substep
  int edge_contacts = 0;                     ///< with edges and corners of the environment, in the last substep
  std::int64_t crossings = 0;                ///< of edges with triangles, of bodies that collide; counted apart
  double penetration_max = 0;                ///< m below the surface of a solid
  std::int64_t degenerate = 0;               ///< constraints without a direction, skipped
  std::vector<double> volume_ratios;         ///< volume / rest volume, a number a body with pressure, tetrahedra
  bool has_tetrahedra = false;
  std::int64_t inverted_tetrahedra = 0;  ///< of negative volume
  double energy() const { return kinetic + potential + elastic; }
};

}  // namespace malha
