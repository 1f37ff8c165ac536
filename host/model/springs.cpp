#include "host/model/springs.h"

#include <cmath>

#include "host/mesh/vectors.h"
#include "kernels/constraints.h"
#include "kernels/rest.h"

namespace malha {

namespace {

double square(double a) { return a * a; }

struct Hinge {
  double span;     // from wing to wing when the hinge is at its rest angle
  double heights;  // of both wings over the edge
};

Hinge hinge(const std::vector<Vec3>& X, const int* particles, double rest_scale) {
  const double theta = rest_value<Bending>(X.data(), particles, rest_scale);
  Vector3<double> q[4];
  corners<Bending>(X.data(), particles, q);
  const Vector3<double> e = q[1] - q[0];
  const double length = std::sqrt(dot(e, e));
  if (!(length > 0)) return {distance(X[particles[2]], X[particles[3]]), 0};
  const Vector3<double> along = e * (1 / length), a = q[2] - q[0], b = q[3] - q[0];
  const double slide = dot(a, along) - dot(b, along);
  const Vector3<double> up = a - along * dot(a, along), down = b - along * dot(b, along);
  const double h = std::sqrt(dot(up, up)), k = std::sqrt(dot(down, down));
  return {std::sqrt(slide * slide + h * h + k * k + 2 * h * k * std::cos(theta)), h + k};
}

}  // namespace

SpringSet springs_of(const ConstraintSpec& spec, double full, const std::vector<int>& particles,
                     const std::vector<double>& softness, const std::vector<Vec3>& X) {
  SpringSet set{spec.type, {}, {}, {}};
  const bool isometric = spec.type == IsometricBending::name, bends = isometric || spec.type == Bending::name;
  const int arity = bends ? 4 : 2;
  for (std::size_t c = 0; c < particles.size() / arity; ++c) {
    const int* of = &particles[c * arity];
    double alpha = spec.rigidity ? softness[c] / *spec.rigidity : spec.compliance.value_or(0);
    if (isometric) alpha /= square(distance(X[of[0]], X[of[1]]));  // of the angle instead of the fold
    const Edge ends = bends ? Edge{of[2], of[3]} : Edge{of[0], of[1]};
    const Hinge at = bends ? hinge(X, of, spec.parameter) : Hinge{};
    if (ends[0] == ends[1] || (bends && !(at.heights > 0))) continue;  // nothing that could bend
    const double rest = bends ? at.span : spec.parameter * distance(X[ends[0]], X[ends[1]]);
    double k = spec.compliance || spec.rigidity ? full : spec.stiffness * full;
    if (alpha > 0) k = bends ? 4 / (alpha * at.heights * at.heights) : 1 / alpha;
    if (!(k > 0)) continue;
    set.ends.push_back(ends), set.stiffness.push_back(k), set.rest.push_back(rest);
  }
  return set;
}

}  // namespace malha
