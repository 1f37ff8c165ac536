// SPDX-License-Identifier: Apache-2.0
// On which side of the known boundaries of the methods a scene's settings lie, in numbers. `malha study stability`
// measured the boundaries; its charts are named here.
#pragma once
#include "host/model/model.h"

namespace malha {

/// What one substep's projections leave of an error between particles that weigh the same, where each constraint next
/// to the pins of a body bears `load` times their weight: the strain 2 load g h^2 / (l iterations k), because each end
/// moves by half of what a link is too long by, times PBD's stiffness k a projection, and that must undo the load's
/// fall. Where the body swings down from the level: two to five times that, and at the ends of a row of pins as much
/// as the root of half of its n constraints (measured; charts masses, resolution); what hangs by springs to attachments
/// stretches seven times as much as by pins. 0 without either, and with long-range attachments.
/// Where levels act (host/model/levels.h) the coarsest stretches like this, with four times the load on twice the
/// length for each that is missing: a 4^n-th with n levels, and nothing that substeps would change with as many as
/// there can be. Measured, 100 x 100 and an irregular mesh of as many, 2 s: a peak of 6.2 and 23 with 1 level, 1.98 and
/// 6.3 with 2, 0.73 and 1.8 with 3, 0.18 and 0.62 with 4; then 0.1 to 0.3 (grids), 0.3 to 0.7 (irregular), with 1 to 10
/// substeps and 65 to 200 a side, and an RMS strain of 0.006 to 0.027. They do not carry to attachments.
struct Sag {
  double strain = 0, swinging = 0;  // at rest, and as it swings, at most
  double stiffness = 1;             // k
  int body = 0;
  bool of_faces = false;              // a sheet's or a surface's
  bool auto_level_threshold = false;  // to its pins, so that levels would act by themselves
};
Sag worst_sag(const Model& model);

/// How many cells of tetrahedra (as large as six of them) a shear wave, sqrt(E / 3 density) m/s, gets through in a
/// substep, over the root of its iterations, in the body of neo_hookean material where these are most. 0 without any.
struct Wave {
  double cells = 0;
  int body = 0;
};
Wave fastest_wave(const Model& model);

/// What a substep leaves of meeting volumes makes a material of Poisson's ratio nu give way more, by some
/// s / (1 + s / 4), s = cells^2 2 nu / (1 - 2 nu), Lamé's lambda over mu: 0.6 to 1.6 of that, measured on beams of six
/// tetrahedra a cell, 1 to 3 cells across, nu 0.3 to 0.48 and 0.1 to 0.4 cells a substep, and on a bunny of Delaunay's
/// tetrahedra. Cells of five, as of tet_box, find ways round it and do not: 0 for them.
struct Give {
  double share = 0;
  double poisson_ratio = 0;
  int body = 0;
};
Give most_given(const Model& model);

/// The largest k h^2 / m of the springs of bodies without pins (Desbrun's method; chart torque).
double free_stiffness(const Model& model);

/// How the filter damps what swings about pins (Desbrun's method; chart turning): springs that turn by a velocity
/// difference u take h k u of it as if it stretched them. Of particles at distances d from the nearest pin along
/// springs that turn as one, velocities d, the rate of decay is h sum k (d_i - d_j)^2 / sum m d^2, twice the ratio of
/// damping times the frequency sqrt(g sum m d / sum m d^2). Each refinement takes of it what the filter lets through,
/// the part s / (1 + s) of a fall that h^2 / m sum k of the springs next to pins, s, holds back. 0 without pins or
/// gravity.
struct Swing {
  double damping = 0;  // of the critical
  int body = 0;
  double kept = 0;  // s / (1 + s)
};
Swing most_damped_swing(const Model& model);

/// The largest g h^2 / l of the springs next to pins (Desbrun's method; chart weight).
double pinned_fall(const Model& model);

}  // namespace malha
