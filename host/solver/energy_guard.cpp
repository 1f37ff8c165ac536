// SPDX-License-Identifier: Apache-2.0
#include "host/solver/energy_guard.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "host/attachments/attachments.h"
#include "host/attachments/pose.h"
#include "host/base/disjoint_sets.h"
#include "host/mesh/vectors.h"
#include "host/model/seams.h"
#include "host/model/self_surface.h"
#include "kernels/constraints/constraint_registry.h"
#include "kernels/projection/rest.h"

namespace malha {

namespace {

/// Energy stored in one constraint, J.
template <class Kind>
double stored_in(const Model& model, const ConstraintSet& set, int c, const std::vector<Vec3>& x, double h) {
  constexpr int n = Kind::particles;
  const int* of = &set.particles[std::size_t(c) * n];
  double rest[Kind::rest_values];
  closed_rest_values<Kind>(rest_positions(model, set), c, material_of<Kind>(set, c), set.per_closing, rest);
  Vector3<double> q[n], grad[n];
  corners<Kind>(x.data(), of, q);
  if constexpr (multipliers<Kind>() > 1) {
    return set.alpha(c) > 0 ? Kind::energy(q, rest) / set.alpha(c) : 0;
  } else {
    double scale = 0, sum = 0;
    const double scaled = Kind::evaluate(q, rest, true, grad, scale);
    for (int j = 0; j < n; ++j) sum += model.w[of[j]] * dot(grad[j], grad[j]);
    if (!(sum > 0) || (Kind::inequality && scaled > 0)) return 0;
    const double alpha = set.alpha(c);
    return scaled * scaled / (2 * (alpha * scale * scale + h * h * sum));
  }
}

/// The group of each particle.
using GroupOf = std::vector<int>;
void add_stored(const Model& model, const ConstraintSet& set, const std::vector<Vec3>& x, double h, const GroupOf& of,
                std::vector<double>& sum) {
  with_kind(set.type, [&]<class Kind>(Kind) {
    for (int c = 0; c < set.count(); ++c)
      sum[of[set.particles[std::size_t(c) * Kind::particles]]] += stored_in<Kind>(model, set, c, x, h);
  });
}

void add_stored(const SpringSet& set, const std::vector<Vec3>& x, const GroupOf& of, std::vector<double>& sum) {
  for (std::size_t s = 0; s < set.ends.size(); ++s) {
    const double C = norm(minus(x[set.ends[s][0]], x[set.ends[s][1]])) - set.rest[s];
    sum[of[set.ends[s][0]]] += set.stiffness[s] * C * C / 2;
  }
}

double stored_in(const Model& model, const PressureSet& set, const std::vector<Vec3>& x, double h,
                 std::vector<Vector3<double>>& gradient) {
  const auto at = [](const std::vector<Vec3>& points, int i, const Vec3& o) {
    return Vector3<double>{points[i][0] - o[0], points[i][1] - o[1], points[i][2] - o[2]};
  };
  double rest = 0, now = 0;
  gradient.resize(x.size());
  for (const int i : set.particles) gradient[i] = {0, 0, 0};
  const std::vector<Vec3>& X = model.at_rest(set);
  const Vec3 &origin = X[set.particles[0]], &from = x[set.particles[0]];
  for (const Triangle& t : set.triangles) {
    rest += dot(cross(at(X, t[0], origin), at(X, t[1], origin)), at(X, t[2], origin)) / 6;
    Vector3<double> p[3];
    for (int k = 0; k < 3; ++k) p[k] = at(x, t[k], from);
    now += dot(cross(p[0], p[1]), p[2]) / 6;
    for (int k = 0; k < 3; ++k) gradient[t[k]] = gradient[t[k]] + cross(p[(k + 1) % 3], p[(k + 2) % 3]) * (1.0 / 6);
  }
  double sum = 0;
  for (const int i : set.particles) sum += model.w[i] * dot(gradient[i], gradient[i]);
  const double C = now - set.volume_ratio * rest, soft = set.compliance.value_or(0) + h * h * sum;
  return soft > 0 ? C * C / (2 * soft) : 0;
}

void add_stored(const Model& model, const AttachmentSet& set, const std::vector<Vec3>& x, double h, const GroupOf& of,
                std::vector<double>& sum) {
  const Pose pose = pose_at(set.target.motion, 0);
  for (const int i : set.particles) {
    const Vector3<double> a = to_world(pose, anchor_of(set.target, model.x[i]));
    const double soft = set.compliance.value_or(0) + h * h * model.w[i];
    if (soft > 0) sum[of[i]] += squared_distance(x[i], {a.x, a.y, a.z}) / (2 * soft);
  }
}

/// Largest speed on a path, m/s, of points within `radius` of the origin of the motion.
double fastest_of(const std::vector<Keyframe>& motion, double radius, double h) {
  double most = 0;
  for (std::size_t k = 1; k < motion.size(); ++k) {
    const Keyframe &a = motion[k - 1], &b = motion[k];
    const double shift = norm(minus(b.translate, a.translate));
    // Rotations about different axes are added.
    const bool same_axis = a.axis == b.axis;
    const double degrees = same_axis ? std::abs(b.degrees - a.degrees) : std::abs(a.degrees) + std::abs(b.degrees);
    most = std::max(most, (shift + degrees * 3.14159265358979 / 180 * radius) / std::max(b.time - a.time, h));
  }
  return most;
}

double farthest(const std::vector<Vec3>& points) {
  double most2 = 0;
  for (const Vec3& p : points) most2 = std::max(most2, dot(p, p));
  return std::sqrt(most2);
}

}  // namespace

namespace {

/// Joins the groups of bodies that seams connect, and numbers all from 0.
void join_sewn(const Model& model, std::vector<int>& group) {
  const std::vector<int> sewn = sewn_bodies(model);
  const int most = group.empty() ? 0 : *std::max_element(group.begin(), group.end()) + 1;
  DisjointSets joined(most);
  for (std::size_t b = 0; b < group.size(); ++b) joined.join(group[b], group[sewn[b]]);
  std::vector<int> number(most, -1);
  int next = 0;
  for (int& one : group) {
    int& own = number[joined.root(one)];
    if (own < 0) own = next++;
    one = own;
  }
}

}  // namespace

std::vector<int> groups_of(const Model& model) {
  const std::size_t bodies = model.scene.bodies.size();
  std::vector<int> group(bodies, -1);
  int groups = 0, touching = -1;
  for (std::size_t b = 0; b < bodies; ++b) {
    const bool touches = self_collides(model.scene, model.scene.bodies[b].name);
    if (touches && touching < 0) touching = groups++;
    group[b] = touches ? touching : groups++;
  }
  if (!model.scene.seams.empty()) join_sewn(model, group);
  std::vector<int> of(model.x.size());
  for (std::size_t i = 0; i < of.size(); ++i) of[i] = group[body_of(model, model.user_index[i])];
  return of;
}

std::vector<Allowance> allowances(const Model& model, const std::vector<int>& of) {
  struct Extent {
    Vec3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
    double mass = 0;
  };
  const SolverSpec& solver = model.scene.solver;
  const double driven = fastest_driven(model, solver.dt / solver.substeps), longer = std::max(solver.dt, kBrief);
  const Vec3& g = model.scene.gravity;
  std::vector<Allowance> all(of.empty() ? 0 : *std::max_element(of.begin(), of.end()) + 1);
  std::vector<Extent> bodies(model.scene.bodies.size());
  std::vector<int> group(bodies.size(), 0);
  for (std::size_t i = 0; i < of.size(); ++i) {
    const int b = body_of(model, model.user_index[i]);
    const Vec3 &x = model.x[i], &v = model.v[i];
    const double m = model.w[i] > 0 ? 1 / model.w[i] : 0;
    Allowance& one = all[group[b] = of[i]];
    one.mass += m, bodies[b].mass += m;
    for (int k = 0; k < 3; ++k) {
      one.motion += m / 2 * v[k] * v[k], one.height -= m * g[k] * x[k];
      bodies[b].low[k] = std::min(bodies[b].low[k], x[k]), bodies[b].high[k] = std::max(bodies[b].high[k], x[k]);
    }
  }
  for (std::size_t b = 0; b < bodies.size(); ++b)
    for (int k = 0; k < 3 && bodies[b].mass > 0; ++k) {
      const double slow = 0.01 * (bodies[b].high[k] - bodies[b].low[k]) / longer;
      all[group[b]].always += bodies[b].mass / 2 * slow * slow;
    }
  for (Allowance& one : all)
    one.always += one.mass / 2 * dot(g, g) * solver.dt * solver.dt + one.mass * driven * driven;
  return all;
}

void StoredEnergies::allocate(const Model& model, int groups) {
  sets_.resize(model.sets.size() + model.stencils.size() + model.springs.size() + model.pressures.size() +
               model.attached.size());
  for (OfSet& set : sets_) set.energy.reserve(static_cast<std::size_t>(groups));
  if (!model.pressures.empty()) gradient_.reserve(model.x.size());
}
void StoredEnergies::compute(const Model& model, const std::vector<Vec3>& x, double h, const GroupOf& of, int groups) {
  std::size_t count = 0;
  const auto next = [&](std::string_view kind) -> std::vector<double>& {
    sets_[count].kind = kind;
    std::vector<double>& energy = sets_[count++].energy;
    energy.assign(static_cast<std::size_t>(groups), 0);
    return energy;
  };
  for (const std::vector<ConstraintSet>* sets : {&model.sets, &model.stencils})
    for (const ConstraintSet& set : *sets) add_stored(model, set, x, h, of, next(set.type));
  for (const SpringSet& set : model.springs) add_stored(set, x, of, next(set.type));
  for (const PressureSet& set : model.pressures)
    next("pressure")[of[set.particles[0]]] = stored_in(model, set, x, h, gradient_);
  for (const AttachmentSet& set : model.attached) add_stored(model, set, x, h, of, next("attachments"));
}

double StoredEnergies::of_group(int group) const {
  double sum = 0;
  for (const OfSet& one : sets_) sum += one.energy[group];
  return sum;
}

double fastest_driven(const Model& model, double h) {
  double most = model.scene.wind ? norm(model.scene.wind->velocity) : 0;
  const bool held = !model.moved.empty() || !model.attached.empty();
  const double radius = held ? farthest(model.x) : 0;
  for (const MovedPins& pins : model.moved) {
    most = std::max(most, fastest_of(pins.target.motion, radius, h));
    if (pins.target.point) most = std::max(most, 2 * radius / h);  // moved there at once
  }
  for (const AttachmentSet& set : model.attached) most = std::max(most, fastest_of(set.target.motion, radius, h));
  return std::max(most, fastest_object(model, h));
}

double fastest_object(const Model& model, double h) {
  double most = 0;
  for (const EnvironmentMesh& object : model.environment)
    if (!object.spec.motion.empty())
      most = std::max(most, fastest_of(object.spec.motion, farthest(object.mesh.points), h));
  return most;
}

std::vector<std::int64_t> motion_change_steps(const Model& model, std::int64_t apart) {
  std::vector<std::int64_t> keyframes, turns;
  const auto step_before = [&](double time) { return std::llround(std::floor(time / model.scene.solver.dt + 1e-6)); };
  const auto note = [&](const auto& sets) {
    for (const auto& set : sets) {
      if (set.release_time) turns.push_back(step_before(*set.release_time));
      for (const Keyframe& frame : set.target.motion) keyframes.push_back(step_before(frame.time));
    }
  };
  note(model.moved), note(model.attached);
  std::sort(keyframes.begin(), keyframes.end());
  std::int64_t last = -apart;
  for (const std::int64_t step : keyframes)
    if (step >= last + apart) turns.push_back(last = step);
  std::sort(turns.begin(), turns.end());
  return turns;
}

std::string explosion(const Model& model, const Explosion& seen, const std::vector<Vec3>& x, const std::vector<Vec3>& v,
                      const StoredEnergies& before, const StoredEnergies& now) {
  int fastest = -1;
  for (std::size_t i = 0; i < v.size(); ++i)
    if (seen.of[i] == seen.group && (fastest < 0 || dot(v[i], v[i]) > dot(v[fastest], v[fastest]))) fastest = int(i);
  std::map<std::string, double> gain;
  for (std::size_t s = 0; s < now.sets().size(); ++s)
    gain[std::string(now.sets()[s].kind)] += now.sets()[s].energy[seen.group] - before.sets()[s].energy[seen.group];
  const auto most =
      std::max_element(gain.begin(), gain.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  const Vec3& at = x[fastest];
  std::string text = "motion has " + shown(seen.kinetic, 3) + " J, " + shown(seen.kinetic / seen.explained, 3) +
                     " times what anything gave it; fastest is " + particle_name(model, model.user_index[fastest]) +
                     " at (" + shown(at[0], 3) + ", " + shown(at[1], 3) + ", " + shown(at[2], 3) + "), with " +
                     shown(norm(v[fastest]), 3) + " m/s";
  if (most != gain.end()) text += "; of the constraints \"" + most->first + "\" gained most";
  return text;
}

}  // namespace malha
