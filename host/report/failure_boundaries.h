// SPDX-License-Identifier: Apache-2.0
// Numbers that compare a scene's settings with known failure boundaries of the methods. `malha study stability`
// measured the boundaries; its charts are named here.
#pragma once
#include "host/model/model.h"

namespace malha {

/// Strain that the projections of a substep leave at the pins of a body of equal particles, where each constraint next
/// to the pins bears `load` times the weight of a particle: 2 load g h^2 / (l iterations k), because each end moves by
/// half of the excess length, times PBD's stiffness k per projection, and that must undo the fall of the load. A body
/// that swings down from horizontal has two to five times that, and at the ends of a row of pins up to the root of half
/// of its n constraints (measured; charts masses, resolution); one that hangs by springs to attachments stretches seven
/// times as much as by pins. 0 without either, and with long-range attachments.
/// Where levels act (host/model/levels.h) the coarsest stretches like this, with four times the load on twice the
/// length for each that is missing: a 4^n-th with n levels, and nothing that substeps would change with as many as
/// there can be. Measured, 100 x 100 and an irregular mesh of as many, 2 s: a peak of 6.2 and 23 with 1 level, 1.98 and
/// 6.3 with 2, 0.73 and 1.8 with 3, 0.18 and 0.62 with 4; then 0.1 to 0.3 (grids), 0.3 to 0.7 (irregular), with 1 to 10
/// substeps and 65 to 200 a side, and an RMS strain of 0.006 to 0.027. They do not carry to attachments.
struct PinStrain {
  double strain = 0, swinging = 0;  // at rest, and the largest while swinging
  double stiffness = 1;             // k
  int body = 0;
  bool of_faces = false;              // a sheet's or a surface's
  bool auto_level_threshold = false;  // to its pins, so that levels would act by themselves
};
PinStrain worst_pin_strain(const Model& model);

/// How many cells of tetrahedra (as large as six of them) a shear wave, sqrt(E / 3 density) m/s, gets through in a
/// substep, over the root of its iterations, in the body of neo_hookean material where these are most. 0 without any.
struct ShearWave {
  double cells = 0;
  int body = 0;
};
ShearWave fastest_shear_wave(const Model& model);

/// Additional strain of a material of Poisson's ratio nu, over that asked for, because a substep does not fully
/// converge volumes: about s / (1 + s / 4), s = cells^2 2 nu / (1 - 2 nu), Lamé's lambda over mu: 0.6 to 1.6 of that,
/// measured on beams of six tetrahedra a cell, 1 to 3 cells across, nu 0.3 to 0.48 and 0.1 to 0.4 cells a substep, and
/// on a bunny of Delaunay's tetrahedra. Cells of five, as of tet_box, do not soften: 0 for them.
struct VolumeSoftening {
  double share = 0;
  double poisson_ratio = 0;
  int body = 0;
};
VolumeSoftening worst_volume_softening(const Model& model);

/// The largest k h^2 / m of the springs of bodies without pins (Desbrun's method; chart torque).
double free_stiffness(const Model& model);

/// Damping by the filter of bodies that swing about pins (Desbrun's method; chart turning): springs that rotate by a
/// velocity difference u damp it by h k u as if it stretched them. For particles at distances d from the nearest pin
/// along springs that rotate together, with velocities d, the rate of decay is h sum k (d_i - d_j)^2 / sum m d^2, twice
/// the ratio of damping times the frequency sqrt(g sum m d / sum m d^2). Each refinement multiplies it by s / (1 + s),
/// with s = h^2 / m sum k over the springs next to pins. 0 without pins or gravity.
struct FilterDamping {
  double damping = 0;  // of the critical
  int body = 0;
  double kept = 0;  // s / (1 + s)
};
FilterDamping worst_filter_damping(const Model& model);

/// The largest g h^2 / l of the springs next to pins (Desbrun's method; chart weight).
double pinned_fall(const Model& model);

}  // namespace malha
