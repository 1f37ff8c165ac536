// Settings that lie beyond a boundary where a method is known to fail, said before a scene runs. `malha study
// stability` measured the boundaries; each line names the chart that shows them.
#pragma once
#include <string>
#include <vector>

#include "host/model/model.h"

namespace malha {

/// Lines for people; none: no known boundary is crossed. Takes one look at each constraint next to a pin. `model`: of a
/// scene at its start, or what a Simulation keeps of it.
std::vector<std::string> warnings(const Model& model);

/// What one substep's projections leave of an error between particles that weigh the same, where each constraint next
/// to the pins of a body bears `load` times their weight: the strain 2 load g h^2 / (l iterations k), because each end
/// moves by half of what a link is too long by, times PBD's stiffness k a projection, and that must undo the load's
/// fall. Chains and sheets that were measured (charts masses, resolution, steps) stretch by at least that where it is
/// above a half, by three times that as they swing. 0 without pins, and with long-range attachments.
struct Sag {
  double strain = 0;
  int body = 0;
  bool soft = false;  // for its stiffness: k < 1
};
Sag worst_sag(const Model& model);

/// What rounding positions to float adds to the motion of each particle in the scene's duration, J/kg: every substep h
/// changes velocities by up to half the spacing of the numbers over h, at random (chart masses: float and double).
double rounding_energy(const Model& model);

/// The largest k h^2 / m of the springs of bodies without pins (Desbrun's method; chart torque).
double free_stiffness(const Model& model);

/// The largest g h^2 / l of the springs next to pins (Desbrun's method; chart weight).
double pinned_fall(const Model& model);

}  // namespace malha
