// SPDX-License-Identifier: Apache-2.0
// Dimensionless numbers of a scene that tell on which side of a method's known failure boundaries its settings lie.
// `malha study stability` measured the boundaries; the comments name its charts.
#pragma once
#include <string>

#include "host/model/model.h"

namespace malha {

/// Strain next to the pins of a body that the projections of one substep leave. Each constraint next to the pins bears
/// `load` times the weight of a particle, and particles weigh the same. A projection moves each end by half of the
/// constraint's error times PBD's stiffness k, and all iterations together undo the fall of the load in a substep. The
/// strain is then 2 load g h^2 / (l iterations k), with l the length of the constraint. Where the body swings down from
/// the level, it is two to five times that, and at the ends of a row of pins as much as the root of half of its n
/// constraints (measured; charts masses, resolution). Bodies that hang by springs to attachments stretch seven times as
/// much as those on pins. It is 0 without pins and attachments, and with long-range attachments. Where levels act
/// (host/model/levels.h) the coarsest level stretches like this. Each missing level means four times the load on twice
/// the length, so n levels leave a 4^n-th, and as many levels as fit leave nothing that more substeps would change.
/// Measured on 100 x 100 particles and on an irregular mesh of as many, 2 s: a peak of 6.2 and 23 with 1 level, 1.98
/// and 6.3 with 2, 0.73 and 1.8 with 3, 0.18 and 0.62 with 4; then 0.1 to 0.3 (grids), 0.3 to 0.7 (irregular), with 1
/// to 10 substeps and 65 to 200 a side, and an RMS strain of 0.006 to 0.027. Levels do not act on attachments.
struct PinStrain {
  double strain = 0, swinging = 0;  // largest strain at rest, and while it swings
  double stiffness = 1;             // k
  int body = 0;
  bool of_faces = false;         // the body has faces
  bool auto_levels_act = false;  // the path to its pins is long enough for "auto" levels
};
PinStrain worst_pin_strain(const Model& model);

/// Distance that a shear wave, sqrt(E / 3 density) m/s, travels in a substep, in cells of the tetrahedral mesh (a cell
/// has the volume of six tetrahedra), over the root of the iterations. It is the largest of all bodies of neo_hookean
/// material; 0 without any.
struct ShearWave {
  double cells = 0;
  int body = 0;
};
ShearWave fastest_shear_wave(const Model& model);

/// Excess deformation of a tetrahedral material because a substep does not converge on volumes. With Poisson's ratio nu
/// the material deforms by about s / (1 + s / 4) more, where s = cells^2 2 nu / (1 - 2 nu) and 2 nu / (1 - 2 nu) is
/// Lamé's lambda over mu. Measured: 0.6 to 1.6 of that, on beams of six tetrahedra a cell, 1 to 3 cells across, nu 0.3
/// to 0.48 and 0.1 to 0.4 cells a substep, and on a bunny of Delaunay's tetrahedra. Cells of five tetrahedra, as of
/// tet_box, do not lock and are 0.
struct VolumeSoftening {
  double share = 0;
  double poisson_ratio = 0;
  int body = 0;
};
VolumeSoftening worst_volume_softening(const Model& model);

/// Returns the largest k h^2 / m of the springs of bodies without pins (Desbrun's method; chart torque).
double max_free_stiffness(const Model& model);

/// Damping by the filter of a body's rotation about its pins (Desbrun's method; chart turning). A spring that rotates
/// with a velocity difference u is damped by h k u, as if u stretched it. For particles at distances d from the nearest
/// pin along springs that rotate as one, with velocities proportional to d, the rate of decay is h sum k (d_i - d_j)^2
/// / sum m d^2: twice the damping ratio times the frequency sqrt(g sum m d / sum m d^2). Each refinement leaves a share
/// s / (1 + s) of it, where s is h^2 / m times the sum of k of the springs next to pins. The ratio is 0 without pins or
/// gravity.
struct FilterDamping {
  double damping = 0;  // ratio to critical damping
  int body = 0;
  double kept = 0;  // s / (1 + s)
};
FilterDamping worst_filter_damping(const Model& model);

/// Returns the largest g h^2 / l of the springs next to pins (Desbrun's method; chart weight).
double pinned_spring_strain(const Model& model);

/// A sheet that hangs from a clamp, or over a line of pins, bends into the direction of gravity over a length of sqrt(D
/// / T), where D is its rigidity and T the weight that hangs there, in N/m. Where that spans fewer than two edges, the
/// dihedral angles there are larger than a plate's: a heavy elastica's drop over reach is 13 % off with 0.7 edges, and
/// 70 % where a compliance clamps it half a cell inside.
struct HangingFold {
  double length = 0;   // sqrt(D / T), m
  double spacing = 0;  // m, of the mesh across the fold
  int body = 0;
  double edges() const { return length / spacing; }
};
/// Returns the fold that spans the fewest edges; without any, `spacing` is 0. A sheet that leaves its clamp or line
/// within 30 degrees of the direction of gravity has no fold, and neither has one whose bending is not that of a
/// material.
HangingFold sharpest_fold(const Model& model);

/// A free body that falls on a lighter free body, where self-collision detects their contact. Among the pairs of bodies
/// that start one above the other with nothing between them, it is the one with the largest mass ratio. The lighter
/// body, between the heavier one and its support, opens and closes its contacts many times in each bounce. Without
/// damping, the slightest asymmetry grows tenfold in a few bounces, and the heavier body drifts off sideways. Finite
/// elements of the same bodies with steps of 4e-5 s and no internal friction drift likewise (Figures.*HeavyOnLight*);
/// they stay in place with a material relaxation time of 0.2 ms. A body that is laid on without a fall stays in place.
struct HeavyOnLight {
  double ratio = 0;  // of the masses; 0: no such pair
  int heavy = 0, light = 0;
  double drag = 0;  // N s/m of each particle, with which the heavier body stays in place
};
HeavyOnLight worst_heavy_on_light(const Model& model);

}  // namespace malha
